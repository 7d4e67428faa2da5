"""Panels of a scene that begin it anew: its structure and initial state as fields, and its text."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from rodgen.errors import InputError
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.scene.plain_tables import get_at
from rodgen.system import System
from rodgen_live.page.fields import (
    Field,
    format_number,
    heading,
    parse_integer,
    parse_number,
    show_refusals,
    text_of,
)
from rodgen_live.page.page_run import PANEL, PageRun
from rodgen_live.run.scene_edits import (
    StructureForm,
    conversions,
    initial_labels,
    reshape,
    structure_form,
)
from rodgen_live.run.scene_text import refused_line

PAIRS = {"initial.position", "initial.velocity"}
CHANGED = (
    "The scene was changed after this text was shown. Apply again to set the text in its place."
)
LIST = "(a list)"  # stands for values that are too many for a field
# Selects a line of a text area, and brings it into view.
SELECT = """
    const area = document.querySelector(".rg-text textarea"), lines = area.value.split("\\n");
    const from = lines.slice(0, %d).join("\\n").length + 1;
    area.focus();
    area.setSelectionRange(from, from + lines[%d].length);
    area.scrollTo(0, %d * area.scrollHeight / lines.length - area.clientHeight / 2);
"""


class StructurePanel:
    """Panel of number of links, boundary, inertia, terms and initial state.

    Fields are named by their keys in a scene.
    """

    def __init__(self, page: PageRun):
        self.page = page
        self._shown: object = None  # the form and the initial values
        self.fields: dict[str, Field] = {}
        heading("Structure")
        with ui.element("div").classes("rg-knobs"):
            self._rod: dict[str, Field] = {
                "rod.links": ui.input("number of links"),
                "rod.boundary": ui.select(list(BOUNDARIES), label="boundary"),
                "rod.inertia": ui.select(list(INERTIAS), label="inertia of a link"),
            }
            for field in self._rod.values():
                field.classes("rg-wide")
            with ui.element("div").classes("rg-terms").props('role="group" aria-label="Terms"'):
                self.terms = {
                    name: ui.checkbox(term.words).props("dense") for name, term in TERMS.items()
                }
        heading("Initial state")
        self._box = ui.element("div").classes("rg-knobs")
        ui.button("Apply and restart", icon="restart_alt", on_click=self._apply)
        ui.label(
            "Another structure is derived and compiled first; other values need no restart."
        ).classes("rg-hint")

    def refresh(self) -> None:
        """Show the scene as it is now, if it has changed."""
        form, starts = state = _form_and_starts(self.page.scene)
        if state == self._shown:
            return
        self._shown, labels = state, initial_labels(self.page.scene)
        for key, field in self._rod.items():
            field.set_value(str(getattr(form, key.removeprefix("rod."))))
        for term, box in self.terms.items():
            box.set_value(term in form.terms)
        self._box.clear()
        with self._box:
            self.fields = self._rod | {
                key: ui.input(label, value=starts[key]) for key, label in labels.items()
            }
        show_refusals(self.fields, {})

    async def _apply(self) -> None:
        show_refusals(self.fields, {})
        try:
            form, starts = self._form(), self._initial_values()
            before, shown = self.page.scene, self._shown

            def edit(system: System) -> System:
                if _form_and_starts(system.scene) != shown:  # it was on its way
                    allowed = "the scene whose fields were filled in; they are of another"
                    raise InputError("scene", system.scene.name, allowed)
                return System(reshape(system.scene, form, starts))

            await self.page.change_system(edit, "structure and initial state", anew=True)
            if converted := conversions(before, form.links):
                self.page.notify(converted)
        except InputError as error:
            named = (name for name in self.fields if f"{error.field}.".startswith(f"{name}."))
            refusals = {next(named, error.field): f"must be {error.allowed}"}
            if show_refusals(self.fields, refusals):
                self.page.notify(str(error))

    def _form(self) -> StructureForm:
        terms = tuple(term for term, box in self.terms.items() if box.value)
        links, boundary, inertia = map(text_of, self._rod.values())
        return StructureForm(parse_integer(links, "rod.links"), boundary, inertia, terms)

    def _initial_values(self) -> dict[str, Any]:
        """Initial values from the fields; None removes that of the scene."""
        texts = {key: text_of(of) for key, of in self.fields.items() if key not in self._rod}
        given = {key: text for key, text in texts.items() if not text.startswith(LIST)}
        return {key: _parse_value(text, key) for key, text in given.items()}


def _form_and_starts(scene: Scene) -> tuple[StructureForm, dict[str, str]]:
    keys = initial_labels(scene)
    return structure_form(scene), {
        key: _format_value(get_at(scene, *key.split(".")), key) for key in keys
    }


class TextPanel:
    """Panel of the scene in TOML: made when it is looked at, and for another scene only where
    nothing was typed."""

    def __init__(self, page: PageRun):
        self.page = page
        self._scene: Scene | None = None
        self._shown = ""
        heading("The scene in TOML")
        self.field = ui.textarea().props('outlined dense aria-label="Text of the scene"')
        self.field.props("spellcheck=false").classes("rg-wide rg-text")
        self.refused = ui.label().classes("rg-failed").props('role="alert"')
        with ui.row():
            ui.button("Apply and restart", icon="restart_alt", on_click=self._apply)
            ui.button("Discard", on_click=self._show).props("flat")

    def refresh(self) -> None:
        """Show the scene as it is now, where the panel is in view and its text as it was shown."""
        scene = self.page.scene
        typed = self._scene is not None and self.field.value != self._shown
        if self.page.tab[PANEL] == "Text" and not typed and scene != self._scene:
            self._show()

    def _show(self) -> None:
        self._scene, self._shown = self.page.scene, self.page.text
        self.field.set_value(self._shown)
        self.refused.set_text("")

    async def _apply(self) -> None:
        text = str(self.field.value or "")
        self.refused.set_text("")
        if self._scene != self.page.scene:
            self._scene = self.page.scene
            self.refused.set_text(CHANGED)
            return
        try:
            await self.page.run_text(text)
        except InputError as error:
            line = refused_line(text, error)
            self.refused.set_text(f"Line {line}: {error}" if line else str(error))
            if line:
                ui.run_javascript(SELECT % (line - 1, line - 1, line))
        else:
            self._show()


def _parse_value(text: str, field: str) -> Any:
    """Parse an initial value: nothing, a number, two of them, or an expression, which the scene
    parses. Raises InputError."""
    if not text:
        return None
    if field in PAIRS:
        parts = text.replace(";", ",").split(",")
        if len(parts) != 2:
            raise InputError(field, text, "two numbers: x, y")
        return [parse_number(part.strip(), field) for part in parts]
    try:
        return float(text)
    except ValueError:
        return text


def _format_value(value: Any, field: str) -> str:
    if isinstance(value, list):
        paired = field in PAIRS
        return ", ".join(map(format_number, value)) if paired else f"{LIST} of {len(value)}"
    return value if isinstance(value, str) else format_number(value)
