"""The plots of the page, and the dialog that adds one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from functools import partial
from typing import Any

from nicegui import ui

from rodgen.errors import InputError
from rodgen.live.catalogue import KINDS, Catalogue
from rodgen.live.page.elements import Plots
from rodgen.live.page.fields import Field, dialog, number, refuse
from rodgen.live.page.names import Names
from rodgen.live.page.runs import PageRun
from rodgen.live.run.curves import DIRECTIONS
from rodgen.live.run.plot_spec import AXES, PLOT_KINDS

OWN = "A quantity may be an expression: type it, such as phi_1 - phi_0 or d/dt(tip_x), and Enter."
TITLE = {"title": "title (made from what is shown if empty)"}
# By kind of plot: what is asked, by the key of PlotSpec that it is for.
FIELDS = {
    "time": {"y": "quantities", "window": "window", **TITLE},
    "difference": {"y": "quantities", "window": "window", **TITLE},
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
    "spectrum": {"y": "quantity", "window": "window", "axes": "axes", **TITLE},
}
CHOSEN: dict[str, dict[Any, str]] = {  # and by the key, what can be chosen, in words
    "direction": dict(zip(DIRECTIONS, DIRECTIONS, strict=True)),
    "axes": AXES,
}
TYPED = {"window": "10", "value": "0", "every": "", "title": ""}  # and what stands there at first


class PlotsPanel:
    """What is plotted: the plots of the run, in its order."""

    def __init__(self, page: PageRun):
        self.page = page
        with ui.element("section").classes("rg-plots").props('aria-label="Plots"'):
            ui.button("Add plot", icon="add_chart", on_click=self._ask).props("flat dense no-caps")
            self.grid = Plots()
        self.grid.on_removed(self._removed)
        self.grid.on_moved(self._moved)
        self.grid.on_wrapped(self._wrapped)
        if not page.run.plots and not page.run.greeted:
            for choice in first_plots(self.catalogue):
                page.soon(partial(page.run.add_plot, choice))

    @property
    def catalogue(self) -> Catalogue:
        """The quantities of the run."""
        return self.page.run.catalogue

    def refresh(self) -> None:
        """Show the plots that the run has now, and say what another rod does not have."""
        lost, self.page.run.unplotted = self.page.run.unplotted, ()
        if lost:
            self.page.say(f"No longer plotted, as this scene has none: {', '.join(lost)}")
        specs = [plot.to_json() for plot in list(self.page.run.plots.values())]
        if specs != self.grid.specs:
            self.grid.put(specs)

    async def add(self, choice: dict[str, Any]) -> None:
        """Add a plot. Raises InputError."""
        await self.page.do(lambda: self.page.run.add_plot(choice))

    def _removed(self, name: str) -> None:
        self.page.soon(lambda: self.page.run.remove_plot(name))

    def _wrapped(self, name: str, wrapped: bool) -> None:
        self.page.soon(lambda: self.page.run.wrap_plot(name, wrapped))

    def _moved(self, ids: list[str]) -> None:
        self.page.soon(lambda: self.page.run.arrange_plots(ids))

    def _ask(self) -> None:
        with self.page.root:
            PlotDialog(self.catalogue, self.add)


class PlotDialog:
    """Asks what is to be plotted and has `add` do it; a refusal is said beside its field."""

    def __init__(self, catalogue: Catalogue, add: Callable[[dict[str, Any]], Awaitable[None]]):
        self.catalogue, self._put = catalogue, add
        self.fields: dict[str, Field] = {}
        self.names: dict[str, Names] = {}
        with dialog("Add a plot", "Add", self._add) as self.dialog:
            self.kind = ui.select(
                PLOT_KINDS, value="time", label="kind of plot", on_change=self._switch
            )
            self.kind.props("dense outlined").classes("rg-wide")
            self.box = ui.element("div").classes("rg-knobs")
            ui.label(OWN).classes("rg-hint")
            self.refused = ui.label().classes("rg-failed").props('role="alert"')
        self._switch()

    def _switch(self) -> None:
        """Show the fields of this kind of plot alone."""
        before = {field.label: field.value for field in self.fields.values()}
        self.box.clear()
        self.names = {}
        with self.box:
            fields = FIELDS[self.kind.value]
            self.fields = {name: self._field(name, label) for name, label in fields.items()}
        for field in self.fields.values():
            field.value = before.get(field.label, field.value)
        if "window" in self.fields:
            self.fields["window"].props('suffix="s"')
        self._refuse({})

    def _field(self, name: str, label: str) -> Field:
        field: Field
        if name in TYPED:
            field = ui.input(label, value=TYPED[name]).on("keydown.enter", self._add)
        elif name in CHOSEN:
            field = ui.select(CHOSEN[name], value=next(iter(CHOSEN[name])), label=label)
        elif name == "y" and self.kind.value == "profile":
            along = {kind: KINDS[kind].title for kind in self.catalogue.along}
            field = ui.select(along, label=label, with_input=True)
        else:
            changed = self._units if name == "when" else None
            self.names[name] = Names(self.catalogue, label, several=name == "y", changed=changed)
            return self.names[name].field
        return field.props("dense outlined options-dense hide-bottom-space").classes("rg-wide")

    def _units(self) -> None:
        """Give the value that is reached the unit of what reaches it."""
        for name in ("value", "every"):
            self.fields[name].props["suffix"] = self.names["when"].unit

    def _choice(self) -> dict[str, Any]:
        """What was chosen, for PlotSpec. Raises InputError for what is no number."""
        choice = {"kind": self.kind.value}
        for name, field in self.fields.items():
            value = field.value
            if name in TYPED:
                value = str(value or "").strip()
                if not value and not TYPED[name]:
                    continue
                value = value if name == "title" else number(value, name)
            choice[name] = value
        for name, of in self.names.items():
            chosen = of.names()
            choice[name] = chosen if name == "y" else chosen[0]
        return choice

    async def _add(self) -> None:
        asked = [name for name in self.fields if name not in TYPED and name not in CHOSEN]
        empty = [name for name in asked if not self.fields[name].value]
        self._refuse(dict.fromkeys(empty, "not chosen"))
        if empty:
            return
        try:
            await self._put(self._choice())
        except InputError as error:
            name = error.field.removeprefix("plot.").partition("[")[0]
            # Which of a kind: that is said there.
            self._refuse({} if name == "which" else {name: f"must be {error.allowed}"})
        else:
            self.dialog.close()

    def _refuse(self, texts: dict[str, str]) -> None:
        """Say what is refused beside its field, and below them what has none."""
        self.refused.set_text(refuse(self.fields, texts))


def first_plots(catalogue: Catalogue) -> Iterator[dict[str, Any]]:
    """Plots that a page shows at first."""
    phi = catalogue.kinds["phi"]
    yield {"kind": "time", "y": list(dict.fromkeys((phi[0], phi[-1]))), "window": 10.0}
    yield {"kind": "time", "y": ["energy"], "window": 10.0}
