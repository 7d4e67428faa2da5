"""The dialog that adds a plot."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from nicegui import ui

from rodgen.scene import SceneError
from rodgen.view.live.plots.poincare import DIRECTIONS
from rodgen.view.live.quantities.catalogue import KINDS, Catalogue
from rodgen.view.live.web.entry import number

KINDS_OF_PLOTS = {
    "time": "over time",
    "phase": "one over another (phase plot)",
    "poincare": "Poincaré section",
    "profile": "all of a kind along the rod",
    "spectrum": "spectrum",
}
TITLE = {"title": "title (made from what is shown if empty)"}
# By kind of plot: what is asked, by the key of PlotSpec that it is for.
FIELDS = {
    "time": {"y": "quantities", "window": "window", **TITLE},
    "phase": {"y": "quantity", "x": "over", "window": "window", **TITLE},
    "poincare": {
        "y": "quantity",
        "x": "over",
        "when": "points where",
        "value": "reaches the value",
        "every": "and again after every further (never if empty)",
        "direction": "while it is",
        **TITLE,
    },
    "profile": {"y": "kind of quantity", **TITLE},
    "spectrum": {"y": "quantity", "window": "window", **TITLE},
}
TYPED = {"window": "10", "value": "0", "every": "", "title": ""}  # and what stands there at first
Field = ui.input | ui.select


class PlotDialog:
    """Asks what is to be plotted and has `add` do it; a refusal is said beside its field."""

    def __init__(self, catalogue: Catalogue, add: Callable[[dict[str, Any]], Awaitable[None]]):
        self.catalogue, self._put = catalogue, add
        self.fields: dict[str, Field] = {}
        with ui.dialog() as self.dialog, ui.card().classes("rg-dialog"):
            ui.label("Add a plot").classes("rg-title").props("role=heading aria-level=2")
            self.kind = ui.select(
                KINDS_OF_PLOTS, value="time", label="kind of plot", on_change=self._switch
            )
            self.kind.props("dense outlined").classes("rg-wide")
            self.box = ui.element("div").classes("rg-knobs")
            self.refused = ui.label().classes("rg-failed").props('role="alert"')
            with ui.row():
                ui.button("Add", on_click=self._add).props("no-caps")
                ui.button("Cancel", on_click=self.dialog.close).props("flat no-caps")
        self._switch()
        self.dialog.on("hide", self.dialog.delete)
        self.dialog.open()

    def _switch(self) -> None:
        """The fields of this kind of plot alone: the quantities of a long rod are many to send."""
        before = {field.label: field.value for field in self.fields.values()}
        self.box.clear()
        with self.box:
            fields = FIELDS[self.kind.value]
            self.fields = {name: self._field(name, label) for name, label in fields.items()}
        for field in self.fields.values():
            field.value = before.get(field.label, field.value)
        if "window" in self.fields:
            self.fields["window"].props('suffix="s"')
        if "when" in self.fields:
            self.fields["when"].on_value_change(self._units)
            self._units()
        self._refuse({})

    def _field(self, name: str, label: str) -> Field:
        field: Field
        if name in TYPED:
            field = ui.input(label, value=TYPED[name]).on("keydown.enter", self._add)
        elif name == "direction":
            field = ui.select(list(DIRECTIONS), value=DIRECTIONS[0], label=label)
        else:  # typing narrows the names down
            many = label == "quantities"
            field = ui.select(
                self._options(label), label=label, with_input=True, multiple=many, clearable=True
            )
            field.props("input-debounce=0" + " use-chips" * many)
        return field.props("dense outlined options-dense hide-bottom-space").classes("rg-wide")

    def _options(self, label: str) -> dict[str, str]:
        """What can be chosen, by name, in words."""
        if label == "kind of quantity":
            return {kind: KINDS[kind].title for kind in self.catalogue.along}
        single = {
            name: f"{q.label if q.label != name else KINDS[q.kind].title}  ({name})"
            for name, q in self.catalogue.quantities.items()
        }
        kinds = self.catalogue.kinds.items() if label == "quantities" else ()
        several = {
            kind: f"{KINDS[kind].title}, all {len(names)}" for kind, names in kinds if names[1:]
        }
        return several | single

    def _units(self) -> None:
        """The value that is reached has the unit of what reaches it."""
        when = self.catalogue.quantities.get(self.fields["when"].value)
        for name in ("value", "every"):
            self.fields[name].props["suffix"] = when.unit if when else ""

    def _choice(self) -> dict[str, Any]:
        """What was chosen, for PlotSpec. Raises SceneError for what is no number."""
        choice = {"kind": self.kind.value}
        for name, field in self.fields.items():
            value = field.value
            if name in TYPED:
                value = str(value or "").strip()
                if not value and not TYPED[name]:
                    continue
                value = value if name == "title" else number(value, name)
            choice[name] = value
        return choice

    async def _add(self) -> None:
        empty = [name for name, f in self.fields.items() if name not in TYPED and not f.value]
        self._refuse(dict.fromkeys(empty, "not chosen"))
        if empty:
            return
        try:
            await self._put(self._choice())
        except SceneError as error:
            name = error.field.removeprefix("plot.").partition("[")[0]
            self._refuse({name: f"must be {error.allowed}"})
        else:
            self.dialog.close()

    def _refuse(self, texts: dict[str, str]) -> None:
        """What is said beside each field; of what has no field, below them."""
        for name, field in self.fields.items():
            field.error = texts.get(name)
        other = [f"{name} {text}" for name, text in texts.items() if name not in self.fields]
        self.refused.set_text("; ".join(other))
