"""The page of a run: its parts, and what they share."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from importlib.resources import files
from typing import Any

from nicegui import app, ui

from rodgen.scene import Scene, SceneError
from rodgen.view.live.run import LiveRun
from rodgen.view.live.scenes import Folder, unpacked
from rodgen.view.live.web.bar import Bar
from rodgen.view.live.web.channel import ADDRESS
from rodgen.view.live.web.elements import Channel
from rodgen.view.live.web.parameters import Parameters
from rodgen.view.live.web.plots import PlotsPanel
from rodgen.view.live.web.progress import Progress
from rodgen.view.live.web.rod import VIEW, RodPanel
from rodgen.view.live.web.saving import Saving
from rodgen.view.live.web.sessions import Sessions
from rodgen.view.live.web.shade import as_before
from rodgen.view.live.web.shared import Shared
from rodgen.view.live.web.structure import StructurePanel
from rodgen.view.live.web.values import Values

RUN, PANEL = "run", "panel"  # what a tab of the browser remembers, beside VIEW
# The token is kept by a cookie: it is not to be copied with the address.
FORGET_TOKEN = """
    const url = new URL(location.href);
    url.searchParams.delete("token");
    history.replaceState(null, "", url);
"""


class Page(Shared):
    """One page, one run; when something has changed, all parts are told by `refresh`."""

    def __init__(self, sessions: Sessions, folder: Folder, first: Scene):
        super().__init__()
        self.sessions, self.folder, self._first = sessions, folder, first
        self._parts: list[Any] = []

    async def show(self, packed: str) -> None:
        """Build the page: of the run that this tab had, of a scene in the address, or of the first
        scene."""
        self.client = ui.context.client
        self.client.on_exception(lambda error: self.say(f"rodgen has failed: {error!r}"))
        ui.add_css(files(__package__).joinpath("static/page.css").read_text(encoding="utf-8"))
        as_before()
        self.root = ui.element("div").classes("rg-page")
        self.progress = Progress()
        self.client.on_delete(self.progress.close)
        await self.client.connected()
        if self.client.is_deleted:  # it was asked for, and never shown
            return
        ui.run_javascript(FORGET_TOKEN)
        tab = app.storage.tab
        known = self.sessions.get(tab.get(RUN))
        if known is not None and packed in ("", tab.get("packed")) and await _left(known):
            self.name, self.run = str(tab[RUN]), known
        elif await self._begin(packed):
            tab.pop(VIEW, None)  # it was for the run before
        else:
            return
        tab[RUN], tab["packed"] = self.name, packed
        self._build()
        self._listen()

    async def _begin(self, packed: str) -> bool:
        """A run of its own."""
        scene = await self._asked(packed) if packed else self._first
        try:
            with self.sessions.room():
                await self.progress.make(scene)
                self.name = await asyncio.to_thread(self.sessions.open, scene)
        except SceneError as error:
            if not self.client.is_deleted:
                with self.root:
                    ui.label(str(error)).classes("rg-failed")
            return False
        run = self.sessions.get(self.name)
        if run is None or self.client.is_deleted:  # it has gone meanwhile
            self.sessions.close(self.name)
            return False
        self.run = run
        return True

    async def _asked(self, packed: str) -> Scene:
        """The scene in the address, or the first one where that is none."""
        try:
            return await asyncio.to_thread(unpacked, packed)
        except SceneError as error:
            self.say(f"The scene in the address cannot be used: {error}")
            return self._first

    def _build(self) -> None:
        with self.root:
            Channel(ADDRESS + self.name)
            self.bar = Bar(self)
            with ui.element("div").classes("rg-columns"):
                with ui.element("div").classes("rg-left"):
                    self.rod = RodPanel(self)
                    self.plots = PlotsPanel(self)
                panel = ui.element("aside").classes("rg-right")
                with panel.props('aria-label="Values and settings"'):
                    self._tabs()
        self._parts = [self.bar, self.rod, self.plots]
        self._parts += [self.values, self.parameters, self.structure, self.saving]

    def _tabs(self) -> None:
        with ui.tabs().props("dense no-caps align=justify") as tabs:
            values, parameters = ui.tab("Values"), ui.tab("Parameters")
            scene, save = ui.tab("Scene"), ui.tab("Save")
        shown = app.storage.tab.get(PANEL, "Parameters")
        panels = ui.tab_panels(tabs, value=shown, animated=False).props("keep-alive")
        panels.on_value_change(lambda event: app.storage.tab.update({PANEL: event.value}))
        with panels.classes("rg-panels"):
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
            try:
                for part in self._parts:
                    part.refresh()
            except Exception as error:  # a defect: the page says so, and stays
                app.handle_exception(error)


async def _left(run: LiveRun) -> bool:
    """Whether a run's page has gone: on a reload, it may do so a moment late; a tab that was
    duplicated has the name of a run that is another's."""
    for _ in range(20):
        if not run.page.watched:
            return True
        await asyncio.sleep(0.1)
    return False
