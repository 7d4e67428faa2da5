"""The plots of the page."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from nicegui import ui

from rodgen.view.live.quantities.catalogue import Catalogue
from rodgen.view.live.web.elements import Plots
from rodgen.view.live.web.plot_dialog import PlotDialog

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page

ENERGIES = ("kinetic_energy", "spring_energy", "gravity_energy", "total_energy")


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
            PlotDialog(self.catalogue, self.add)


def _first(catalogue: Catalogue) -> Iterator[dict[str, Any]]:
    """What a page shows at first."""
    phi = catalogue.kinds["phi"]
    yield {"kind": "time", "y": list(dict.fromkeys((phi[0], phi[-1]))), "window": 10.0}
    energies = [name for name in ENERGIES if name in catalogue.quantities]
    yield {"kind": "time", "y": energies, "window": 10.0, "title": "energies"}
