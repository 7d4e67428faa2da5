"""How far a module is that is being made."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui

from rodgen.scene import Scene

PATIENCE = 0.3  # seconds without a word


class Progress:
    """A dialog with what is being done and for how long, in the way of nothing but itself."""

    def __init__(self) -> None:
        with ui.element("div").classes("rg-making").props('role="status"') as self._box:
            ui.spinner(size="1.2em")
            self._text = ui.label()
        self._box.set_visibility(False)
        self._stage, self._since = "", 0.0
        self._clock = ui.timer(0.25, self._tick, active=False)

    @contextmanager
    def __call__(self, scene: Scene) -> Iterator[None]:
        """While it lasts, the stage is shown."""
        self._what = f"{scene.name}, {scene.rod.links} links"
        self._stage, self._since = "preparing", time.monotonic()
        self._clock.activate()
        try:
            yield
        finally:
            self._clock.deactivate()
            self._box.set_visibility(False)

    def stage(self, text: str) -> None:
        """What is done now."""
        self._stage = text

    def _tick(self) -> None:
        took = time.monotonic() - self._since
        self._text.set_text(f"{self._what}: {self._stage}, {took:.0f} s")
        self._box.set_visibility(took > PATIENCE)
