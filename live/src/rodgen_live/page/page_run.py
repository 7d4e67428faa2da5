"""A run as the panels of its page use it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Mapping, MutableMapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ParamSpec, Protocol, TypeVar

from nicegui import Client, app, background_tasks, ui
from nicegui.element import Element

from rodgen.errors import InputError
from rodgen.scene import Scene, Structure
from rodgen.system import System
from rodgen_live.page.sweep_diagram import Diagram
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.scene_text import SceneFolder, edited_text

VIEW, PANEL = "view", "panel"  # chosen by the tab of a browser, which keeps them over a reload

P = ParamSpec("P")
T = TypeVar("T")
Edit = Callable[[System], System]
Make = Callable[[Scene], Awaitable[None]]


class Panel(Protocol):
    """Interface of a part of the page."""

    def refresh(self) -> None:
        """Show the run as it is now."""


def notify(client: Client, text: str) -> None:
    """Show a passing message on a page."""
    if client.is_deleted:
        return
    with client:
        ui.notify(text, type="warning", multi_line=True, close_button="Close", timeout=8000)


@dataclass(eq=False)
class PageRun:
    """A run and the page that shows it; when something has changed, all panels are refreshed.

    make: makes the module of a scene; root: the element that dialogs are built in; tab: what the
    tab of the browser remembers over a reload; folder: scenes to choose from.

    A system is changed in the run's own thread, by a function from the system that is there: what
    comes between, from elsewhere on the page, is not lost.
    """

    run: LiveRun
    make: Make
    client: Client
    root: Element
    tab: MutableMapping[str, Any]
    folder: SceneFolder
    panels: tuple[Panel, ...] = ()
    diagrams: dict[str, Diagram] = field(default_factory=dict)  # of sweeps, among the plots
    _making: asyncio.Lock = field(default_factory=asyncio.Lock)

    @property
    def scene(self) -> Scene:
        """The scene as it is now."""
        return self.run.live.scene

    @property
    def text(self) -> str:
        """Text of the scene as it is now: that of its file, with the values that are others."""
        scene, file = self.scene, self.run.undo.file
        known = self.run.texts.get(file)
        if known is None or scene == file:
            return known or scene.to_toml()
        text = edited_text(known, file, scene)
        with suppress(InputError):
            if self.folder.parse(text) == scene:
                return text
        return scene.to_toml()

    def refresh(self) -> None:
        """Refresh all panels."""
        if self.client.is_deleted:
            return
        with self.client:
            try:
                for panel in self.panels:
                    panel.refresh()
            except Exception as error:  # a defect: the page says so, and stays
                app.handle_exception(error)

    def notify(self, text: str) -> None:
        """Show a passing message."""
        notify(self.client, text)

    async def call(self, work: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
        """Run work in the run's thread, and wait for its result."""
        return await asyncio.wrap_future(self.run.submit(partial(work, *given, **named)))

    def submit(self, work: Callable[P, Any], *given: P.args, **named: P.kwargs) -> None:
        """Run work in the run's thread without waiting for it; a refusal is shown."""
        self.start_task(self.call(work, *given, **named))

    def start_task(self, doing: Coroutine[Any, Any, object]) -> None:
        """Start a coroutine without waiting for it; a refusal is shown."""

        async def report_refusal() -> None:
            try:
                await doing
            except InputError as error:
                self.notify(str(error))

        background_tasks.create(report_refusal(), context=self.client)

    async def change(
        self, changes: Mapping[str, Any], what: str, y0: Sequence[float] | None = None
    ) -> None:
        """Change values of keys of the scene; what: in words, for the record; y0: the state in
        which the run begins anew. Raises InputError."""
        await self.change_system(lambda system: system.at(changes, y0=y0), what, y0 is not None)

    async def change_system(self, edit: Edit, what: str, anew: bool) -> None:
        """Change to the system that `edit` makes of the present one; what: in words; anew: the run
        begins at its start. Raises InputError."""
        run = self.run
        await self._change(
            edit,
            run.restart if anew else lambda system: run.change(system, what),
            lambda before: run.undo.note(before, what, anew),
        )

    async def run_text(self, text: str) -> Scene:
        """Run the scene of a text, from its start. Raises InputError."""
        scene = await asyncio.to_thread(self.folder.parse, text)
        self.run.texts[scene] = text
        await self._change(
            lambda _: System(scene),
            self.run.switch_to,
            lambda before: self.run.undo.note_scene(before, scene),
        )
        return scene

    async def undo(self, forth: bool = False) -> None:
        """Go back to the system before the last change, or before the last kick or pull; or forth
        again. Raises InputError."""
        run, undo = self.run, self.run.undo
        if (kept := undo.next_state(forth)) is None:
            return
        said = "redo" if forth else "undo"

        def act(system: System) -> None:
            if kept.mark is not None:
                run.go_back_to(kept.mark)
            elif kept.anew:
                run.switch_to(system)
            else:
                run.change(system, said)

        await self._change(lambda _: kept.system, act, lambda now: undo.note_move(now, forth))

    async def _change(
        self, edit: Edit, act: Callable[[System], object], note: Callable[[System], object]
    ) -> None:
        """Change to the system that `edit` makes of the present one: `act` is given it in the run's
        thread if its module is that of the run; else that is made first, and the system begins from
        its start. `note` is given the system before, after success. Raises InputError."""

        def work(made: Structure | None) -> System | None:
            before = self.run.live.system
            system = edit(before)
            if system.structure == before.structure:
                act(system)
            elif system.structure == made:
                self.run.switch_to(system)
            else:
                return system
            note(before)
            self.run.told()
            return None

        await self._with_module(work)

    async def allow_pulls(self) -> None:
        """Make the module by which the rod can be pulled, and let the run go on by it. Raises
        InputError."""
        await self._with_module(self.run.allow_pulls)

    async def _with_module(self, work: Callable[[Structure | None], System | None]) -> None:
        """Run work in the run's thread, which returns a system whose module is to be made before
        it is run again, or None; it is given the structure of the one that was made."""
        if await self.call(work, None) is None:
            return
        async with self._making:
            made = None
            while (wanted := await self.call(work, made)) is not None:
                await self.make(wanted.scene)
                made = wanted.structure
