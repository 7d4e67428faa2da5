"""Record of a run in its thread: samples, marks and plots so far, and the page that looks at it."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import FAILED, FINISHED, Stats
from rodgen_live.panel_rows import RunStatus
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.change_history import Undo
from rodgen_live.run.critical_search import CriticalSearch
from rodgen_live.run.ghost import Ghost
from rodgen_live.run.page_state import PageState, ShownRun
from rodgen_live.run.plot import Plot
from rodgen_live.run.plot_spec import PlotSpec, missing_labels, transfer
from rodgen_live.run.run_thread import Pace, RunThread
from rodgen_live.sample_store import Chunk, SampleStore, changes_between

RUNNING, PAUSED, STOPPED = "running", "paused", "stopped"
BEYOND = 1e6  # times the initial state, or 1
MADE = 0.1  # of all energies: a larger imbalance was made by the method

MOST_PLOTS = 24
Chosen = tuple[PlotSpec, Catalogue]  # a plot, and of which rod it is


class RunRecord(RunThread, ShownRun):
    """Record of a run. loops: whether a run begins again at the end of its span; goes_round:
    whether this one does, which a change or a kick ends; whole: samples of the round before, if the
    loop has ended it. told: called in the thread when the status, the scene or the plots have
    changed."""

    catalogue: Catalogue
    undo: Undo
    unplotted: tuple[str, ...] = ()  # what plots showed and the rod that came last does not have

    def __init__(self) -> None:
        super().__init__()
        self.told: Callable[[], None] = lambda: None
        self.page = PageState()
        self.status, self.message = PAUSED, ""
        self.plots = {}
        self._numbers = itertools.count(1)  # of plots to come
        self._left: list[Chosen] = []  # plots of which the rod that came last has nothing
        self._whole: dict[str, Chosen] = {}  # and those of which it has a part
        self.pace = Pace()
        self.loops = self.goes_round = True
        self.whole: SampleStore | None = None
        self.critical = CriticalSearch(self.submit, self._notify_page)

    def show(self) -> None:
        """Send the page a message about the run, if one is due."""
        self.page.show(self)

    @property
    def is_unusable(self) -> bool:
        """Whether the state is of no further use: it has grown too far, or its energy has come from
        nowhere."""
        start, here = np.abs(self.live.system.y0).max(initial=1.0), self.shown
        energies = self.live.energies(float(here.t[-1]), here.y[-1], here.p)
        parts = np.array([*energies, *-here.work[-1], -here.given, -here.start])
        with np.errstate(all="ignore"):
            kept = abs(parts.sum()) <= MADE * np.abs(parts).sum()
        return not (kept and np.abs(here.y[-1]).max(initial=0.0) <= BEYOND * start)

    def _record(self, chunk: Chunk) -> None:
        if len(chunk):
            self.store.add(chunk)
            self.shown = chunk.last()
            self.page.add_samples(self, chunk)

    def stop(self, message: str) -> None:
        """Stop the run, with a message for the page."""
        self.status, self.message = STOPPED, message
        self._notify_page()

    def _notify_page(self) -> None:
        """Tell the page that something other than the picture has changed."""
        self.page.invalidate()
        self.told()

    def _restart_clock(self) -> None:
        self.pace.start(float(self.shown.t[-1]))

    def _clear_stop(self) -> None:
        """Turn a stopped run into a paused one after a change, if its state is of use."""
        if self.status == STOPPED and not self.is_unusable:
            self.status, self.message = PAUSED, ""
        self._notify_page()

    def _note_change(self, what: str, same: bool = False) -> None:
        """Show what a change has made; same: of the same motion, which a loop goes on with."""
        self.goes_round &= same
        self.past = None
        if what:
            self.marks.note(self.live.t, what)
        self.shown = self.live.here()

    # Looking back ------------------------------------------------------------------------------

    def look_at(self, t: float | None) -> None:
        """Show the page the sample nearest to a time [s], or the present if None; the run itself
        goes on."""
        self.past = None if t is None else self.store.nearest(t)
        self.page.invalidate()

    def step_view(self, by: int) -> None:
        """Show the page the sample `by` samples after the one that it looks at; the last one of all
        is the present."""
        found = self.store.nearest(float(self.page_sample.t[-1]), by)
        self.past = found if found.t[-1] < self.store.span[1] else None
        self.page.invalidate()

    # Plots, and the run to compare with --------------------------------------------------------

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
        self._left, self._whole = left[:MOST_PLOTS], whole
        self.page.resend_ghosts(self.plots)

    def _rebuild_plots(self) -> None:
        """Rebuild the plots if other energies are zero than before."""
        if self.catalogue.update_zero_energies(self.live.t, self.live.p):
            self._transfer_plots(self.catalogue)
            self.page.resend(self)

    def wrap_plot(self, name: str, wrapped: bool) -> None:
        """Show the angles of this plot, if it is there, without their whole turns, or as they
        are."""
        if name in self.plots:
            plot = self.plots[name]
            plot.spec = plot.spec.model_copy(update={"wrapped": wrapped})
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
        self._notify_page()

    def keep_runs(self, keeps: bool) -> None:
        """Keep a run as a ghost whenever another begins, or drop the one that is kept."""
        self.keeps = keeps
        self._set_ghost(self.ghost if keeps else None)

    def _keep_ghost(self) -> None:
        """Keep the run as it is by now, if runs are kept and it has begun to move."""
        if self.keeps and self.store.count > 1:
            self._set_ghost(Ghost(self.store, self.catalogue))

    def _set_ghost(self, ghost: Ghost | None) -> None:
        self.ghost = ghost
        for plot in self.plots.values():
            plot.beside = ghost
            if plot.spec.kind == "difference":
                self.page.add_plot(plot, self.store.chunks())
        self.page.resend_ghosts(self.plots)
        self._notify_page()

    # What others take -------------------------------------------------------------------------

    def solution(self) -> Solution:
        """Solution of all samples that are kept, each with the parameters that it was made with; in
        a loop, of its last whole round."""
        store = self.whole if self.whole and self.goes_round else self.store
        pieces = list(store.chunks())
        work = np.concatenate([piece.work for piece in pieces])
        return Solution(
            system=self.live.system_in_use,
            t=np.concatenate([piece.t for piece in pieces]),
            y=np.concatenate([piece.y for piece in pieces]),
            work={term: work[:, at] for at, term in enumerate(self.live.works)},
            stats=Stats.of(self.live.counts, self.live.seconds),
            status=FAILED if self.status == STOPPED else FINISHED,
            message="; ".join(filter(None, (self.message, *map(str, self.marks.every)))),
            model=self.model,
            changes=changes_between(pieces),
        )

    def run_status(self) -> RunStatus:
        """State of the run at the sample that the page looks at, for the panel of values."""
        live = self.live
        return RunStatus(
            scene=live.system_with_support.scene,
            model=self.model,
            chunk=self.page_sample,
            counts=live.counts,
            seconds=live.seconds,
            ratio=self.pace.ratio if self.status == RUNNING else None,
            settings=live.settings,
            critical=self.critical.found,
        )
