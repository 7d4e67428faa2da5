"""How far a module is that is being made."""

from __future__ import annotations

import asyncio
import time

from nicegui import ui

from rodgen.scene import Scene, SceneError
from rodgen.view.live.web.making import make

PATIENCE = 0.3  # seconds without a word


class Progress:
    """Says what is being made and for how long, and lets it be cancelled; the rest of the page
    stays as alive as it was."""

    def __init__(self) -> None:
        with ui.element("div").classes("rg-making").props('role="status"') as self._box:
            ui.spinner(size="1.2em")
            self._text = ui.label()
            ui.button("Cancel", on_click=self._cancel).props("flat dense no-caps")
        self._box.set_visibility(False)
        self._what = self._stage = ""
        self._cancelled = self._closed = False
        self._since = 0.0
        self._task: asyncio.Task[None] | None = None
        self._clock = ui.timer(0.25, self._tick, active=False)

    async def make(self, scene: Scene) -> None:
        """Have the module of a scene in the cache. Raises SceneError where it cannot be made, or
        was not to be."""
        links = scene.rod.links
        self._what = f"{scene.name}, {links} link{'s' if links > 1 else ''}"
        if self._closed:
            raise self._refusal()
        self._stage, self._since, self._cancelled = "preparing", time.monotonic(), False
        self._clock.activate()
        self._task = asyncio.create_task(make(scene.structure, self._at))
        try:
            await self._task
        except asyncio.CancelledError:
            if not self._cancelled:  # it is the server that ends
                raise
            raise self._refusal() from None
        finally:
            self._clock.deactivate()
            if not self._closed:
                self._box.set_visibility(False)

    def _refusal(self) -> SceneError:
        return SceneError("module", self._what, "compiled first, which was cancelled")

    def close(self) -> None:
        """The page is gone: nothing is made for it any more."""
        self._closed = True
        self._cancel()

    def _cancel(self) -> None:
        if self._task is not None:
            self._cancelled = True
            self._task.cancel()

    def _at(self, stage: str) -> None:
        self._stage = stage

    def _tick(self) -> None:
        took = time.monotonic() - self._since
        self._text.set_text(f"{self._what}: {self._stage}, {took:.0f} s")
        self._box.set_visibility(took > PATIENCE)
