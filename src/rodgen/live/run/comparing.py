"""What of a live run compares it with another one, which is kept."""

from __future__ import annotations

from abc import abstractmethod

from rodgen.integrate.live import Live
from rodgen.integrate.samples import Samples
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.ghost import Ghost
from rodgen.live.run.marks import Marks
from rodgen.live.run.page_state import PageState
from rodgen.live.run.plot import Plot
from rodgen.live.samples import Chunk, Store


class Comparing:
    """The part of a LiveRun that keeps runs. keeps: whether a run is kept when another begins;
    ghost: the run that is kept."""

    keeps = False
    ghost: Ghost | None = None
    live: Live
    store: Store
    catalogue: Catalogue
    marks: Marks
    plots: dict[str, Plot]
    page: PageState

    @property
    @abstractmethod
    def seen(self) -> Chunk:
        """What the page looks at."""

    @abstractmethod
    def _begin(self) -> None:
        """Begin anew from where the method is."""

    @abstractmethod
    def _changed(self) -> None:
        """Tell the page that something is other than before."""

    def keep_runs(self, keeps: bool) -> None:
        """Keep a run as a ghost whenever another begins, or let go of the one that is kept."""
        self.keeps = keeps
        self._beside(self.ghost if keeps else None)

    def branch(self) -> None:
        """Begin another run from the state that the page looks at; this one is kept."""
        sample, self.keeps = self.seen, True
        self._keep()
        self.live.go_back(Samples(sample.t, sample.y, sample.work), sample.p, sample.given)
        self._begin()
        self.marks.note(float(sample.t[-1]), "begun from a state of the run before")

    def _keep(self) -> None:
        """Keep the run as it is by now, where runs are kept and it has begun to move."""
        if self.keeps and self.store.count > 1:
            self._beside(Ghost(self.store, self.catalogue))

    def _beside(self, ghost: Ghost | None) -> None:
        self.ghost = ghost
        for plot in self.plots.values():
            self._compared(plot)
        self.page.compared(self.plots)
        self._changed()

    def _compared(self, plot: Plot) -> None:
        """Have a plot show the difference from the ghost, if it shows one."""
        plot.beside = self.ghost
        if plot.spec.kind == "difference":
            self.page.added(plot, self.store.chunks())
