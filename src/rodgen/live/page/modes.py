"""Mode shapes drawn over the rod, about the state that it has when they are asked for."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from nicegui import background_tasks, ui

from rodgen.live.page.fields import IconButton
from rodgen.live.page.runs import PageRun
from rodgen.live.run.aside import ASIDE, Answer, Errand

COMPUTING = ""  # in the list, until there are modes
ASKED = "Mode shapes about the present state"


class ModeShapes:
    """A button that has modes computed and shown, or takes them away; a list of them beside it."""

    def __init__(self, page: PageRun, show: Callable[[dict[str, Any] | None], object]):
        """show: draws a mode, {re, im: displacements of the joints, x0, y0, ..., text}, or none."""
        self.page, self._show = page, show
        self._errand: Errand | None = None
        self._modes: list[dict[str, Any]] = []
        IconButton("waves", ASKED, self._toggle)
        self.list = ui.select({}, label="Mode", on_change=self._chosen)
        self.list.props("dense outlined options-dense").classes("rg-mode")
        self.list.set_visibility(False)
        page.client.on_delete(self._drop)

    def hide(self) -> None:
        """Show none: they belong to another rod."""
        self._drop()
        self._modes = []
        self.list.set_visibility(False)
        self._show(None)

    def _drop(self) -> None:
        if self._errand is not None:
            self._errand.drop()
            self._errand = None

    def _toggle(self) -> None:
        if self._modes or self._errand:
            self.hide()
            return
        self.list.set_options({COMPUTING: "computing"}, value=COMPUTING)
        self.list.set_visibility(True)
        loop, run = asyncio.get_running_loop(), self.page.run

        def told(answer: Answer) -> None:
            loop.call_soon_threadsafe(self._take, answer)

        async def ask() -> None:
            t, y = await self.page.do(lambda: (float(run.seen.t[-1]), run.seen.y[-1].tolist()))
            self._errand = ASIDE.ask("modes", self.page.scene, told, t=t, y=y)

        background_tasks.create(ask(), context=self.page.client)

    def _take(self, answer: Answer) -> None:
        if self._errand is None or self.page.client.is_deleted:
            return
        if answer.refused:
            with self.page.client:
                self.hide()
            self.page.say(answer.refused)
        elif answer.value is not None:
            self._errand, self._modes = None, answer.value
            with self.page.client:
                self._offer()

    def _offer(self) -> None:
        if not self._modes:
            self.hide()
            self.page.say("Nothing oscillates about this state")
            return
        names = {str(at): mode["name"] for at, mode in enumerate(self._modes)}
        self.list.set_options(names, value="0")
        self._show(self._modes[0])

    def _chosen(self) -> None:
        if self._modes and self.list.value != COMPUTING:
            self._show(self._modes[int(self.list.value)])
