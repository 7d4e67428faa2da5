"""A live run in a thread of its own: it integrates, keeps samples, and sends them to one page."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.stepper import FAILED, FINISHED, Stats
from rodgen.loading import build_fastest
from rodgen.loading.generated_module import call_module
from rodgen.scene import Scene
from rodgen.scene.integration import IntegrationTable
from rodgen.system import System
from rodgen_live.open_run import Live, LiveError, Samples
from rodgen_live.panel_rows import RunStatus
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.change_marks import ChangeMarks
from rodgen_live.run.critical_search import CriticalSearch
from rodgen_live.run.page_state import PageState
from rodgen_live.run.plot import Plot
from rodgen_live.run.pulling import PullMixin
from rodgen_live.run.run_thread import FRAME, Pace, RunThread
from rodgen_live.run.undo import Undo
from rodgen_live.sample_store import Chunk, RecordedSolution, SampleStore

RUNNING, PAUSED, STOPPED = "running", "paused", "stopped"
SLICE = 0.012  # seconds of a frame, for steps
BEYOND = 1e6  # times the initial state, or 1
MADE = 0.1  # of all energies: a larger imbalance was made by the method


class LiveRun(RunThread, PullMixin):
    """A run, its samples, its marks, its plots, and the page that looks at it.

    Everything but `submit`, `page` and `close` is for the run's own thread: others hand it work by
    `submit`. shown: the present sample; past: the earlier one that the page looks back at, or None.
    strict: whether tolerances are kept even where real time is missed. loops: whether a run begins
    again at the end of its span; goes_round: whether this one does, which a change or a kick ends;
    repeats: whether it is like the one before; whole: samples of that one, if the loop has ended
    it. begun: how many times it has
    begun at a start; taken: how many systems it has run so far; files: the scenes that came from
    files, by their names, the last one last, which a page notes; texts: of scenes that were read
    from texts. told: called in that thread when
    the status, the scene or the plots have changed.
    """

    def __init__(self, system: System | Scene, told: Callable[[], None] = lambda: None):
        """Load the module of the system, which should be in the cache, and start the thread."""
        super().__init__()
        self.told, self.page = told, PageState()
        self.status, self.message = PAUSED, ""
        self.plots: dict[str, Plot] = {}
        self._numbers, self.greeted = itertools.count(1), False  # whether a page has shown it
        self.pace, self.taken, self.begun = Pace(), 0, 0
        self.files: dict[str, Scene] | None = None
        self.texts: dict[Scene, str] = {}
        self.loops = self.goes_round = True
        self.repeats = False
        self.whole: SampleStore | None = None
        self.past: Chunk | None = None
        system = System.of(system)
        self.undo = Undo(system.scene)
        self.strict = False
        self.critical = CriticalSearch(self.submit, self._notify_page)
        self.switch_to(system)
        self.start()

    def close(self) -> None:
        """End the thread, and with it the run."""
        self.critical.cancel()
        super().close()

    # The frames --------------------------------------------------------------------------------

    @property
    def is_busy(self) -> bool:
        """Whether another frame is due."""
        return self.status == RUNNING or self.page.is_due

    @property
    def _is_over(self) -> bool:
        """Whether the span of the scene is over."""
        return bool(self.shown.t[-1] >= self.live.system.settings.span[1])

    @property
    def is_unusable(self) -> bool:
        """Whether the state is of no further use: it has grown too far, or its energy has come from
        nowhere."""
        start, here = np.abs(self.live.system.y0).max(initial=1.0), self.shown
        with np.errstate(all="ignore"):
            energies = call_module(self.model, "energy", here.t[-1], here.y[-1], here.p)
            parts = np.concatenate((energies, -here.work[-1], [-here.given, -here.start]))
            kept = abs(parts.sum()) <= MADE * np.abs(parts).sum()
        return not (kept and np.abs(here.y[-1]).max(initial=0.0) <= BEYOND * start)

    def show(self) -> None:
        """Send the page a message about the run, if one is due."""
        self.page.show(self)

    def report_failure(self, message: str) -> None:
        """Stop the run after a defect, with a message for the page."""
        self._stop(message)

    def do_frame(self) -> None:
        """Take as many steps as are due and fit into a frame."""
        self.critical.tick()
        self._follow_hand()
        if self.status != RUNNING:
            return
        due = self.pace.target()
        most = self.live.t + 1000 * self.live.every  # samples, where it goes as fast as it can
        failure = ""
        before = time.thread_time()
        try:
            samples = self.live.advance(min(due, most), SLICE)
        except LiveError as error:
            samples, failure = error.samples, str(error)
        self.pace.add_cost(time.thread_time() - before)
        self._record(samples)
        if not len(samples.t):  # steps are slow: the picture moves on between samples
            self._sample_now()
            self.page.invalidate_picture()
        self.pace.record(self.shown.t[-1])
        if failure:
            self._stop(failure)
        elif self.goes_round and self.past is None and self._is_over:
            whole = self.store
            self.restart()
            self.whole = whole
        elif self.pace.is_too_slow and not (self.live.is_coarsest or self.strict):
            self._try_roughen()

    def _record(self, samples: Samples) -> None:
        if not len(samples.t):
            return
        chunk = self.store.add(samples)
        self.shown = chunk.last()
        self.page.add_samples(self.plots, chunk)

    def _stop(self, message: str) -> None:
        self.status, self.message = STOPPED, message
        self._notify_page()

    def _notify_page(self) -> None:
        """Tell the page that something other than the picture has changed."""
        self.page.invalidate()
        self.told()

    # What can be asked of it: in its thread ----------------------------------------------------

    def switch_to(self, system: System | Scene) -> None:
        """Run another system, from its start; plots go on as far as it has their quantities."""
        system = System.of(system)
        model = build_fastest(system.structure)
        if self.taken:
            self._keep_ghost()
        every = self._sample_interval(system.settings)
        live, catalogue = Live(system, model, every), Catalogue(system, model)
        self._transfer_plots(catalogue)
        self.model, self.live, self.catalogue = model, live, catalogue
        self.taken += 1
        self.strict, self.critical.mark = False, None
        self.page.reset_texts()
        self._begin()

    def restart(self, system: System | Scene | None = None) -> None:
        """Go back to the initial state, of another system if one is given."""
        self._keep_ghost()
        self.live.restart(system)
        self._begin()

    def _begin(self) -> None:
        live = self.live
        self.begun += 1
        self.repeats, self.goes_round = self.goes_round, self.loops
        self.store = SampleStore(live.states, live.works, live.energy_start)
        self.store.set_parameters(live.p, live.given)
        self.marks, self.past, self.whole = ChangeMarks(), None, None
        self.undo.drop_marks()
        if self.status != RUNNING:
            self.status = PAUSED
        self.message = ""
        self.page.reset_run(self.plots)
        self._take_first_sample()
        self._restart_clock()
        self.critical.restart(live.system)
        self._update_warnings()
        self._notify_page()

    def _take_first_sample(self) -> None:
        """Take the sample at the start."""
        self._sample_now()
        try:
            self._record(self.live.advance(self.live.system.settings.span[0], 0.0))
        except LiveError as error:
            self._record(error.samples)
            self.status, self.message = STOPPED, str(error)
        if not self.store.count:  # it begins amid another
            self._record(self.live.here())

    def _sample_now(self) -> None:
        """Take the present state as the sample to show, after something has changed it."""
        live, (t, y, work) = self.live, self.live.here()
        self.shown = Chunk(t, y, work, live.works, live.p, live.given, live.energy_start)

    def _restart_clock(self) -> None:
        self.pace.start(float(self.shown.t[-1]))

    def _update_warnings(self) -> None:
        """Update the warnings about the step or the tolerance, which have changed."""
        self.warnings = self.live.warnings()

    def resume(self) -> None:
        """Resume a paused run, in the present."""
        self.past = None
        if self.status == PAUSED:
            self.status = RUNNING
            self._restart_clock()
            self._notify_page()

    def loop(self, on: bool) -> None:
        """Begin this run and those after it again at the end of their span, or let them go on."""
        self.loops = self.goes_round = on
        self._notify_page()

    def pause(self) -> None:
        """Pause the run."""
        if self.status == RUNNING:
            self.status = PAUSED
            self._notify_page()

    def one_step(self) -> None:
        """Pause the run and take a single step of the method, in the present."""
        self.past = None
        self.pause()
        if self.status == STOPPED:
            return
        try:
            self._record(self.live.one_step())
        except LiveError as error:
            self._record(error.samples)
            self._stop(str(error))
        self._notify_page()

    def change(self, system: System | Scene, what: str = "") -> None:
        """Apply other values of parameters, method, tolerances; what: in words, for the record."""
        then, moved = self.live.system.settings, self.live.change(system)
        now = self.live.system.settings
        if now.output_every != then.output_every:
            self.live.sample_every(self._sample_interval(now))
        if now != then:
            self._update_warnings()
            self.strict = False
        if moved:
            self._begin_chunk(what)
            self._rebuild_plots()
            self.critical.restart(self.live.system)
        self._clear_stop()

    def roughen(self, on: bool) -> None:
        """Switch to a method and coarser tolerances that keep real time, or back to those of the
        scene, whatever time they take. Raises InputError."""
        self.live.roughen(on)
        self.strict = not on
        used = self.live.settings
        self._update_warnings()
        self._begin_chunk(f"{used.method} at rtol {used.rtol:g}{' for looking' * on}", same=True)
        self._restart_clock()
        self._notify_page()

    def _try_roughen(self) -> None:
        """Switch to coarser tolerances, if there are any."""
        try:
            self.roughen(True)
        except InputError:
            self.strict = True

    def _clear_stop(self) -> None:
        """Turn a stopped run into a paused one after a change, if its state is of use."""
        if self.status == STOPPED and not self.is_unusable:
            self.status, self.message = PAUSED, ""
        self._notify_page()

    def _begin_chunk(self, what: str, same: bool = False) -> None:
        """Begin a new piece of samples; same: of the same motion, which a loop goes on with."""
        self.goes_round &= same
        self.past = None
        if what:
            self.marks.note(self.live.t, what)
        self.store.set_parameters(self.live.p, self.live.given)
        self._sample_now()

    def set_speed(self, speed: float) -> None:
        """Set the simulated seconds per second; infinite: as fast as it goes."""
        self.pace.speed = speed
        every = self._sample_interval(self.live.system.settings)
        if not math.isclose(every, self.live.every):
            self.live.sample_every(every)
        self._restart_clock()
        self._notify_page()

    def _sample_interval(self, settings: IntegrationTable) -> float:
        """Interval between samples [s]: the one asked for, or less where frames need it."""
        wanted = settings.output_every
        return min(wanted, self.pace.speed * FRAME) if math.isfinite(self.pace.speed) else wanted

    # Looking back ------------------------------------------------------------------------------

    @property
    def page_sample(self) -> Chunk:
        """Sample that the page looks at: the present, or one of the past."""
        return self.past or self.shown

    def look_at(self, t: float) -> None:
        """Show the page the sample nearest to a time [s]; the run itself goes on."""
        if self.store.count:
            self.past = self.store.nearest(t)
            self.page.invalidate()

    def step_view(self, by: int) -> None:
        """Show the page the sample `by` samples after the one that it looks at; the last one of all
        is the present."""
        if self.store.count:
            found = self.store.nearest(float(self.page_sample.t[-1]), by)
            self.past = found if found.t[-1] < self.store.span[1] else None
            self.page.invalidate()

    def look_at_present(self) -> None:
        """Show the page the present again."""
        self.past = None
        self.page.invalidate()

    # What is taken away -------------------------------------------------------------------------

    def solution(self) -> RecordedSolution:
        """Solution of all samples that are kept, each with the parameters that it was made with; in
        a loop, of its last whole round."""
        store = self.whole if self.whole and self.goes_round else self.store
        pieces = tuple(store.chunks()) or (self.shown,)
        work = np.concatenate([piece.work for piece in pieces])
        return RecordedSolution(
            system=self.live.system_in_use,
            t=np.concatenate([piece.t for piece in pieces]),
            y=np.concatenate([piece.y for piece in pieces]),
            work={term: work[:, at] for at, term in enumerate(self.live.works)},
            stats=Stats.of(self.live.counts, self.live.seconds),
            status=FAILED if self.status == STOPPED else FINISHED,
            message="; ".join(filter(None, (self.message, *map(str, self.marks.every)))),
            model=self.model,
            pieces=pieces,
        )

    # For the page ------------------------------------------------------------------------------

    def run_status(self) -> RunStatus:
        """State of the run at the sample that the page looks at, for the panel of values."""
        live = self.live
        return RunStatus(
            chunk=self.page_sample,
            counts=live.counts,
            seconds=live.seconds,
            ratio=self.pace.ratio if self.status == RUNNING else None,
            settings=live.settings,
            critical=self.critical.value,
        )
