"""The plots of the page, and the dialog that adds one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from rodgen.errors import InputError
from rodgen_live.page.elements import Plots
from rodgen_live.page.fields import Field, dialog, parse_number, show_refusals, text_of
from rodgen_live.page.page_run import PageRun
from rodgen_live.page.quantity_field import QuantityField
from rodgen_live.plot_quantities import KINDS, Catalogue
from rodgen_live.run.plot_spec import AXES, PLOT_KINDS
from rodgen_live.run.sample_curves import DIRECTIONS

OWN = "A quantity may be an expression: type it, such as phi_1 - phi_0 or d/dt(tip_x), and Enter."
OVER_TIME = {"y": "quantities", "window": "window [s]"}
# By kind of plot: what is asked, by the key of PlotSpec that it is for.
FIELDS = {
    "time": OVER_TIME,
    "difference": OVER_TIME,
    "phase": {"y": "quantity", "x": "over", "window": "window [s]"},
    "poincare": {
        "y": "quantity",
        "x": "over",
        "when": "points where",
        "value": "reaches the value",
        "every": "and again after every further (never if empty)",
        "direction": "while it is",
    },
    "profile": {"y": "kind of quantity"},
    "spectrum": {"y": "quantity", "window": "window [s]", "axes": "axes"},
}
TITLE = {"title": "title (made from what is shown if empty)"}  # is asked of all
# By the key, what can be chosen, in words.
CHOSEN: dict[str, Any] = {"direction": {name: name for name in DIRECTIONS}, "axes": AXES}
# On a phone they are below all parameters.
SHOW_FIRST = "document.querySelector('.rodgen-plot').scrollIntoView({ block: 'nearest' })"
TYPED = {"window": "10", "value": "0", "every": "", "title": ""}  # and what stands there at first


class PlotsPanel:
    """Panel of the plots of the run, in its order."""

    def __init__(self, page: PageRun):
        self.page = page
        with ui.element("div").classes("rg-adds"):
            for label, icon, act in (
                ("Add plot", "add_chart", lambda: PlotDialog(page)),
                ("Flutter", "waves", self._add_flutter_plots),
            ):
                ui.button(label, icon=icon, on_click=act).props("flat dense")
        with ui.element("section").classes("rg-plots").props('aria-label="Plots"'):
            self.grid = Plots(specs=[])
        self.grid.on("removed", lambda event: self._remove(event.args["id"]))
        self.grid.on("moved", lambda event: page.submit(page.run.arrange_plots, event.args["ids"]))
        self.grid.on("wrapped", self._wrap)
        self.grid.on("picked", lambda event: self._pick(event.args["id"], event.args["row"]))
        self._drawn: dict[str, Any] = {}  # of diagrams: rows and marks that the page has
        if not page.run.plots and not page.run.greeted:
            for choice in first_plots(page.run.catalogue):
                page.submit(page.run.add_plot, choice)

    def refresh(self) -> None:
        """Show the plots that the run has now, and say what another rod does not have."""
        lost, self.page.run.unplotted = self.page.run.unplotted, ()
        if lost:
            self.page.notify(f"No longer plotted, as this scene has none: {', '.join(lost)}")
        diagrams = self.page.diagrams
        specs = [plot.to_json() for plot in list(self.page.run.plots.values())]
        specs += [one.spec for one in diagrams.values()]
        if specs != self.grid.props["specs"]:
            self.grid.props["specs"] = specs
        before, self._drawn = self._drawn, {k: (v.rows, v.marks) for k, v in diagrams.items()}
        for name, drawn in self._drawn.items():
            if drawn != before.get(name):
                self.grid.run_method("sweep", name, *drawn)

    async def _add_flutter_plots(self) -> None:
        run = self.page.run

        def add() -> None:
            others = list(run.plots)
            titles = [plot.spec.title for plot in run.plots.values()]
            for choice in flutter_plots(run.catalogue):
                if choice["title"] not in titles:  # as it is from a first press
                    run.add_plot(choice)
            run.arrange_plots([*(name for name in run.plots if name not in others), *others])

        await self.page.call(add)
        ui.run_javascript(SHOW_FIRST)

    def _remove(self, name: str) -> None:
        self.page.diagrams.pop(name, None)
        self.page.submit(self.page.run.remove_plot, name)

    def _wrap(self, event: GenericEventArguments) -> None:
        wrap = self.page.run.wrap_plot
        self.page.submit(wrap, event.args["id"], bool(event.args["wrapped"]))

    def _pick(self, name: str, row: int) -> None:
        if (one := self.page.diagrams.get(name)) and row < len(one.points):
            self.page.start_task(one.take(one.points[row]))


class PlotDialog:
    """Dialog that asks what to plot; a refusal is shown beside its field."""

    def __init__(self, page: PageRun):
        self.page = page
        self.fields: dict[str, Field] = {}
        self.names: dict[str, QuantityField] = {}
        with page.root, dialog("Add a plot", "Add", self._add) as self.dialog:
            self.kind = ui.select(
                PLOT_KINDS, value="time", label="kind of plot", on_change=self._show_fields
            )
            self.kind.classes("rg-wide")
            self.box = ui.element("div").classes("rg-knobs")
            ui.label(OWN).classes("rg-hint")
            self.refused = ui.label().classes("rg-failed").props('role="alert"')
        self._show_fields()

    def _show_fields(self) -> None:
        before = {field.label: field.value for field in self.fields.values()}
        self.box.clear()
        self.names = {}
        with self.box:
            fields = FIELDS[self.kind.value] | TITLE
            self.fields = {name: self._field(name, label) for name, label in fields.items()}
        for field in self.fields.values():
            field.value = before.get(field.label, field.value)
        self._refuse({})

    def _field(self, name: str, label: str) -> Field:
        field: Field
        if name in TYPED:
            field = ui.input(label, value=TYPED[name]).on("keydown.enter", self._add)
        elif name in CHOSEN:
            field = ui.select(CHOSEN[name], value=next(iter(CHOSEN[name])), label=label)
        elif name == "y" and self.kind.value == "profile":
            along = {kind: KINDS[kind].title for kind in self.page.run.catalogue.along}
            field = ui.select(along, label=label, with_input=True)
        else:
            several = name == "y" and label == "quantities"
            self.names[name] = QuantityField(self.page.run.catalogue, label, several)
            return self.names[name].field
        return field.props("hide-bottom-space").classes("rg-wide")

    def _choice(self) -> dict[str, Any]:
        """Choices for PlotSpec. Raises InputError for what is no number."""
        choice = {"kind": self.kind.value}
        for name, field in self.fields.items():
            if name in self.names:
                chosen = self.names[name].names()
                choice[name] = chosen if name == "y" else chosen[0]
            elif name not in TYPED:
                choice[name] = field.value
            elif (text := text_of(field)) or TYPED[name]:
                choice[name] = text if name == "title" else parse_number(text, name)
        return choice

    async def _add(self) -> None:
        asked = [name for name in self.fields if name not in TYPED and name not in CHOSEN]
        empty = [name for name in asked if not self.fields[name].value]
        self._refuse(dict.fromkeys(empty, "not chosen"))
        if empty:
            return
        try:
            await self.page.call(self.page.run.add_plot, self._choice())
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
    """Plots that show flutter: how far the tail is aside over time, its rate over it, and its
    spectrum; of a single link that turns, its angle."""
    aside, rate = "tail_deflection", "tail_deflection_rate"
    if len(catalogue.kinds["phi"]) < 2:
        aside, rate = catalogue.kinds["phi"][0], catalogue.kinds["omega"][0]
    yield {"kind": "time", "y": [aside], "window": 10.0, "title": "tail"}
    yield {"kind": "phase", "x": aside, "y": [rate], "window": 10.0, "title": "phase plot"}
    yield {"kind": "spectrum", "y": [aside], "window": 20.0, "title": "spectrum of the tail"}


def first_plots(catalogue: Catalogue) -> Iterator[dict[str, Any]]:
    """Plots that a page shows at first."""
    phi = catalogue.kinds["phi"]
    yield {"kind": "time", "y": list(dict.fromkeys((phi[0], phi[-1]))), "window": 10.0}
    yield {"kind": "time", "y": ["energy"], "window": 10.0}
