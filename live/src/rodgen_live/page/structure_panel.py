"""Panel of the structure and the initial state of a scene: changed together, from the start."""

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
)
from rodgen_live.page.page_run import PageRun
from rodgen_live.run.scene_edits import (
    StructureForm,
    conversions,
    initial_labels,
    reshape,
    structure_form,
)

PAIRS = {"initial.position", "initial.velocity"}
LIST = "(a list)"  # stands for values that are too many for a field


class StructurePanel:
    """Panel of number of links, boundary, inertia, terms, initial state; and scenes from files.

    Fields are named by their keys in a scene.
    """

    def __init__(self, page: PageRun):
        self.page = page
        self._scene: Scene | None = None
        self._starts: dict[str, str] = {}  # initial values, as their fields have them
        heading("Structure")
        with ui.element("div").classes("rg-knobs"):
            self.fields: dict[str, Field] = {
                "rod.links": ui.input("number of links"),
                "rod.boundary": ui.select(list(BOUNDARIES), label="boundary"),
                "rod.inertia": ui.select(list(INERTIAS), label="inertia of a link"),
            }
            for field in self.fields.values():
                _style(field)
            with ui.element("div").classes("rg-terms").props('role="group" aria-label="Terms"'):
                self.terms = {
                    name: ui.checkbox(term.words).props("dense") for name, term in TERMS.items()
                }
        heading("Initial state")
        self._box = ui.element("div").classes("rg-knobs")
        ui.button("Apply and restart", icon="restart_alt", on_click=self._apply).props("no-caps")
        ui.label(
            "Another structure is derived and compiled first; other values need no restart."
        ).classes("rg-hint")

    def refresh(self) -> None:
        """Show the scene as it is now, if it has changed."""
        scene = self.page.scene
        if self._scene is not None and _form_and_texts(scene) == _form_and_texts(self._scene):
            return
        self._scene = scene
        self._build_fields(initial_labels(scene))
        form, texts = _form_and_texts(scene)
        for name, text in texts.items():
            self.fields[name].set_value(text)
        for term, box in self.terms.items():
            box.set_value(term in form.terms)
        show_refusals(self.fields, {})

    def _build_fields(self, starts: dict[str, str]) -> None:
        """Build the fields of these initial values."""
        if starts == self._starts:
            return
        for key in self._starts:
            del self.fields[key]
        self._starts = starts
        self._box.clear()
        with self._box:
            self.fields |= {key: _style(ui.input(text)) for key, text in starts.items()}

    async def _apply(self) -> None:
        show_refusals(self.fields, {})
        try:
            form, starts = self._form(), self._initial_values()
            run, before = self.page.run, self.page.scene
            await self.page.change_system(
                lambda system: System(reshape(system.scene, form, starts)),
                run.restart,
                lambda system: run.undo.note(system, "structure and initial state", anew=True),
            )
            if converted := conversions(before, form.links):
                self.page.notify(converted)
        except InputError as error:
            named = (name for name in self.fields if f"{error.field}.".startswith(f"{name}."))
            refusals = {next(named, error.field): f"must be {error.allowed}"}
            if show_refusals(self.fields, refusals):
                self.page.notify(str(error))

    def _text(self, name: str) -> str:
        return str(self.fields[name].value or "").strip()

    def _form(self) -> StructureForm:
        terms = tuple(term for term, box in self.terms.items() if box.value)
        links = parse_integer(self._text("rod.links"), "rod.links")
        return StructureForm(links, self._text("rod.boundary"), self._text("rod.inertia"), terms)

    def _initial_values(self) -> dict[str, Any]:
        """Initial values from the fields; None removes that of the scene."""
        texts = {key: self._text(key) for key in self._starts}
        given = {key: text for key, text in texts.items() if not text.startswith(LIST)}
        return {key: _parse_value(text, key) for key, text in given.items()}


def _style(field: Field) -> Field:
    """Give a field the style of the panel."""
    return field.props("dense outlined options-dense").classes("rg-wide")


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


def _form_and_texts(scene: Scene) -> tuple[StructureForm, dict[str, str]]:
    """Form of a scene, and the texts of fields by their names."""
    form = structure_form(scene)
    texts = {"rod.links": str(form.links), "rod.boundary": form.boundary}
    starts = {key: get_at(scene, *key.split(".")) for key in initial_labels(scene)}
    shown = {name: _format_value(value, name in PAIRS) for name, value in starts.items()}
    return form, {**texts, "rod.inertia": form.inertia, **shown}


def _format_value(value: Any, pair: bool) -> str:
    """Format an initial value."""
    if isinstance(value, list):
        return ", ".join(map(format_number, value)) if pair else f"{LIST} of {len(value)}"
    return value if isinstance(value, str) else format_number(value)
