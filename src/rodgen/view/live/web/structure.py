"""What the module is specialised to, and the initial state: changed together, from the start."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from nicegui import events, ui

from rodgen.scene import Scene, SceneError
from rodgen.scene.structure import BOUNDARIES, INERTIAS, TERMS
from rodgen.view.live.restructured import Form, form_of, restructured
from rodgen.view.live.scenes import LARGEST, from_toml_text
from rodgen.view.live.web.entry import number

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page

INITIAL = {
    "phi": "phi: a number, or an expression in s",
    "omega": "omega: a number, or an expression in s",
    "position": "position x, y of joint 0 [m]",
    "velocity": "velocity x, y of joint 0 [m/s]",
}
LIST = "(a list)"  # stands for values that are too many for a field


class StructurePanel:
    """Number of links, boundary, inertia, terms, initial state; and scenes from files."""

    def __init__(self, page: Page):
        self.page = page
        self._scene: Scene | None = None
        _title("Structure")
        with ui.element("div").classes("rg-knobs"):
            self.links = ui.input("number of links")
            self.boundary = ui.select(list(BOUNDARIES), label="boundary")
            self.inertia = ui.select(list(INERTIAS), label="inertia of a link")
            with ui.element("div").classes("rg-terms").props('role="group" aria-label="Terms"'):
                self.terms = {
                    term: ui.checkbox(term.replace("_", " ")).props("dense") for term in TERMS
                }
        _title("Initial state")
        with ui.element("div").classes("rg-knobs"):
            self.initial = {name: ui.input(text) for name, text in INITIAL.items()}
        for field in (self.links, self.boundary, self.inertia, *self.initial.values()):
            field.props("dense outlined options-dense").classes("rg-wide")
        ui.button("Apply and restart", icon="restart_alt", on_click=self._apply).props("no-caps")
        ui.label(
            "Another structure is derived and compiled first; other values need no restart."
        ).classes("rg-hint")
        _title("From a file")
        self.upload = ui.upload(
            label="A scene in TOML", on_upload=self._uploaded, on_rejected=self._rejected,
            max_file_size=LARGEST, max_files=1, auto_upload=True,
        ).props("accept=.toml flat bordered")  # fmt: skip
        self.upload.classes("rg-wide")

    def refresh(self) -> None:
        """As the scene is now, where that is another than before."""
        scene = self.page.scene
        if self._scene is not None and _same(scene, self._scene):
            return
        self._scene, form = scene, form_of(scene)
        self.links.set_value(str(form.links))
        self.boundary.set_value(form.boundary)
        self.inertia.set_value(form.inertia)
        for term, box in self.terms.items():
            box.set_value(term in form.terms)
        for name, field in self.initial.items():
            field.set_value(_shown(getattr(scene.initial, name)))
        self._refused({})

    async def _apply(self) -> None:
        self._refused({})
        try:
            form, initial = self._form(), self._initial()
            run = self.page.run
            await self.page.alter(lambda scene: restructured(scene, form, initial), run.restart)
        except SceneError as error:
            name = error.field.partition(".")[2].partition(".")[0]  # initial.position.0: a part
            if name in self._fields():
                self._refused({name: f"must be {error.allowed}"})
            else:
                self.page.say(str(error))

    def _form(self) -> Form:
        try:
            links = int(str(self.links.value).strip())
        except ValueError:
            raise SceneError("rod.links", self.links.value, "a whole number") from None
        terms = tuple(term for term, box in self.terms.items() if box.value)
        return Form(links, str(self.boundary.value), str(self.inertia.value), terms)

    def _initial(self) -> dict[str, Any]:
        """Values by key; None takes away what the scene has."""
        found: dict[str, Any] = {}
        for name, field in self.initial.items():
            text = str(field.value or "").strip()
            if text.startswith(LIST):
                continue
            if not text:
                found[name] = None
            elif name in ("position", "velocity"):
                parts = text.replace(";", ",").split(",")
                if len(parts) != 2:
                    raise SceneError(f"initial.{name}", text, "two numbers: x, y")
                found[name] = [number(part.strip(), f"initial.{name}") for part in parts]
            else:
                try:
                    found[name] = float(text)
                except ValueError:
                    found[name] = text  # an expression: the scene parses it
        return found

    def _fields(self) -> dict[str, Any]:
        return {"links": self.links, "boundary": self.boundary, **self.initial}

    def _refused(self, texts: dict[str, str]) -> None:
        """What is said beside each field."""
        for name, field in self._fields().items():
            field.error = texts.get(name)

    async def _uploaded(self, event: events.UploadEventArguments) -> None:
        self.upload.reset()
        try:
            content = await event.file.read()  # the server has refused what is longer than 2 MiB
            await self.page.take(await asyncio.to_thread(from_toml_text, content))
        except SceneError as error:
            self.page.say(str(error))

    def _rejected(self) -> None:
        self.page.say(f"A scene is a file that ends in .toml, of at most {LARGEST >> 20} MiB")


def _title(text: str) -> None:
    ui.label(text).classes("rg-title").props("role=heading aria-level=2")


def _same(one: Scene, other: Scene) -> bool:
    return form_of(one) == form_of(other) and one.initial == other.initial


def _shown(value: Any) -> str:
    """An initial value as text."""
    if value is None:
        return ""
    if isinstance(value, list):
        return f"{value[0]:.10g}, {value[1]:.10g}" if len(value) == 2 else f"{LIST} of {len(value)}"
    return value if isinstance(value, str) else f"{value:.10g}"
