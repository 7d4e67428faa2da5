"""A run as the panels of its page use it."""

from __future__ import annotations

import asyncio
from collections.abc import (
    Awaitable,
    Callable,
    Coroutine,
    Mapping,
    MutableMapping,
)
from contextlib import suppress
from functools import partial
from typing import Any, Protocol, TypeVar

from nicegui import Client, app, background_tasks, ui
from nicegui.element import Element

from rodgen.errors import InputError
from rodgen.scene import Scene, Structure
from rodgen.system import System
from rodgen_live.page.sweep_diagram import Diagram
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.scene_text import SceneFolder, edited_text

VIEW, PANEL = "view", "panel"  # chosen by the tab of a browser, which keeps them over a reload

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


class PageRun:
    """A run and the page that shows it; when something has changed, all panels are refreshed.

    make: makes the module of a scene; root: the element that dialogs are built in; tab: what the
    tab of the browser remembers over a reload; folder: scenes to choose from.

    A system is changed in the run's own thread, by a function from the system that is there: what
    comes between, from elsewhere on the page, is not lost.
    """

    def __init__(
        self,
        run: LiveRun,
        make: Make,
        client: Client,
        root: Element,
        tab: MutableMapping[str, Any],
        folder: SceneFolder,
    ):
        self.run, self.client, self.root, self.tab = run, client, root, tab
        self.folder = folder
        self.panels: tuple[Panel, ...] = ()
        self.diagrams: dict[str, Diagram] = {}  # of sweeps, among the plots
        self._make, self._making = make, asyncio.Lock()

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

    async def call(self, work: Callable[[], T]) -> T:
        """Run work in the run's thread, and wait for its result."""
        return await asyncio.wrap_future(self.run.submit(work))

    def submit(self, work: Callable[[], Any]) -> None:
        """Run work in the run's thread without waiting for it; a refusal is shown."""
        self.start_task(self.call(work))

    def start_task(self, doing: Coroutine[Any, Any, object]) -> None:
        """Start a coroutine without waiting for it; a refusal is shown."""

        async def report_refusal() -> None:
            try:
                await doing
            except InputError as error:
                self.notify(str(error))

        background_tasks.create(report_refusal(), context=self.client)

    async def change(self, changes: Mapping[str, Any], what: str) -> None:
        """Change values of keys of the scene; what: in words, for the record. Raises InputError."""
        await self.change_system(
            lambda system: system.at(changes),
            lambda system: self.run.change(system, what),
            lambda before: self.run.undo.note(before, what),
        )

    async def run_scene(self, scene: Scene) -> None:
        """Run another scene, from its start. Raises InputError."""
        await self.change_system(
            lambda _: System(scene),
            self.run.switch_to,
            lambda before: self.run.undo.note_scene(before, scene),
        )

    async def run_text(self, text: str) -> Scene:
        """Run the scene of a text, from its start. Raises InputError."""
        scene = await asyncio.to_thread(self.folder.parse, text)
        self.run.texts[scene] = text
        await self.run_scene(scene)
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

        await self.change_system(
            lambda _: kept.system, act, lambda before: undo.note_move(before, forth)
        )

    async def change_system(
        self, edit: Edit, act: Callable[[System], object], note: Callable[[System], object]
    ) -> None:
        """Change to the system that `edit` makes of the present one: `act` is given it in the run's
        thread if its module is that of the run; else that is made first, and the system begins from
        its start. `note` is given the system before, after success. Raises InputError."""
        if await self._try_change(edit, act, note) is None:
            return
        async with self._making:
            made = None
            while (
                wanted := await self._try_change(edit, self.run.switch_to, note, made)
            ) is not None:
                await self._make(wanted.scene)
                made = wanted.structure

    async def allow_pulls(self) -> None:
        """Make the module by which the rod can be pulled, and let the run go on by it. Raises
        InputError."""
        if await self.call(self.run.allow_pulls) is None:
            return
        async with self._making:
            made = None
            while (wanted := await self.call(partial(self.run.allow_pulls, made))) is not None:
                await self._make(wanted.scene)
                made = wanted.structure

    async def _try_change(
        self,
        edit: Edit,
        act: Callable[[System], object],
        note: Callable[[System], object],
        made: Structure | None = None,
    ) -> System | None:
        """Change the system, and return None; or return the system whose module is to be made
        first. made: the structure of a module that is there, beside that of the run."""

        def work() -> System | None:
            before = self.run.live.system
            system = edit(before)
            if system.structure not in (made, before.structure):
                return system
            act(system)
            note(before)
            self.run.told()
            return None

        return await self.call(work)
