"""What of a live run keeps the plots of its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from rodgen.errors import InputError
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.comparing import Comparing
from rodgen.live.run.plot import Plot
from rodgen.live.run.plot_spec import PlotSpec, lacking, transfer

MOST_PLOTS = 24
Chosen = tuple[PlotSpec, Catalogue]  # a plot, and of which rod it is


class Plotting(Comparing):
    """The part of a LiveRun that adds, removes and orders plots."""

    _numbers: Iterator[int]  # of plots to come
    unplotted: tuple[str, ...] = ()  # what plots showed and the rod that came last does not have
    _left: tuple[Chosen, ...] = ()  # plots of which that has nothing
    _whole: Mapping[str, Chosen] = MappingProxyType({})  # and those of which it has a part

    def new_name(self) -> str:
        """A name of a plot, unlike all before."""
        return f"p{next(self._numbers)}"

    def add_plot(self, choice: dict[str, Any]) -> None:
        """Add a plot, which begins with what was before it. Raises InputError."""
        if len(self.plots) >= MOST_PLOTS:
            raise InputError("plots", len(self.plots) + 1, f"at most {MOST_PLOTS} on a page")
        spec = PlotSpec.from_dict({**choice, "id": self.new_name()}, self.catalogue)
        self.plots[spec.id] = plot = Plot(spec, self.catalogue)
        plot.beside = self.ghost
        self.page.added(plot, self.store.chunks())
        self._changed()

    def _transfer_plots(self, catalogue: Catalogue) -> None:
        """Have the plots of another rod, as far as it has their quantities. What it does not have
        comes back with a rod that has it."""
        shown = {name: (plot.spec, plot.catalogue) for name, plot in self.plots.items()}
        missing = (name for spec, of in shown.values() for name in lacking(spec, of, catalogue))
        self.unplotted = tuple(dict.fromkeys(missing))
        chosen = [self._whole.get(name, one) for name, one in shown.items()]
        self.plots, whole, left = {}, {}, []
        for spec, of in (*chosen, *self._left):
            moved = transfer(spec, self.new_name(), of, catalogue)
            if moved is None or len(self.plots) == MOST_PLOTS:
                left.append((spec, of))
                continue
            self.plots[moved.id] = plot = Plot(moved, catalogue)
            plot.beside = self.ghost
            if lacking(spec, of, catalogue):
                whole[moved.id] = spec, of
        self._left, self._whole = tuple(left[:MOST_PLOTS]), whole
        self.page.compared(self.plots)

    def _renew_plots(self) -> None:
        """Have plots of all energies show those that there are by now."""
        if not self.catalogue.settle(self.live.t, self.live.p):
            return
        shown, self.plots = self.plots, {}
        for name, plot in shown.items():
            made = Plot(replace(plot.spec, id=self.new_name()), self.catalogue)
            if made.names != plot.names:
                self.page.removed(name)
                name, plot, made.beside = made.spec.id, made, self.ghost
                self.page.added(plot, self.store.chunks())
            self.plots[name] = plot

    def wrap_plot(self, name: str, wrapped: bool) -> None:
        """Have the page show the angles of this plot, if it is there, without their whole turns, or
        as they are."""
        if name in self.plots:
            plot = self.plots[name]
            plot.spec = replace(plot.spec, wrapped=wrapped)
            self._changed()

    def remove_plot(self, name: str) -> None:
        """Remove the plot of this name, if it is there."""
        self.plots.pop(name, None)
        self.page.removed(name)
        self._changed()

    def arrange_plots(self, names: list[str]) -> None:
        """Show the plots in another order."""
        place = {name: at for at, name in enumerate(names)}
        ordered = sorted(self.plots, key=lambda name: place.get(name, len(place)))
        self.plots = {name: self.plots[name] for name in ordered}
