"""Comparison of a live run with another one, which is kept."""

from __future__ import annotations

from abc import abstractmethod

from rodgen_live.grid_recorder import Samples
from rodgen_live.open_run import Live
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.change_marks import ChangeMarks
from rodgen_live.run.ghost import Ghost
from rodgen_live.run.page_state import PageState
from rodgen_live.run.plot import Plot
from rodgen_live.sample_store import Chunk, SampleStore


class ComparisonMixin:
    """The part of a LiveRun that keeps runs to compare with. keeps: whether a run is kept when
    another begins; ghost: the run that is kept."""

    keeps = False
    ghost: Ghost | None = None
    live: Live
    store: SampleStore
    catalogue: Catalogue
    marks: ChangeMarks
    plots: dict[str, Plot]
    page: PageState

    @property
    @abstractmethod
    def page_sample(self) -> Chunk:
        """Sample that the page looks at."""

    @abstractmethod
    def _begin(self) -> None:
        """Begin a run from the present state of the method."""

    @abstractmethod
    def _notify_page(self) -> None:
        """Tell the page that something has changed."""

    def keep_runs(self, keeps: bool) -> None:
        """Keep a run as a ghost whenever another begins, or drop the one that is kept."""
        self.keeps = keeps
        self._set_ghost(self.ghost if keeps else None)

    def branch(self) -> None:
        """Keep this run, and begin another from the state that the page looks at."""
        sample, self.keeps = self.page_sample, True
        self._keep_ghost()
        self.live.go_back(Samples(sample.t, sample.y, sample.work), sample.p, sample.given)
        self._begin()
        self.marks.note(float(sample.t[-1]), "begun from a state of the run before")

    def _keep_ghost(self) -> None:
        """Keep the run as it is by now, if runs are kept and it has begun to move."""
        if self.keeps and self.store.count > 1:
            self._set_ghost(Ghost(self.store, self.catalogue))

    def _set_ghost(self, ghost: Ghost | None) -> None:
        self.ghost = ghost
        for plot in self.plots.values():
            self._compare_plot(plot)
        self.page.resend_ghosts(self.plots)
        self._notify_page()

    def _compare_plot(self, plot: Plot) -> None:
        """Give a plot the ghost, and compute its rows anew if it shows the difference."""
        plot.beside = self.ghost
        if plot.spec.kind == "difference":
            self.page.add_plot(plot, self.store.chunks())
