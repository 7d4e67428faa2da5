"""The page of a run: its parts, and what they share."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.resources import files
from typing import Any, TypeVar

from nicegui import app, background_tasks, ui

from rodgen.scene import Scene, SceneError
from rodgen.view.live.edits import Path, edited
from rodgen.view.live.run import LiveRun
from rodgen.view.live.scenes import Folder, unpacked
from rodgen.view.live.web.bar import Bar
from rodgen.view.live.web.channel import ADDRESS
from rodgen.view.live.web.elements import Channel
from rodgen.view.live.web.making import make
from rodgen.view.live.web.parameters import Parameters
from rodgen.view.live.web.plots import PlotsPanel
from rodgen.view.live.web.progress import Progress
from rodgen.view.live.web.rod import RodPanel
from rodgen.view.live.web.saving import Saving
from rodgen.view.live.web.sessions import Sessions
from rodgen.view.live.web.structure import StructurePanel
from rodgen.view.live.web.values import Values

RUN = "run"  # what a tab remembers
T = TypeVar("T")


class Page:
    """One page, one run.

    Its parts call `do` for what is for the run's thread, and `apply` for another scene; when
    something has changed, all of them are told by `refresh`.
    """

    run: LiveRun

    def __init__(self, sessions: Sessions, folder: Folder, first: Scene):
        self.sessions, self.folder, self._first = sessions, folder, first
        self._parts: list[Any] = []
        self._making = asyncio.Lock()

    @property
    def scene(self) -> Scene:
        """As it is now."""
        return self.run.live.scene

    async def show(self, packed: str) -> None:
        """Build the page: of the run that this tab had, of a scene in the address, or of the first
        scene."""
        self.client = ui.context.client
        ui.add_css(files(__package__).joinpath("static/page.css").read_text(encoding="utf-8"))
        self.root = ui.element("main").classes("rg-page")
        self.progress = Progress()
        await self.client.connected()
        tab = app.storage.tab
        known = self.sessions.get(tab.get(RUN))
        asked = (packed, tab.get("packed"))
        if known is not None and not known.page.watched and asked[0] in ("", asked[1]):
            self.name, self.run = str(tab[RUN]), known
        elif not await self._begin(packed):
            return
        tab[RUN], tab["packed"] = self.name, packed
        self._build()
        self._listen()

    async def _begin(self, packed: str) -> bool:
        """A run of its own."""
        try:
            scene = unpacked(packed) if packed else self._first
        except SceneError as error:
            self.say(f"The scene in the address cannot be used: {error}")
            scene = self._first
        try:
            self.sessions.check_room()
            with self.progress(scene):
                await make(scene.structure, self.progress.stage)
            self.name = await asyncio.to_thread(self.sessions.open, scene)
        except SceneError as error:
            with self.root:
                ui.label(str(error)).classes("rg-failed")
            return False
        run = self.sessions.get(self.name)
        assert run is not None
        self.run = run
        return True

    def _build(self) -> None:
        with self.root:
            Channel(ADDRESS + self.name)
            self.bar = Bar(self)
            with ui.element("div").classes("rg-columns"):
                with ui.element("div").classes("rg-left"):
                    self.rod = RodPanel(self)
                    self.plots = PlotsPanel(self)
                with (
                    ui.element("aside")
                    .classes("rg-right")
                    .props('aria-label="Values and settings"')
                ):
                    self._tabs()
        self._parts = [self.bar, self.rod, self.plots, self.values, self.parameters, self.structure]

    def _tabs(self) -> None:
        with ui.tabs().props("dense no-caps align=justify") as tabs:
            values, parameters = ui.tab("Values"), ui.tab("Parameters")
            scene, save = ui.tab("Scene"), ui.tab("Save")
        with (
            ui.tab_panels(tabs, value=parameters, animated=False)
            .props("keep-alive")
            .classes("rg-panels")
        ):
            with ui.tab_panel(values):
                self.values = Values(self)
            with ui.tab_panel(parameters):
                self.parameters = Parameters(self)
            with ui.tab_panel(scene):
                self.structure = StructurePanel(self)
            with ui.tab_panel(save):
                self.saving = Saving(self)

    def _listen(self) -> None:
        """Be told by the run, from its thread."""
        loop = asyncio.get_running_loop()

        def told() -> None:
            with suppress(RuntimeError):  # the server is ending
                loop.call_soon_threadsafe(self.refresh)

        self.run.told = told
        self.refresh()

    def refresh(self) -> None:
        """Something has changed."""
        if self.client.is_deleted:
            return
        with self.client:
            for part in self._parts:
                part.refresh()

    # For the parts -----------------------------------------------------------------------------

    def say(self, text: str, kind: Any = "warning") -> None:
        """A message that goes away by itself."""
        with self.client:
            ui.notify(text, type=kind, multi_line=True, close_button="Close", timeout=8000)

    async def do(self, work: Callable[[], T]) -> T:
        """Have the run's thread do something."""
        return await asyncio.wrap_future(self.run.do(work))

    def soon(self, work: Callable[[], Any]) -> None:
        """The same, from a handler that does not wait; what is refused is said."""

        async def doing() -> None:
            try:
                await self.do(work)
            except SceneError as error:
                self.say(str(error))

        background_tasks.create(doing())

    async def change(self, changes: Sequence[tuple[Path, Any]], what: str) -> None:
        """Other values in the scene, in words for the record. Raises SceneError."""
        await self.apply(edited(self.scene, changes), what)

    async def apply(self, scene: Scene, what: str = "") -> None:
        """Another scene: taken up while it runs where the module stays, else from its start.
        Raises SceneError."""
        if scene.structure == self.scene.structure:
            await self.do(lambda: self.run.change(scene, what))
        else:
            await self.take(scene)

    async def take(self, scene: Scene) -> None:
        """Another scene, from its start; its module is made first. Raises SceneError."""
        async with self._making:
            with self.progress(scene):
                await make(scene.structure, self.progress.stage)
                await self.do(lambda: self.run.take(scene))
