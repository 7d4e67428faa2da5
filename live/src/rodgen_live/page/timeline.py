"""The time line under the rod; the channel carries where on it the page looks."""

from __future__ import annotations

import math

from nicegui.element import Element

from rodgen_live.page.elements import STATIC
from rodgen_live.page.page_run import PageRun


class TimeLine(Element, component=STATIC / "timeline.js"):
    """A slider over the samples of the run with the changes and kicks marked on it, steps of a
    sample to either side, and a loop from A to B.

    Props: speed [simulated seconds per second] at which it plays.
    Keys, on the slider: see page/shortcuts.py.
    """

    def __init__(self, page: PageRun):
        super().__init__()
        self._page, self._speed = page, math.nan

    def refresh(self) -> None:
        """Play at the speed of the run, or in real time where that runs as fast as it goes."""
        speed = self._page.run.pace.speed
        speed = speed if math.isfinite(speed) else 1.0
        if speed != self._speed:
            self._speed = self._props["speed"] = speed
