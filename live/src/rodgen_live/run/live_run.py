"""A live run in a thread of its own: it integrates, keeps samples, and sends them to one page."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress

from rodgen.errors import InputError
from rodgen.loading import build_fastest
from rodgen.scene import Scene
from rodgen.scene.integration import IntegrationTable
from rodgen.system import System
from rodgen_live.open_run import FOR_LOOKING, Live, LiveError
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.change_history import ChangeMarks, Undo
from rodgen_live.run.pulling import PulledRun
from rodgen_live.run.run_record import PAUSED, RUNNING, STOPPED
from rodgen_live.run.run_thread import FRAME
from rodgen_live.sample_store import Chunk, SampleStore

SLICE = 0.012  # seconds of a frame, for steps


class LiveRun(PulledRun):
    """A run that goes on by the clock while it is changed.

    Everything but `submit`, `page` and `close` is for the run's own thread: others hand it work by
    `submit`. strict: whether tolerances are kept even where real time is missed. taken: how many
    systems it has run so far; files: the scenes that came from files, by their names, the last one
    last, which a page notes; texts: of scenes that were read from texts; greeted: whether a page
    has shown it.
    """

    def __init__(self, system: System | Scene):
        """Load the module of the system, which should be in the cache, and start the thread."""
        super().__init__()
        self.taken = 0
        self.strict = self.greeted = False
        self.files: dict[str, Scene] | None = None
        self.texts: dict[Scene, str] = {}
        system = System.of(system)
        self.undo = Undo(system.scene)
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

    def do_frame(self) -> None:
        """Take as many steps as are due and fit into a frame."""
        self.critical.tick()
        self._follow_hand()
        if self.status != RUNNING:
            return
        most = self.live.t + 1000 * self.live.every  # samples, where it goes as fast as it can
        to = min(self.pace.target(), most)
        if not self._take_samples(lambda: self.live.advance(to, SLICE)):
            self.shown = self.live.here()  # steps are slow: the picture moves on between samples
            self.page.invalidate_picture()
        now = float(self.shown.t[-1])
        self.pace.record(now)
        over = now >= self.live.system.settings.span[1]
        if self.status == STOPPED:
            return
        if self.goes_round and self.past is None and over:
            whole = self.store
            self.restart()
            self.whole = whole
        elif self.pace.is_too_slow and not self.strict and self.live.rough < len(FOR_LOOKING):
            self.strict = True
            with suppress(InputError):
                self.roughen(True)

    def _take_samples(self, steps: Callable[[], Chunk]) -> int:
        """Take steps and record their samples; returns how many there are. A failure stops it."""
        before, failure = time.thread_time(), ""
        try:
            samples = steps()
        except LiveError as error:
            samples, failure = error.samples, str(error)
        self.pace.add_cost(time.thread_time() - before)
        self._record(samples)
        if failure:
            self.stop(failure)
        return len(samples)

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
        self.store = SampleStore()
        self.marks, self.past, self.whole = ChangeMarks(), None, None
        self.undo.drop_marks()
        if self.status != RUNNING:
            self.status = PAUSED
        self.message = ""
        self.page.resend(self)
        self.shown = live.here()
        self._take_samples(lambda: live.advance(live.system.settings.span[0], 0.0))
        if not self.store.count:  # it begins amid another
            self._record(live.here())
        self._restart_clock()
        self.critical.restart(live.system)
        self.warnings = self.live.warnings()
        self._notify_page()

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

    def branch(self) -> None:
        """Keep this run, and begin another from the state that the page looks at."""
        sample, self.keeps = self.page_sample, True
        self._keep_ghost()
        self.live.go_back(sample)
        self._begin()
        self.marks.note(float(sample.t[-1]), "begun from a state of the run before")

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
        self._take_samples(self.live.one_step)
        self._notify_page()

    def change(self, system: System | Scene, what: str = "") -> None:
        """Apply other values of parameters, method, tolerances; what: in words, for the record."""
        then, moved = self.live.system.settings, self.live.change(system)
        now = self.live.system.settings
        if now != then:
            self._match_samples()
            self.warnings = self.live.warnings()
            self.strict = False
        if moved:
            self._note_change(what)
            self._rebuild_plots()
            self.critical.restart(self.live.system)
        self._clear_stop()

    def roughen(self, on: bool) -> None:
        """Switch to a method and coarser tolerances that keep real time, or back to those of the
        scene, whatever time they take. Raises InputError."""
        self.live.roughen(on)
        self.strict = not on
        used = self.live.settings
        self.warnings = self.live.warnings()
        self._note_change(f"{used.method} at rtol {used.rtol:g}{' for looking' * on}", same=True)
        self._restart_clock()
        self._notify_page()

    def set_speed(self, speed: float) -> None:
        """Set the simulated seconds per second; infinite: as fast as it goes."""
        self.pace.speed = speed
        self._match_samples()
        self._restart_clock()
        self._notify_page()

    def _match_samples(self) -> None:
        every = self._sample_interval(self.live.system.settings)
        if not math.isclose(every, self.live.every):
            self.live.sample_every(every)

    def _sample_interval(self, settings: IntegrationTable) -> float:
        """Interval between samples [s]: the one asked for, or less where frames need it."""
        wanted = settings.output_every
        return min(wanted, self.pace.speed * FRAME) if math.isfinite(self.pace.speed) else wanted
