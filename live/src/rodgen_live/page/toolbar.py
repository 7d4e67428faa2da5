"""The bar at the top: run, pause, step, reset, loop, speed, and the state of the run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from rodgen.errors import InputError
from rodgen.scene.examples import first_sentence
from rodgen_live.page.elements import Keys
from rodgen_live.page.fields import IconButton, heading
from rodgen_live.page.page_run import PageRun
from rodgen_live.page.scene_file import ENDING, SceneFile
from rodgen_live.page.shortcuts import SPACE, show_shortcuts
from rodgen_live.run.live_run import PAUSED, RUNNING, STOPPED, LiveRun
from rodgen_live.run.scene_edits import LARGEST

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
AROUND = "in a loop"  # the state of a run that begins again at the end of its span
OTHER = ""  # in the list of scenes: what is shown is none of the folder's; no file is called so
AGAIN = "restore_page"
SKETCH = "/live/sketch/"  # before the name of a scene of the folder: the address of its picture
# What the list of scenes shows of each; v-if: the scene of the run itself may be no file.
OPTION = f"""
    <q-item v-bind="props.itemProps" class="rg-scene">
        <img v-if="!props.opt.label.endsWith(' (other)')" alt="" loading="lazy"
            :src="'{SKETCH}' + encodeURIComponent(props.opt.label)">
        <q-item-section>
            <q-item-label>{{{{ props.opt.label }}}}</q-item-label>
            <q-item-label caption>{{{{ props.opt.about }}}}</q-item-label>
        </q-item-section>
    </q-item>
"""
MOST_COMPARED = 50  # files that the first scene of a page is looked for in


class SceneList(ui.select):
    """List of scenes; about: a sentence on each, by its name."""

    about: Mapping[str, str] = {}

    def _update_options(self) -> None:
        super()._update_options()
        for option in self._props["options"]:
            option["about"] = self.about.get(option["label"], "")


class Toolbar:
    """Buttons, keys and the state of the run."""

    def __init__(self, page: PageRun, turn_shade: Callable[[], object]):
        """Build the bar; turn_shade: from light to dark and back."""
        self.page, self._folder = page, page.folder
        self._now: object = None
        self._listing = False  # whether the list of scenes is being brought up to date
        self._keys: dict[str, Callable[[], object]] = {}
        self._said: dict[str, str] = {}  # of keys: what they do
        if page.run.files is None:
            first = self._first_file()
            page.run.files = {} if first == OTHER else {first: page.run.undo.file}
            if first != OTHER:
                page.run.texts.setdefault(page.run.undo.file, self._folder.text(first))
        with ui.element("header").classes("rg-bar"):
            heading("rodgen", level=1).classes("rg-name")
            self.scenes = SceneList([], on_change=self._on_select, label="Scene")
            self.scenes.props("dense outlined popup-content-class=rg-gallery").classes("rg-scenes")
            self.scenes.add_slot("option", OPTION)
            SceneFile(self._open_file, self._reject_file)
            self.again = IconButton(AGAIN, "Load again", self._load_again)
            self.go = self._control("play_arrow", "Run or pause", " ", self._go)
            self.step = self._control("skip_next", "One step of the method", ".", self._step)
            self._control("replay", "Reset to the initial state", "r", self._reset)
            self.around = self._control("loop", "Loop over the span", "l", self._loop)
            self.undo = self._control("undo", "Undo", "Ctrl+z", self._undo)
            self.redo = self._control("redo", "Redo", "Ctrl+Shift+z", self._redo)
            self.speed = ui.select(
                {str(v): name for v, name in SPEEDS.items()},
                value=str(page.run.pace.speed),
                on_change=self._speed,
                label="Speed",
            ).props("dense outlined options-dense")
            self.speed.classes("rg-speed")
            self._control("dark_mode", "Light or dark", "d", turn_shade).classes("rg-last")
            self._control("help_outline", "Help and keys", "?", self._help).classes("rg-help")
        with ui.element("div").classes("rg-now"):  # the place of what comes and goes
            self.state = ui.label().classes("rg-state").props('role="status"')
            _add_live_text("t", "s", "time")
            _add_live_text("ratio", "× real time", "ratio")
            ui.element("span").classes("rg-lost").props('data-text="connection" role="alert"')
            self.failure = ui.label().classes("rg-failure").props('role="alert"')
            with ui.element("div").classes("rg-rough").props('role="status"') as self.rough:
                self.looking = ui.label()
                self.back = ui.button(on_click=self._restore_tolerances).props("flat dense no-caps")
        self.about = ui.label().classes("rg-about")
        Keys(self._keys, held=".")

    def _control(self, icon: str, label: str, key: str, act: Callable[[], object]) -> IconButton:
        """Add a button, and the key that does what it does."""
        self._keys[key], self._said[SPACE if key == " " else key] = act, label
        return IconButton(icon, f"{label} ({SPACE if key == ' ' else key})", act)

    def _help(self) -> None:
        """Open the dialog of keys."""
        with self.page.root:
            show_shortcuts(self._said)

    def refresh(self) -> None:
        """Show the run as it is now."""
        run, scene = self.page.run, self.page.scene
        self._refresh_undo()
        here = (
            run.status,
            run.goes_round,
            run.message,
            run.taken,
            run.undo.file,
            self._loadable_file,
        )
        live = run.live
        now = (*here, live.rough, live.settings, live.choice.method, scene.integrate)
        if now == self._now:
            return
        self._now = now
        running, stopped = run.status == RUNNING, run.status == STOPPED
        self.go.rename(*(("Pause (space)", "pause") if running else ("Run (space)", "play_arrow")))
        for button in (self.go, self.step):
            button.set_enabled(not stopped)
        self.around.props(f"aria-pressed={'true' if run.goes_round else 'false'}")
        self.state.set_text(AROUND if running and run.goes_round else run.status)
        self.failure.set_text(said := _stop_message(run) if stopped else "")
        self.failure.props["title"] = said  # it may be too long for its line
        self.failure.set_visibility(stopped)
        self._update_scenes(scene.name)
        own, used = scene.integrate, live.settings
        by = f"step {own.step:g} s" if own.has_fixed_step else f"rtol {own.rtol:g}"
        method = live.choice.method
        self.looking.set_text(
            f"For looking: {used.method} at rtol {used.rtol:g}, as real time is missed with "
            f"{method}, {by}."
        )
        self.back.set_text(f"Back to {method}, {by}")
        self.rough.set_visibility(bool(live.rough))

    def _refresh_undo(self) -> None:
        """Show what is undone next, and redone."""
        buttons = (self.undo, "Undo", "Ctrl+z"), (self.redo, "Redo", "Ctrl+Shift+z")
        for forth, (button, verb, key) in enumerate(buttons):
            kept = self.page.run.undo.next_state(bool(forth))
            button.set_enabled(kept is not None)
            button.rename(f"{verb}{f': {kept.what}' if kept else ''} ({key})", verb.lower())

    # Scenes of the folder ----------------------------------------------------------------------

    def _first_file(self) -> str:
        """File of the folder that holds the scene that the run was made of, or nothing."""
        scene, folder = self.page.run.undo.file, self._folder
        names = sorted(folder.names(), key=lambda name: name != scene.name)  # the likely one first
        for name in names[:MOST_COMPARED]:
            with suppress(InputError):
                if folder.scene(name) == scene:
                    return name
        return OTHER

    @property
    def _loadable_file(self) -> str:
        """File that can be loaded again, or nothing: that of the scene, else the last one."""
        return self._scene_file or next(reversed(self.page.run.files or {}), OTHER)

    @property
    def _scene_file(self) -> str:
        """File that the scene of the run was made of, or nothing."""
        scene, files = self.page.run.undo.file, self.page.run.files or {}
        return next((name for name in reversed(files) if files[name] == scene), OTHER)

    def _update_scenes(self, present: str) -> None:
        """Update the list of scenes; present: name of the scene of the run."""
        names = {
            name: name for name in sorted({*self._folder.names(), self._loadable_file} - {OTHER})
        }
        other = {OTHER: f"{present} (other)"} if self._scene_file == OTHER else {}
        self._listing = True
        if names.keys() != self.scenes.about.keys():
            self.scenes.about = {name: self._about(name) for name in names}
        self.scenes.set_options(names | other, value=self._scene_file)
        self._listing = False
        text = self.page.run.texts.get(self.page.run.undo.file, "")
        self.about.set_text(first_sentence(text) or present)
        self.again.rename(f"Load {self._loadable_file} again, as it is in its file", AGAIN)
        self.again.set_enabled(self._loadable_file != OTHER)

    def _about(self, name: str) -> str:
        """First sentence of a file of the folder."""
        with suppress(InputError):
            return first_sentence(self._folder.text(name))
        return ""

    def _on_select(self, event: ValueChangeEventArguments[Any]) -> None:
        """Load the scene that was chosen in the list. The list is compared with the run at once: by
        the time that the scene is loaded, it may show another."""
        if not self._listing and event.value not in (None, OTHER, self._scene_file):
            self.page.start_task(self._load(event.value))

    async def _load_again(self) -> None:
        await self._load(self._loadable_file)

    async def _open_file(self, text: str) -> None:
        """Load the scene of a file that was chosen in the browser."""
        try:
            await self.page.run_text(text)
        except InputError as error:
            self.page.notify(str(error))

    def _reject_file(self) -> None:
        most = f"at most {LARGEST >> 20} MiB"
        self.page.notify(f"A scene is a file of UTF-8 text that ends in {ENDING}, of {most}")

    async def _load(self, name: str) -> None:
        """Load the scene of a file; if that fails, the present one stays, in the list too."""
        try:
            scene = await self.page.run_text(self._folder.text(name))
            before = {one: of for one, of in (self.page.run.files or {}).items() if one != name}
            self.page.run.files = {**before, name: scene}
        except InputError as error:
            self.page.notify(str(error))
        self._now = None
        self.page.refresh()

    # What is done ------------------------------------------------------------------------------

    def _go(self) -> None:
        run = self.page.run
        self.page.submit(run.pause if run.status == RUNNING else run.resume)

    def _undo(self) -> None:
        self.page.start_task(self.page.undo())

    def _redo(self) -> None:
        self.page.start_task(self.page.undo(forth=True))

    def _step(self) -> None:
        if self.page.run.status in (RUNNING, PAUSED):
            self.page.submit(self.page.run.one_step)

    def _restore_tolerances(self) -> None:
        self.page.submit(lambda: self.page.run.roughen(False))

    def _loop(self) -> None:
        run = self.page.run
        self.page.submit(lambda: run.loop(not run.goes_round))

    def _reset(self) -> None:
        self.page.submit(self.page.run.restart)

    def _speed(self, event: ValueChangeEventArguments[Any]) -> None:
        speed = float(event.value)
        self.page.submit(lambda: self.page.run.set_speed(speed))


def _stop_message(run: LiveRun) -> str:
    """Say why the run has stopped, and what can be done."""
    return run.message[:1].upper() + run.message[1:] + (LOST if run.is_unusable else ADVICE)


def _add_live_text(key: str, unit: str, label: str) -> None:
    """Add a text that the channel keeps up to date."""
    with ui.element("span").classes("rg-live").props(f'role="group" aria-label="{label}"'):
        ui.element("b").props(f'data-text="{key}"')
        ui.label(unit).classes("rg-unit")
