"""The plots of the page, and the dialog that adds one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from functools import partial
from typing import Any

from nicegui import ui

from rodgen.errors import InputError
from rodgen_live.page.elements import Plots
from rodgen_live.page.fields import Field, dialog, parse_number, show_refusals
from rodgen_live.page.page_run import PageRun
from rodgen_live.page.quantity_field import QuantityField
from rodgen_live.plot_quantities import KINDS, Catalogue
from rodgen_live.run.plot_spec import AXES, PLOT_KINDS
from rodgen_live.run.sample_curves import DIRECTIONS

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
    """Panel of the plots of the run, in its order."""

    def __init__(self, page: PageRun):
        self.page = page
        with ui.element("section").classes("rg-plots").props('aria-label="Plots"'):
            for label, icon, act in (
                ("Add plot", "add_chart", self._open_dialog),
                ("Flutter", "waves", self._add_flutter_plots),
            ):
                ui.button(label, icon=icon, on_click=act).props("flat dense no-caps")
            self.grid = Plots()
        self.grid.on_remove(self._remove)
        self.grid.on_move(self._arrange)
        self.grid.on_wrap(self._wrap)
        self.grid.on_pick(self._pick)
        self._drawn: dict[str, object] = {}  # of diagrams: what the page has
        if not page.run.plots and not page.run.greeted:
            for choice in first_plots(self.catalogue):
                page.submit(partial(page.run.add_plot, choice))

    @property
    def catalogue(self) -> Catalogue:
        """The quantities of the run."""
        return self.page.run.catalogue

    def refresh(self) -> None:
        """Show the plots that the run has now, and say what another rod does not have."""
        lost, self.page.run.unplotted = self.page.run.unplotted, ()
        if lost:
            self.page.notify(f"No longer plotted, as this scene has none: {', '.join(lost)}")
        diagrams = self.page.diagrams
        specs = [plot.to_json() for plot in list(self.page.run.plots.values())]
        specs += [one.spec for one in diagrams.values()]
        if specs != self.grid.specs:
            self.grid.set_specs(specs)
        for name, one in diagrams.items():
            if (one.rows, one.marks) != self._drawn.get(name):
                self.grid.draw(name, one.rows, one.marks)
        self._drawn = {name: (one.rows, one.marks) for name, one in diagrams.items()}

    async def add(self, choice: dict[str, Any]) -> None:
        """Add a plot. Raises InputError."""
        await self.page.call(lambda: self.page.run.add_plot(choice))

    async def _add_flutter_plots(self) -> None:
        """Add the plots that show flutter, before all others."""
        run = self.page.run

        def add() -> None:
            others = list(run.plots)
            for choice in flutter_plots(run.catalogue):
                run.add_plot(choice)
            run.arrange_plots([*(name for name in run.plots if name not in others), *others])

        await self.page.call(add)

    def _remove(self, name: str) -> None:
        self.page.diagrams.pop(name, None)
        self.page.submit(lambda: self.page.run.remove_plot(name))

    def _wrap(self, name: str, wrapped: bool) -> None:
        self.page.submit(lambda: self.page.run.wrap_plot(name, wrapped))

    def _pick(self, name: str, row: int) -> None:
        if (one := self.page.diagrams.get(name)) and row < len(one.points):
            self.page.start_task(one.take(one.points[row]))

    def _arrange(self, ids: list[str]) -> None:
        self.page.submit(lambda: self.page.run.arrange_plots(ids))

    def _open_dialog(self) -> None:
        with self.page.root:
            PlotDialog(self.catalogue, self.add)


class PlotDialog:
    """Dialog that asks what to plot and has `add` do it; a refusal is shown beside its field."""

    def __init__(self, catalogue: Catalogue, add: Callable[[dict[str, Any]], Awaitable[None]]):
        self.catalogue, self._put = catalogue, add
        self.fields: dict[str, Field] = {}
        self.names: dict[str, QuantityField] = {}
        with dialog("Add a plot", "Add", self._add) as self.dialog:
            self.kind = ui.select(
                PLOT_KINDS, value="time", label="kind of plot", on_change=self._show_fields
            )
            self.kind.props("dense outlined").classes("rg-wide")
            self.box = ui.element("div").classes("rg-knobs")
            ui.label(OWN).classes("rg-hint")
            self.refused = ui.label().classes("rg-failed").props('role="alert"')
        self._show_fields()

    def _show_fields(self) -> None:
        """Show only the fields of this kind of plot."""
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
            changed = self._show_units if name == "when" else None
            self.names[name] = QuantityField(
                self.catalogue, label, several=name == "y", changed=changed
            )
            return self.names[name].field
        return field.props("dense outlined options-dense hide-bottom-space").classes("rg-wide")

    def _show_units(self) -> None:
        """Show beside the value that is reached the unit of the quantity that reaches it."""
        for name in ("value", "every"):
            self.fields[name].props["suffix"] = self.names["when"].unit

    def _choice(self) -> dict[str, Any]:
        """Choices for PlotSpec. Raises InputError for what is no number."""
        choice = {"kind": self.kind.value}
        for name, field in self.fields.items():
            value = field.value
            if name in TYPED:
                value = str(value or "").strip()
                if not value and not TYPED[name]:
                    continue
                value = value if name == "title" else parse_number(value, name)
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
        """Show refusals beside their fields, and below them those without a field."""
        self.refused.set_text(show_refusals(self.fields, texts))


def flutter_plots(catalogue: Catalogue) -> Iterator[dict[str, Any]]:
    """Plots that show flutter: the angle of the tail against the other end over time, over its
    rate, and its spectrum."""
    angle, rate = (_against_first(catalogue.kinds[kind]) for kind in ("phi", "omega"))
    yield {"kind": "time", "y": [angle], "window": 10.0, "title": "tail"}
    yield {"kind": "phase", "x": angle, "y": [rate], "window": 10.0, "title": "phase plot"}
    yield {"kind": "spectrum", "y": [angle], "window": 20.0, "title": "spectrum of the tail"}


def _against_first(names: list[str]) -> str:
    """Last of some quantities less the first of them."""
    return f"{names[-1]} - {names[0]}" if len(names) > 1 else names[0]


def first_plots(catalogue: Catalogue) -> Iterator[dict[str, Any]]:
    """Plots that a page shows at first."""
    phi = catalogue.kinds["phi"]
    yield {"kind": "time", "y": list(dict.fromkeys((phi[0], phi[-1]))), "window": 10.0}
    yield {"kind": "time", "y": ["energy"], "window": 10.0}
