"""The page of a run: its panels, which run it shows, light or dark."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, MutableMapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from nicegui import Client, app, ui
from nicegui.events import ValueChangeEventArguments

from rodgen.errors import InputError
from rodgen.model.palette import DARK, LIGHT
from rodgen.scene import Scene
from rodgen_live.page.downloads import DownloadsPanel
from rodgen_live.page.elements import Aria, Channel, early_scripts, style_sheet
from rodgen_live.page.export import export
from rodgen_live.page.module_builder import BuildProgress, ModuleBuilder
from rodgen_live.page.page_run import PANEL, VIEW, PageRun, Panel, notify
from rodgen_live.page.plots import PlotsPanel
from rodgen_live.page.rod_view import VIEWS, RodPanel, first_view
from rodgen_live.page.sessions import Sessions
from rodgen_live.page.structure_panel import StructurePanel, TextPanel
from rodgen_live.page.toolbar import Toolbar
from rodgen_live.page.values_panel import ParametersPanel, ValuesPanel
from rodgen_live.run.link import Link, apply_link
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.run_thread import from_threads
from rodgen_live.run.scene_text import SceneFolder

ADDRESS = "/live/channel/"  # of the WebSocket of a run, before its name
RUN, PACKED = "run", "packed"  # what a tab of the browser remembers, beside VIEW and PANEL
# The token is kept by a cookie: it is not to be copied with the address.
FORGET_TOKEN = """
    const url = new URL(location.href);
    url.searchParams.delete("token");
    history.replaceState(null, "", url);
"""
SHADE = "rodgen_dark"  # a cookie, which the server sees before there is a page
TURN_SHADE = f"""
    const dark = !document.body.classList.contains("body--dark");
    Quasar.Dark.set(dark);
    document.cookie = "{SHADE}=" + (dark ? 1 : 0) + "; path=/; max-age=31536000; samesite=lax";
"""
# Until Quasar marks the body as light or dark.
BEFORE = f"""
    body:not(.body--light, .body--dark) {{
        background: light-dark({LIGHT["behind"]}, {DARK["behind"]});
        color-scheme: %s;
    }}
"""
TABS: dict[str, Callable[[PageRun], Panel]] = {
    "Values": ValuesPanel,
    "Parameters": ParametersPanel,
    "Scene": StructurePanel,
    "Text": TextPanel,
    "Save": partial(DownloadsPanel, export=export),
}


@dataclass
class Page:
    """A page that is being built for one of the runs of a server; first: scene shown at first;
    text: of its file, if it has one; moves: whether a run begins by itself."""

    sessions: Sessions
    modules: ModuleBuilder
    folder: SceneFolder
    first: Scene
    text: str
    moves: bool

    async def show(self, packed: str) -> None:
        """Build the page: of the run that this tab had, of a scene in the address, or of the first
        scene."""
        self._client = client = ui.context.client
        client.on_exception(lambda error: notify(client, f"rodgen has failed: {error!r}"))
        ui.add_css(style_sheet())
        ui.add_head_html(early_scripts())
        _set_shade()
        self._root = ui.element("div").classes("rg-page")
        self._progress = BuildProgress(self.modules)
        client.on_delete(self._progress.cancel)
        with self.sessions.arrival():
            await client.connected()
            if client.is_deleted:  # it was asked for, and never shown
                return
            # Whenever it comes back from now on.
            client.on_connect(partial(_resend_elements, client))
            # Looked up once, as the connection may be gone for a moment later.
            tab = app.storage.tab
            run = self.sessions.claim(tab.get(RUN))
        ui.run_javascript(FORGET_TOKEN)
        name = str(tab.get(RUN))
        if run is None or packed not in ("", tab.get(PACKED)) or not await _has_no_page(run):
            name, run = await self._open_run(packed, tab)
            if run is None:
                return
        tab[RUN], tab[PACKED] = name, packed
        page = self._build(name, run, tab)
        if self.moves and not run.greeted:
            page.submit(run.resume)
        run.greeted = True

    async def _open_run(
        self, packed: str, tab: MutableMapping[str, Any]
    ) -> tuple[str, LiveRun | None]:
        """Open a run for this page, of the first scene where the address cannot be used: its name,
        and the run, or None with an error on the page."""
        link, name = Link(self.first), ""
        try:
            link = await asyncio.to_thread(Link.unpack, packed) if packed else link
        except InputError as error:
            notify(self._client, f"The scene in the address cannot be used: {error}")
        try:
            with self.sessions.reserve():
                await self._progress.build(link.scene)
                name = await asyncio.to_thread(self.sessions.open, link.scene)
        except InputError as error:
            if not self._client.is_deleted:
                with self._root:
                    ui.label(str(error)).classes("rg-failed")
        run = self.sessions.get(name)
        if run is None or self._client.is_deleted:  # it has gone meanwhile
            self.sessions.close(name)
            return name, None
        run.texts = {self.first: self.text} if self.text else {}
        tab[VIEW] = link.view if link.view in VIEWS else first_view(link.scene)
        try:
            await asyncio.wrap_future(run.submit(partial(apply_link, run, link)))
        except InputError as error:
            notify(self._client, f"The address cannot be followed in all: {error}")
        return name, run

    def _build(self, name: str, run: LiveRun, tab: MutableMapping[str, Any]) -> PageRun:
        page = PageRun(run, self._progress.build, self._client, self._root, tab, self.folder)
        with self._root:
            Channel(address=ADDRESS + name)
            Aria()
            bar = Toolbar(page, lambda: ui.run_javascript(TURN_SHADE))
            with ui.element("div").classes("rg-columns"):
                with ui.element("div").classes("rg-left"):
                    rod, plots = RodPanel(page), PlotsPanel(page)
                with ui.element("aside").classes("rg-right") as aside:
                    aside.props('aria-label="Values and settings" tabindex=0')
                    tabs = _tabs(page)
        page.panels = (bar, rod, *tabs, plots)
        run.told = from_threads(page.refresh)
        page.refresh()
        return page


def _tabs(page: PageRun) -> list[Panel]:
    with ui.tabs().props("dense no-caps align=justify") as heads:
        tabs = {title: ui.tab(title) for title in TABS}
    shown = page.tab.setdefault(PANEL, "Parameters")
    panels = ui.tab_panels(heads, value=shown, animated=False).props("keep-alive")

    def turn(event: ValueChangeEventArguments[Any]) -> None:
        page.tab[PANEL] = event.value
        page.refresh()

    panels.on_value_change(turn)
    made = []
    with panels.classes("rg-panels"):
        for title, build in TABS.items():
            with ui.tab_panel(tabs[title]):
                made.append(build(page))
    return made


async def _has_no_page(run: LiveRun) -> bool:
    """Whether a run's page has gone: on a reload, it may do so a moment late; a tab that was
    duplicated has the name of a run that is another's."""
    for _ in range(50):
        if not run.page.has_page:
            return True
        await asyncio.sleep(0.1)
    return False


async def _resend_elements(client: Client) -> None:
    """Send all elements again to a page that was cut off for a moment: what it missed comes to it
    after what is newer, and would stay."""
    while client.outbox.messages:  # what it missed
        await asyncio.sleep(0.05)
    for element in list(client.elements.values()):
        element.update()


def _set_shade() -> None:
    """Give the page the shade that was chosen last, from its first moment; else the browser's."""
    request = ui.context.client.request
    kept = request.cookies.get(SHADE, "") if request else ""
    ui.add_css(BEFORE % {"0": "only light", "1": "only dark"}.get(kept, "light dark"))
    if kept in ("0", "1"):
        ui.dark_mode(kept == "1")
