"""The bar at the top: run, pause, step, reset, speed, and how it goes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from nicegui import ui
from nicegui.events import KeyEventArguments, ValueChangeEventArguments

from rodgen.scene import SceneError
from rodgen.view.live.run import PAUSED, RUNNING, STOPPED

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


class Bar:
    """Buttons, keys and the state of the run."""

    def __init__(self, page: Page):
        self.page = page
        self._now: object = None
        with ui.element("header").classes("rg-bar"):
            ui.label("rodgen").classes("rg-name")
            self.scenes = ui.select(
                self._names(), value=None, on_change=self._chosen, label="Scene"
            ).props("dense outlined options-dense")
            self.scenes.classes("rg-scenes")
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
            with ui.element("div").classes("rg-now").props('role="status"'):
                self.state = ui.label().classes("rg-state")
                _live("t", "s", "time")
                _live("ratio", "× real time", "ratio")
            ui.element("span").classes("rg-lost").props('data-text="connection" role="alert"')
            _button("dark_mode", "Light or dark (d)", self._shade)
        self.failure = ui.label().classes("rg-failure").props('role="alert"')
        ui.keyboard(on_key=self._key, ignore=["input", "select", "textarea", "button"])

    def _names(self) -> list[str]:
        return self.page.folder.names()

    def refresh(self) -> None:
        """As the run is now."""
        run, scene = self.page.run, self.page.scene
        now = (run.status, run.message, scene.name)
        if now == self._now:
            return
        self._now = now
        running, stopped = run.status == RUNNING, run.status == STOPPED
        name = "Pause (space)" if running else "Run (space)"
        self.go.props(f'icon={"pause" if running else "play_arrow"} aria-label="{name}"')
        for button in (self.go, self.step):
            button.set_enabled(not stopped)
        self.state.set_text(run.status)
        self.failure.set_text(_sentence(run.message) + ADVICE if stopped else "")
        self.failure.set_visibility(stopped)
        self.hint.set_text(name)
        names = [name for name in self._names() if name != scene.name]
        self.scenes.set_options(sorted([scene.name, *names]), value=scene.name)

    # What is done ------------------------------------------------------------------------------

    def _go(self) -> None:
        run = self.page.run
        self.page.soon(run.pause if run.status == RUNNING else run.go)

    def _step(self) -> None:
        self.page.soon(self.page.run.one_step)

    def _reset(self) -> None:
        self.page.soon(self.page.run.restart)

    def _speed(self, event: ValueChangeEventArguments[Any]) -> None:
        speed = float(event.value)
        self.page.soon(lambda: self.page.run.set_speed(speed))

    def _shade(self) -> None:
        ui.run_javascript(
            "const dark = document.body.classList.contains('body--dark');Quasar.Dark.set(!dark);"
        )

    async def _chosen(self, event: ValueChangeEventArguments[Any]) -> None:
        if event.value is None or event.value == self.page.scene.name:
            return
        try:
            await self.page.take(self.page.folder.scene(event.value))
        except SceneError as error:
            self.page.say(str(error))
            self.refresh()

    def _key(self, event: KeyEventArguments) -> None:
        if not event.action.keydown or event.modifiers.ctrl or event.modifiers.meta:
            return
        run = self.page.run
        if event.key == " " and not event.action.repeat:
            self._go()
        elif event.key == "." and run.status in (RUNNING, PAUSED):
            self._step()
        elif event.key == "r":
            self._reset()
        elif event.key == "d":
            self._shade()


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _button(icon: str, label: str, clicked: Callable[[], object]) -> tuple[ui.button, ui.tooltip]:
    button = ui.button(icon=icon, on_click=clicked)
    button.props(f'flat round dense aria-label="{label}"')
    with button:
        return button, ui.tooltip(label)


def _live(key: str, unit: str, label: str) -> None:
    """A text that the channel keeps up to date."""
    with ui.element("span").classes("rg-live").props(f'aria-label="{label}"'):
        ui.element("b").props(f'data-text="{key}"')
        ui.label(unit).classes("rg-unit")
