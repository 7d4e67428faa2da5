"""The bar at the top: run, pause, step, reset, loop, speed, and the state of the run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from nicegui import ui
from nicegui.element import Element
from nicegui.events import ValueChangeEventArguments

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.scene.examples import first_sentence
from rodgen_live.page.elements import STATIC, Component, Keys
from rodgen_live.page.fields import IconButton, dialog, heading
from rodgen_live.page.page_run import PageRun
from rodgen_live.run.run_record import RUNNING, STOPPED
from rodgen_live.run.scene_edits import LARGEST
from rodgen_live.run.scene_text import refused_line

SPEEDS = {str(v): f"{v:g} ×" for v in (1e-3, 0.01, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 100.0)}
SPEEDS |= {"1.0": "real time", "inf": "as fast as it goes"}
ADVICE = ". Reset it, or change a parameter, the method or its step to go on from there."
LOST = ". Reset it: from a state this large, no other value leads on."
AROUND = "in a loop"  # the state of a run that begins again at the end of its span
OTHER = ""  # in the list of scenes: what is shown is none of the folder's; no file is called so
ENDING = ".toml"
OPENED = " (opened)"  # ends the name of a scene whose file was opened in the browser
AGAIN = "restore_page"
UNDO, REDO = ("Undo", "Ctrl+z"), ("Redo", "Ctrl+Shift+z")
THUMBNAILS = "/live/thumbnails/"  # before the name of a scene of the folder: its picture
# What the list of scenes shows of each; v-if: of what is no file of the folder there is no picture.
OPTION = f"""
    <q-item v-bind="props.itemProps" class="rg-scene">
        <img v-if="!/ \\((other|opened)\\)$/.test(props.opt.label)" alt="" loading="lazy"
            :src="'{THUMBNAILS}' + encodeURIComponent(props.opt.label)">
        <q-item-section>
            <q-item-label>{{{{ props.opt.label }}}}</q-item-label>
            <q-item-label caption>{{{{ props.opt.about }}}}</q-item-label>
        </q-item-section>
    </q-item>
"""
MOST_COMPARED = 50  # files that the first scene of a page is looked for in
SPACE = "space"
TO_DO = (
    "Drag the slider of a load past the mark at its critical value, and watch the rod.",
    "Press Flutter below the rod to plot its tail: over time, as a phase plot, as a spectrum.",
    "Choose another scene from the list, or write one under Text; ? shows this again.",
)
# What takes keys while it has the focus: static/rod.js, static/timeline.js,
# static/chart_pointer.js.
IN_FOCUS = {
    "The rod, in focus": {
        "← → ↑ ↓": "Move the picture",
        "+ −": "Zoom, as the wheel does",
        "0": "Fit the rod, as a double click does",
        "Esc": "Let go of a kick or a pull",
    },
    "The time line, in focus": {
        "← →": "A sample back or on",
        "page up, page down": "A tenth of the line",
        "Home, End": "The first sample, the present",
        "a, b": "Ends of the loop",
    },
    "A plot, in focus": {
        "+ −": "Zoom, as the wheel does",
        "← →": "Move along it",
        "0": "All of it, as a double click does",
    },
}


class SceneList(ui.select):
    """List of scenes; about: a sentence on each, by its name."""

    about: Mapping[str, str] = {}

    def _update_options(self) -> None:
        super()._update_options()
        for option in self._props["options"]:
            option["about"] = self.about.get(option["label"], "")


class SceneFile(Component, component=STATIC / "scene_file.js"):
    """A button that opens a dialog for files; chosen: given the text of one; refused: called for
    what is longer than a scene, or no text.

    NiceGUI's own upload has a route for every element, which FastAPI keeps with all of its page.
    """

    def __init__(self, chosen: Callable[[str], object], refused: Callable[[], object]) -> None:
        super().__init__(ending=ENDING, most=LARGEST)
        self.on("chosen", lambda event: chosen(str(event.args["text"]))).on("refused", refused)
        pick = f'() => runMethod({self.id}, "pick", [])'
        button = IconButton("folder_open", "Open a file").on("click", js_handler=pick)
        button.classes("rg-open")


class Toolbar:
    """Buttons, keys and the state of the run."""

    def __init__(self, page: PageRun, turn_shade: Callable[[], object]):
        """Build the bar; turn_shade: from light to dark and back."""
        self.page, self._folder = page, page.folder
        self._listed: object = None  # what the list of scenes was made of
        self._keys: dict[str, Callable[[], object]] = {}
        self._said: dict[str, str] = {}  # of keys: what they do
        run, submit = page.run, page.submit
        if run.files is None:
            run.files = self._first_file()
        with ui.element("header").classes("rg-bar"):
            heading("rodgen", level=1).classes("rg-name")
            self.scenes = SceneList([], on_change=self._on_select, label="Scene")
            self.scenes.props("popup-content-class=rg-gallery").classes("rg-scenes")
            self.scenes.add_slot("option", OPTION)
            SceneFile(lambda text: page.start_task(self._open(text)), self._reject_file)
            self.again = IconButton(AGAIN, "Load again", lambda: self._load(self._loadable_file))
            self.go = self._control(
                "play_arrow",
                "Run or pause",
                " ",
                lambda: submit(run.pause if run.status == RUNNING else run.resume),
            )
            self.step = self._control(
                "skip_next", "One step of the method", ".", lambda: submit(run.one_step)
            )
            self._control("replay", "Reset to the initial state", "r", lambda: submit(run.restart))
            self.around = self._control(
                "loop", "Loop over the span", "l", lambda: submit(run.loop, not run.goes_round)
            )
            self.undo = self._control("undo", *UNDO, lambda: page.start_task(page.undo()))
            self.redo = self._control("redo", *REDO, lambda: page.start_task(page.undo(forth=True)))
            speed = ui.select(SPEEDS, value=str(run.pace.speed), label="Speed").classes("rg-speed")
            speed.on_value_change(lambda event: submit(run.set_speed, float(event.value)))
            self._control("dark_mode", "Light or dark", "d", turn_shade).classes("rg-last")
            self._control(
                "help_outline", "Help and keys", "?", lambda: show_shortcuts(page.root, self._said)
            ).classes("rg-help")
        with ui.element("div").classes("rg-now"):  # the place of what comes and goes
            self.state = ui.label().classes("rg-state").props('role="status"')
            _add_live_text("t", "s", "time")
            _add_live_text("ratio", "× real time", "ratio")
            ui.element("span").classes("rg-lost").props('data-text="connection" role="alert"')
            self.failure = ui.label().classes("rg-failure").props('role="alert"')
            with ui.element("div").classes("rg-rough").props('role="status"') as self.rough:
                self.looking = ui.label()
                self.back = ui.button(on_click=lambda: submit(run.roughen, False))
                self.back.props("flat dense")
        self.about = ui.label().classes("rg-about")
        Keys(self._keys, held=".")

    def _control(self, icon: str, label: str, key: str, act: Callable[[], object]) -> IconButton:
        shown = SPACE if key == " " else key
        self._keys[key], self._said[shown] = act, label
        return IconButton(icon, f"{label} ({shown})", act)

    def refresh(self) -> None:
        """Show the run as it is now."""
        run, scene = self.page.run, self.page.scene
        for button, (verb, key), forth in ((self.undo, UNDO, False), (self.redo, REDO, True)):
            kept = run.undo.next_state(forth)
            button.set_enabled(kept is not None)
            button.rename(f"{verb}{f': {kept.what}' if kept else ''} ({key})", verb.lower())
        running, stopped = run.status == RUNNING, run.status == STOPPED
        self.go.rename(*(("Pause (space)", "pause") if running else ("Run (space)", "play_arrow")))
        for button in (self.go, self.step):
            button.set_enabled(not stopped)
        self.around.props(f"aria-pressed={'true' if run.goes_round else 'false'}")
        self.state.set_text(AROUND if running and run.goes_round else run.status)
        self.failure.set_visibility(stopped)
        if stopped:
            advice = LOST if run.is_unusable else ADVICE
            self.failure.set_text(run.message[:1].upper() + run.message[1:] + advice)
            self.failure.props["title"] = self.failure.text  # it may be too long for its line
        own, used, method = scene.integrate, run.live.settings, run.live.choice.method
        by = f"step {own.step:g} s" if own.has_fixed_step else f"rtol {own.rtol:g}"
        self.looking.set_text(
            f"For looking: {used.method} at rtol {used.rtol:g}, as real time is missed with "
            f"{method}, {by}."
        )
        self.back.set_text(f"Back to {method}, {by}")
        self.rough.set_visibility(bool(run.live.rough))
        listed = run.taken, run.undo.file, self._loadable_file
        if listed != self._listed:
            self._listed = listed
            self._update_scenes(scene.name)

    # Scenes of the folder ----------------------------------------------------------------------

    def _first_file(self) -> dict[str, Scene]:
        scene, folder = self.page.run.undo.file, self._folder
        names = sorted(folder.names(), key=lambda name: name != scene.name)  # the likely one first
        for name in names[:MOST_COMPARED]:
            with suppress(InputError):
                if folder.scene(name) == scene:
                    self.page.run.texts.setdefault(scene, folder.text(name))
                    return {name: scene}
        return {}

    @property
    def _loadable_file(self) -> str:
        """File that can be loaded again, or nothing: that of the scene, else the last one."""
        return self._scene_file or next(reversed(self.page.run.files or {}), OTHER)

    @property
    def _scene_file(self) -> str:
        scene, files = self.page.run.undo.file, self.page.run.files or {}
        return next((name for name in reversed(files) if files[name] == scene), OTHER)

    def _update_scenes(self, present: str) -> None:
        loadable, shown = self._loadable_file, self._scene_file
        names = {name: name for name in sorted({*self._folder.names(), loadable} - {OTHER})}
        other = {OTHER: f"{present} (other)"} if shown == OTHER else {}
        if names.keys() != self.scenes.about.keys():
            self.scenes.about = {name: self._about(name) for name in names}
        self.scenes.set_options(names | other, value=shown)
        text = self.page.run.texts.get(self.page.run.undo.file, "")
        self.about.set_text(first_sentence(text) or present)
        self.about.props["title"] = self.about.text
        self.again.rename(f"Load {loadable} again, as it is in its file", AGAIN)
        self.again.set_enabled(loadable != OTHER)

    def _about(self, name: str) -> str:
        with suppress(InputError):
            return first_sentence(self._folder.text(name))
        return ""

    def _on_select(self, event: ValueChangeEventArguments[Any]) -> None:
        """Load the scene that was chosen in the list. The list is compared with the run at once: by
        the time that the scene is loaded, it may show another."""
        if event.value not in (None, OTHER, self._scene_file):
            self._load(event.value)

    def _reject_file(self) -> None:
        most = f"at most {LARGEST >> 10} KiB"
        self.page.notify(f"A scene is a file of UTF-8 text that ends in {ENDING}, of {most}")

    def _load(self, name: str) -> None:
        """Load the scene of a file; if that fails, the present one stays, in the list too."""
        run, files = self.page.run, self.page.run.files or {}

        def read() -> str:
            opened = name in files and name.endswith(OPENED)
            return run.texts[files[name]] if opened else self._folder.text(name)

        self.page.start_task(self._run_file(read, lambda _: name))

    async def _open(self, text: str) -> None:
        try:
            await self._run_file(lambda: text, lambda scene: scene.name + OPENED)
        except InputError as error:
            line = refused_line(text, error)
            self.page.notify(f"Line {line}: {error}" if line else str(error))

    async def _run_file(self, read: Callable[[], str], name: Callable[[Scene], str]) -> None:
        """Run the scene of a file, which can be loaded again by its name. Raises InputError."""
        run = self.page.run
        try:
            scene = await self.page.run_text(read())
            before = {one: of for one, of in (run.files or {}).items() if one != name(scene)}
            run.files = {**before, name(scene): scene}
        finally:
            self._listed = None
            self.page.refresh()


def show_shortcuts(root: Element, everywhere: Mapping[str, str]) -> None:
    """Open a dialog of keys; everywhere: what keys do that the whole page takes, by their names."""
    with root, dialog("What to do, and keys"):
        for line in TO_DO:
            ui.label(line)
        for title, keys in {"The page": everywhere, **IN_FOCUS}.items():
            rows = (
                f'<tr><th scope="row"><kbd>{key}</kbd></th><td>{does}</td></tr>'
                for key, does in keys.items()
            )
            table = f"<caption>{title}</caption>{''.join(rows)}"
            ui.html(table, sanitize=False, tag="table").classes("rg-keys")


def _add_live_text(key: str, unit: str, label: str) -> None:
    with ui.element("span").classes("rg-live").props(f'role="group" aria-label="{label}"'):
        ui.element("b").props(f'data-text="{key}"')
        ui.label(unit).classes("rg-unit")
