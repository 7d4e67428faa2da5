"""Mode shapes drawn over the rod, about the state that is shown."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from nicegui import ui

from rodgen_live.page.fields import IconButton
from rodgen_live.page.page_run import PageRun
from rodgen_live.run.run_thread import from_threads
from rodgen_live.run.worker_process import ASIDE, Answer, PendingRequest

COMPUTING = ""  # in the list, while there are no modes
AGAIN = 0.3  # seconds after which another state is looked for
RESTS = 3  # times as long as modes took to be computed, until others are


class ModePanel:
    """A button that has modes computed and shown, or takes them away, and a list of them beside it.
    While they are shown, they follow the state that the page looks at, and the scene."""

    def __init__(self, page: PageRun, show: Callable[[dict[str, Any] | None], object]):
        """Build the button; show: draws displacements {re, im: x0, y0, ..., text}, or none."""
        self.page, self._show = page, show
        self._errand: PendingRequest | None = None
        self._of: object = None  # the state and the system of the errand, or of the modes
        self._begun = self._due = 0.0
        self._modes: list[dict[str, Any]] = []
        IconButton("waves", "Mode shapes about the present state", self._toggle)
        self.list = ui.select({}, label="Mode", on_change=self._show_choice).classes("rg-mode")
        self.list.set_visibility(False)
        self._timer = ui.timer(AGAIN, self._request_modes, active=False)
        page.client.on_delete(self._cancel)

    def hide(self) -> None:
        """Hide the modes, and compute no others."""
        self._cancel()
        self._of, self._modes = None, []
        self._timer.deactivate()
        self.list.set_visibility(False)
        self._show(None)

    def _cancel(self) -> None:
        if self._errand is not None:
            self._errand.cancel()
            self._errand = None

    def _toggle(self) -> None:
        if self._timer.active:
            self.hide()
            return
        self._due = 0.0
        self.list.set_options({COMPUTING: "computing"}, value=COMPUTING)
        self.list.set_visibility(True)
        self._timer.activate()

    async def _request_modes(self) -> None:
        """Request the modes of the state that is shown, if the present ones are of another."""
        if self._errand is not None or time.monotonic() < self._due:
            return
        run = self.page.run
        seen, begun, system = await self.page.call(
            lambda: (run.page_sample, run.begun, run.live.system_with_support)
        )
        t, y, p = float(seen.t[-1]), seen.y[-1].tolist(), seen.p.tolist()
        if not self._timer.active or self._of == (of := (t, p, begun, system)):
            return
        self._of, self._begun = of, time.monotonic()
        receive = from_threads(self._receive)
        self._errand = ASIDE.submit("modes", system.scene, receive, t=t, y=y, p=p)

    def _receive(self, answer: Answer) -> None:
        if self._errand is None or self.page.client.is_deleted:
            return
        with self.page.client:
            if answer.refused:
                self.hide()
                self.page.notify(answer.refused)
            elif answer.value is not None:
                now, self._errand = time.monotonic(), None
                self._due = now + RESTS * (now - self._begun)
                self._list_modes(answer.value)

    def _list_modes(self, modes: list[dict[str, Any]]) -> None:
        """List these modes, and show the one with the number that was chosen before."""
        number = min(int(self.list.value or 0), len(modes) - 1)
        self._modes = modes
        names = {str(at): mode["name"] for at, mode in enumerate(modes)}
        if modes:
            self.list.set_options(names, value=str(number))
        else:
            self.list.set_options({COMPUTING: "nothing oscillates"}, value=COMPUTING)
        self._show_choice()

    def _show_choice(self) -> None:
        at = self.list.value
        self._show(self._modes[int(at)] if at and self._modes else None)
