"""The plots of a live run: added, removed, ordered, and transferred to another rod."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from rodgen.errors import InputError
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.plot import Plot
from rodgen_live.run.plot_spec import PlotSpec, missing_labels, transfer
from rodgen_live.run.run_comparison import ComparisonMixin

MOST_PLOTS = 24
Chosen = tuple[PlotSpec, Catalogue]  # a plot, and of which rod it is


class PlotsMixin(ComparisonMixin):
    """The part of a LiveRun that adds, removes and orders plots."""

    _numbers: Iterator[int]  # of plots to come
    unplotted: tuple[str, ...] = ()  # what plots showed and the rod that came last does not have
    _left: tuple[Chosen, ...] = ()  # plots of which that has nothing
    _whole: Mapping[str, Chosen] = MappingProxyType({})  # and those of which it has a part

    def new_plot_name(self) -> str:
        """Make a name for a plot, unlike all before."""
        return f"p{next(self._numbers)}"

    def add_plot(self, choice: dict[str, Any]) -> None:
        """Add a plot, with rows of the samples so far. Raises InputError."""
        if len(self.plots) >= MOST_PLOTS:
            raise InputError("plots", len(self.plots) + 1, f"at most {MOST_PLOTS} on a page")
        spec = PlotSpec.from_dict({**choice, "id": self.new_plot_name()}, self.catalogue)
        self.plots[spec.id] = plot = Plot(spec, self.catalogue)
        plot.beside = self.ghost
        self.page.add_plot(plot, self.store.chunks())
        self._notify_page()

    def _transfer_plots(self, catalogue: Catalogue) -> None:
        """Transfer the plots to another rod, as far as it has their quantities. What it does not
        have comes back with a rod that has it."""
        shown = {name: (plot.spec, plot.catalogue) for name, plot in self.plots.items()}
        missing = (
            name for spec, of in shown.values() for name in missing_labels(spec, of, catalogue)
        )
        self.unplotted = tuple(dict.fromkeys(missing))
        chosen = [self._whole.get(name, one) for name, one in shown.items()]
        self.plots, whole, left = {}, {}, []
        for spec, of in (*chosen, *self._left):
            moved = transfer(spec, self.new_plot_name(), of, catalogue)
            if moved is None or len(self.plots) == MOST_PLOTS:
                left.append((spec, of))
                continue
            self.plots[moved.id] = plot = Plot(moved, catalogue)
            plot.beside = self.ghost
            if missing_labels(spec, of, catalogue):
                whole[moved.id] = spec, of
        self._left, self._whole = tuple(left[:MOST_PLOTS]), whole
        self.page.resend_ghosts(self.plots)

    def _rebuild_plots(self) -> None:
        """Rebuild plots of all energies if others of these are zero than before."""
        if not self.catalogue.update_zero_energies(self.live.t, self.live.p):
            return
        shown, self.plots = self.plots, {}
        for name, plot in shown.items():
            made = Plot(replace(plot.spec, id=self.new_plot_name()), self.catalogue)
            if made.names != plot.names:
                self.page.remove_plot(name)
                name, plot, made.beside = made.spec.id, made, self.ghost
                self.page.add_plot(plot, self.store.chunks())
            self.plots[name] = plot

    def wrap_plot(self, name: str, wrapped: bool) -> None:
        """Show the angles of this plot, if it is there, without their whole turns, or as they
        are."""
        if name in self.plots:
            plot = self.plots[name]
            plot.spec = replace(plot.spec, wrapped=wrapped)
            self._notify_page()

    def remove_plot(self, name: str) -> None:
        """Remove the plot of this name, if it is there."""
        self.plots.pop(name, None)
        self.page.remove_plot(name)
        self._notify_page()

    def arrange_plots(self, names: list[str]) -> None:
        """Show the plots in another order."""
        place = {name: at for at, name in enumerate(names)}
        ordered = sorted(self.plots, key=lambda name: place.get(name, len(place)))
        self.plots = {name: self.plots[name] for name in ordered}
