"""What the module is specialised to, and the initial state: changed together, from the start."""

from __future__ import annotations

import asyncio
from typing import Any

from nicegui import ui

from rodgen.errors import InputError
from rodgen.live.page.fields import Field, heading, number, plain, refuse, whole_number
from rodgen.live.page.runs import PageRun
from rodgen.live.page.scene_file import ENDING, SceneFile
from rodgen.live.run.scenes import (
    LARGEST,
    Form,
    form_of,
    from_toml_text,
    reshape,
    starts_of,
)
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.scene.plain import entry
from rodgen.system import System

PAIRS = {"initial.position", "initial.velocity"}
LIST = "(a list)"  # stands for values that are too many for a field


class StructurePanel:
    """Number of links, boundary, inertia, terms, initial state; and scenes from files.

    Fields are called after where they stand in a scene, in one word.
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
                _styled(field)
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
        heading("From a file")
        SceneFile(self._uploaded, self._rejected)

    def refresh(self) -> None:
        """Show the scene as it is now, where that is another than before."""
        scene = self.page.scene
        if self._scene is not None and _shown_of(scene) == _shown_of(self._scene):
            return
        self._scene = scene
        self._have(starts_of(scene))
        form, texts = _shown_of(scene)
        for name, text in texts.items():
            self.fields[name].set_value(text)
        for term, box in self.terms.items():
            box.set_value(term in form.terms)
        refuse(self.fields, {})

    def _have(self, starts: dict[str, str]) -> None:
        """Have fields for these initial values."""
        if starts == self._starts:
            return
        for key in self._starts:
            del self.fields[key]
        self._starts = starts
        self._box.clear()
        with self._box:
            self.fields |= {key: _styled(ui.input(text)) for key, text in starts.items()}

    async def _apply(self) -> None:
        refuse(self.fields, {})
        try:
            form, starts = self._form(), self._given()
            run = self.page.run
            await self.page.alter(
                lambda system: System(reshape(system.scene, form, starts)),
                run.restart,
                lambda before: run.undo.note(before, "structure and initial state", anew=True),
            )
        except InputError as error:
            named = (name for name in self.fields if f"{error.field}.".startswith(f"{name}."))
            refusals = {next(named, error.field): f"must be {error.allowed}"}
            if refuse(self.fields, refusals):
                self.page.say(str(error))

    def _text(self, name: str) -> str:
        return str(self.fields[name].value or "").strip()

    def _form(self) -> Form:
        terms = tuple(term for term, box in self.terms.items() if box.value)
        links = whole_number(self._text("rod.links"), "rod.links")
        return Form(links, self._text("rod.boundary"), self._text("rod.inertia"), terms)

    def _given(self) -> dict[str, Any]:
        """Initial values; None takes away what the scene has."""
        texts = {key: self._text(key) for key in self._starts}
        given = {key: text for key, text in texts.items() if not text.startswith(LIST)}
        return {key: _value(text, key) for key, text in given.items()}

    async def _uploaded(self, content: bytes) -> None:
        try:
            await self.page.take(await asyncio.to_thread(from_toml_text, content))
        except InputError as error:
            self.page.say(str(error))

    def _rejected(self) -> None:
        most = f"at most {LARGEST >> 20} MiB"
        self.page.say(f"A scene is a file of UTF-8 text that ends in {ENDING}, of {most}")


def _styled(field: Field) -> Field:
    """The field as all of the panel are."""
    return field.props("dense outlined options-dense").classes("rg-wide")


def _value(text: str, field: str) -> Any:
    """An initial value from its text: nothing, a number, two of them, or an expression, which the
    scene parses. Raises InputError."""
    if not text:
        return None
    if field in PAIRS:
        parts = text.replace(";", ",").split(",")
        if len(parts) != 2:
            raise InputError(field, text, "two numbers: x, y")
        return [number(part.strip(), field) for part in parts]
    try:
        return float(text)
    except ValueError:
        return text


def _shown_of(scene: Scene) -> tuple[Form, dict[str, str]]:
    """The form of a scene, and what fields show of it, by their names."""
    form = form_of(scene)
    texts = {"rod.links": str(form.links), "rod.boundary": form.boundary}
    starts = {key: entry(scene, *key.split(".")) for key in starts_of(scene)}
    shown = {name: _shown(value, name in PAIRS) for name, value in starts.items()}
    return form, {**texts, "rod.inertia": form.inertia, **shown}


def _shown(value: Any, pair: bool) -> str:
    """An initial value as text."""
    if isinstance(value, list):
        return ", ".join(map(plain, value)) if pair else f"{LIST} of {len(value)}"
    return value if isinstance(value, str) else plain(value)
