"""The plots of the page, and the dialog that adds one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from nicegui import ui

from rodgen.scene import SceneError
from rodgen.view.live.catalogue import KINDS, Catalogue
from rodgen.view.live.web.elements import Plots
from rodgen.view.live.web.entry import number

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page

KINDS_OF_PLOTS = {
    "time": "over time",
    "phase": "one over another (phase plot)",
    "poincare": "Poincaré section",
    "profile": "all of a kind along the rod",
    "spectrum": "spectrum",
}


class PlotsPanel:
    """What is plotted: the plots of the run, in its order."""

    def __init__(self, page: Page):
        self.page = page
        with ui.element("section").classes("rg-plots").props('aria-label="Plots"'):
            ui.button("Add plot", icon="add_chart", on_click=self._ask).props("flat dense no-caps")
            self.grid = Plots()
        self.grid.on_removed(self._removed)
        self.grid.on_moved(self._moved)
        if not page.run.plots and not page.run.greeted:
            page.run.greeted = True
            for choice in _first(self.catalogue):
                page.soon(partial(page.run.add_plot, choice))

    @property
    def catalogue(self) -> Catalogue:
        """The quantities of the run."""
        return self.page.run.catalogue

    def refresh(self) -> None:
        """As the run has them now."""
        specs = [plot.to_json() for plot in list(self.page.run.plots.values())]
        if specs != self.grid.specs:
            self.grid.put(specs)

    async def add(self, choice: dict[str, Any]) -> None:
        """Another plot. Raises SceneError."""
        await self.page.do(lambda: self.page.run.add_plot(choice))

    def _removed(self, name: str) -> None:
        self.page.soon(lambda: self.page.run.remove_plot(name))

    def _moved(self, ids: list[str]) -> None:
        self.page.soon(lambda: self.page.run.arrange_plots(ids))

    def _ask(self) -> None:
        with self.page.root:
            PlotDialog(self)


def _first(catalogue: Catalogue) -> Iterator[dict[str, Any]]:
    """What a page shows at first."""
    phi = catalogue.kinds["phi"]
    yield {"kind": "time", "y": list(dict.fromkeys((phi[0], phi[-1]))), "window": 10.0}
    energies = [name for name in ENERGIES if name in catalogue.quantities]
    yield {"kind": "time", "y": energies, "window": 10.0, "title": "energies"}


ENERGIES = ("kinetic_energy", "spring_energy", "gravity_energy", "total_energy")


class PlotDialog:
    """Asks what is to be plotted; what cannot be is said beside the field."""

    def __init__(self, panel: PlotsPanel):
        self.panel, catalogue = panel, panel.catalogue
        single = {name: f"{q.label}  ({name})" for name, q in catalogue.quantities.items()}
        kinds = {name: f"all {KINDS[name].title}" for name in catalogue.kinds if name in KINDS}
        with ui.dialog() as self.dialog, ui.card().classes("rg-dialog"):
            ui.label("Add a plot").classes("rg-title").props("role=heading aria-level=2")
            self.kind = ui.select(
                KINDS_OF_PLOTS, value="time", label="kind of plot", on_change=self._switch
            )
            self.many = _choose({**kinds, **single}, "quantities", multiple=True)
            self.one = _choose(single, "quantity")
            self.x = _choose(single, "over")
            along = {name: kinds.get(name, name) for name in catalogue.along}
            self.along = _choose(along, "kind of quantity")
            self.when = _choose(single, "points where")
            self.value = ui.input("reaches the value", value="0")
            self.direction = ui.select(
                ["rising", "falling", "either"], value="rising", label="while it is"
            )
            self.window = ui.input("window", value="10").props('suffix="s"')
            self.refused = ui.label().classes("rg-failed").props('role="alert"')
            with ui.row():
                ui.button("Add", on_click=self._add)
                ui.button("Cancel", on_click=self.dialog.close).props("flat")
        for field in (self.kind, self.value, self.direction, self.window):
            field.props("dense outlined").classes("rg-wide")
        self._switch()
        self.dialog.on("hide", self.dialog.delete)
        self.dialog.open()

    def _switch(self) -> None:
        """The fields that this kind of plot has."""
        kind = self.kind.value
        shown = {
            self.many: kind == "time",
            self.one: kind in ("phase", "poincare", "spectrum"),
            self.x: kind in ("phase", "poincare"),
            self.along: kind == "profile",
            self.when: kind == "poincare",
            self.value: kind == "poincare",
            self.direction: kind == "poincare",
            self.window: kind in ("time", "phase", "spectrum"),
        }
        for field, visible in shown.items():
            field.set_visibility(visible)

    def _choice(self) -> dict[str, Any]:
        kind = self.kind.value
        y = {"time": self.many.value, "profile": self.along.value}.get(kind, self.one.value)
        choice: dict[str, Any] = {"kind": kind, "y": y or []}
        if kind in ("phase", "poincare"):
            choice["x"] = self.x.value or ""
        if kind == "poincare":
            choice |= {"when": self.when.value or "", "direction": self.direction.value}
            choice["value"] = number(self.value.value, "value")
        if kind in ("time", "phase", "spectrum"):
            choice["window"] = number(self.window.value, "window")
        return choice

    async def _add(self) -> None:
        try:
            await self.panel.add(self._choice())
        except SceneError as error:
            self.refused.set_text(str(error))
            return
        self.dialog.close()


def _choose(options: dict[str, str], label: str, *, multiple: bool = False) -> ui.select:
    """One of many names, or some: typing narrows them down."""
    field = ui.select(options, label=label, with_input=True, multiple=multiple, clearable=True)
    field.props("dense outlined options-dense input-debounce=0" + " use-chips" * multiple)
    return field.classes("rg-wide")
