"""The bar at the top: run, pause, step, reset, speed, and how it goes."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from rodgen.scene import SceneError
from rodgen.view.live.run import PAUSED, RUNNING, STOPPED, LiveRun
from rodgen.view.live.web.elements import Keys
from rodgen.view.live.web.shade import TURN

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page

SPEEDS = {
    0.001: "0.001 ×",
    0.01: "0.01 ×",
    0.1: "0.1 ×",
    0.25: "0.25 ×",
    0.5: "0.5 ×",
    1.0: "real time",
    2.0: "2 ×",
    5.0: "5 ×",
    10.0: "10 ×",
    100.0: "100 ×",
    math.inf: "as fast as it goes",
}
ADVICE = ". Reset it, or change a parameter, the method or its step to go on from there."
LOST = ". Reset it: from a state this large, no other value leads on."
OTHER = ""  # in the list of scenes: what is shown is none of the folder's; no file is called so
MOST_COMPARED = 50  # files that the first scene of a page is looked for in


class Bar:
    """Buttons, keys and the state of the run."""

    def __init__(self, page: Page):
        self.page = page
        self._now: object = None
        if page.run.file is None:
            page.run.file = self._first_file(), page.run.taken
        with ui.element("header").classes("rg-bar"):
            ui.label("rodgen").classes("rg-name")
            self.scenes = ui.select([], on_change=self._chosen, label="Scene")
            self.scenes.props("dense outlined options-dense").classes("rg-scenes")
            self.again, self.again_hint = _button("folder_open", "Load again", self._again)
            self.go, self.hint = _button("play_arrow", "Run (space)", self._go)
            self.step, _ = _button("skip_next", "One step of the method (.)", self._step)
            _button("replay", "Reset to the initial state (r)", self._reset)
            self.speed = ui.select(
                {str(v): name for v, name in SPEEDS.items()},
                value=str(page.run.pace.speed),
                on_change=self._speed,
                label="Speed",
            ).props("dense outlined options-dense")
            self.speed.classes("rg-speed")
            with ui.element("div").classes("rg-now"):
                self.state = ui.label().classes("rg-state").props('role="status"')
                _live("t", "s", "time")
                _live("ratio", "× real time", "ratio")
            ui.element("span").classes("rg-lost").props('data-text="connection" role="alert"')
            _button("dark_mode", "Light or dark (d)", self._shade)
        self.failure = ui.label().classes("rg-failure").props('role="alert"')
        Keys({" ": self._go, ".": self._step, "r": self._reset, "d": self._shade}, held=".")

    def refresh(self) -> None:
        """As the run is now."""
        run, scene = self.page.run, self.page.scene
        now = (run.status, run.message, run.taken, run.file)
        if now == self._now:
            return
        self._now = now
        running, stopped = run.status == RUNNING, run.status == STOPPED
        name = "Pause (space)" if running else "Run (space)"
        self.go.props(f'icon={"pause" if running else "play_arrow"} aria-label="{name}"')
        for button in (self.go, self.step):
            button.set_enabled(not stopped)
        self.state.set_text(run.status)
        self.failure.set_text(_told(run) if stopped else "")
        self.failure.set_visibility(stopped)
        self.hint.set_text(name)
        self._list(scene.name)

    # Scenes of the folder ----------------------------------------------------------------------

    def _first_file(self) -> str:
        """The file of the folder that holds the scene of the run, or nothing."""
        scene, folder = self.page.scene, self.page.folder
        names = sorted(folder.names(), key=lambda name: name != scene.name)  # the likely one first
        for name in names[:MOST_COMPARED]:
            with suppress(SceneError):
                if folder.scene(name) == scene:
                    return name
        return OTHER

    @property
    def _file(self) -> str:
        """The file that was taken up last, or nothing."""
        return self.page.run.file[0] if self.page.run.file else OTHER

    @property
    def _shown(self) -> str:
        """The file that the scene of the run was taken from, or nothing."""
        run = self.page.run
        return self._file if run.file == (self._file, run.taken) else OTHER

    def _list(self, present: str) -> None:
        """What can be chosen; present: name of the scene of the run."""
        names = {name: name for name in sorted({*self.page.folder.names(), self._file} - {OTHER})}
        other = {OTHER: f"{present} (other)"} if self._shown == OTHER else {}
        self.scenes.set_options(names | other, value=self._shown)
        label = f"Load {self._file} again, as it is in its file"
        self.again.props["aria-label"] = label
        self.again_hint.set_text(label)
        self.again.set_enabled(self._file != OTHER)

    async def _chosen(self, event: ValueChangeEventArguments[Any]) -> None:
        if event.value not in (None, OTHER, self._shown):
            await self._load(event.value)

    async def _again(self) -> None:
        await self._load(self._file)

    async def _load(self, name: str) -> None:
        """Take up the scene of a file; if it cannot be, what is there stays, in the list too."""
        try:
            await self.page.take(self.page.folder.scene(name))
            self.page.run.file = name, self.page.run.taken
        except SceneError as error:
            self.page.say(str(error))
        self._now = None
        self.page.refresh()

    # What is done ------------------------------------------------------------------------------

    def _go(self) -> None:
        run = self.page.run
        self.page.soon(run.pause if run.status == RUNNING else run.go)

    def _step(self) -> None:
        if self.page.run.status in (RUNNING, PAUSED):
            self.page.soon(self.page.run.one_step)

    def _reset(self) -> None:
        self.page.soon(self.page.run.restart)

    def _speed(self, event: ValueChangeEventArguments[Any]) -> None:
        speed = float(event.value)
        self.page.soon(lambda: self.page.run.set_speed(speed))

    def _shade(self) -> None:
        ui.run_javascript(TURN)


def _told(run: LiveRun) -> str:
    """Why it has stopped, and what can be done."""
    return run.message[:1].upper() + run.message[1:] + (LOST if run.lost else ADVICE)


def _button(icon: str, label: str, clicked: Callable[[], object]) -> tuple[ui.button, ui.tooltip]:
    button = ui.button(icon=icon, on_click=clicked)
    button.props(f'flat round dense aria-label="{label}"')
    with button:
        return button, ui.tooltip(label)


def _live(key: str, unit: str, label: str) -> None:
    """A text that the channel keeps up to date."""
    with ui.element("span").classes("rg-live").props(f'role="group" aria-label="{label}"'):
        ui.element("b").props(f'data-text="{key}"')
        ui.label(unit).classes("rg-unit")
