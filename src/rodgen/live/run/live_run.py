"""A live run in a thread of its own: it steps, keeps what came out, and tells one page of it."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.endings import FAILED, FINISHED
from rodgen.integrate.live import Live, LiveError, Samples
from rodgen.integrate.stepper import Stats
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.critical import Critical
from rodgen.live.run.marks import Marks
from rodgen.live.run.page_state import PageState
from rodgen.live.run.plot import Plot
from rodgen.live.run.pulling import Pulling
from rodgen.live.run.undo import Undo
from rodgen.live.run.worker import FRAME, Pace, Worker
from rodgen.live.samples import Chunk, Recorded, Store
from rodgen.live.texts import Present
from rodgen.loading import build_fastest
from rodgen.loading.module import asked
from rodgen.scene import Scene
from rodgen.scene.integration import Integrate
from rodgen.system import System

RUNNING, PAUSED, STOPPED = "running", "paused", "stopped"
SLICE = 0.012  # seconds of a frame, for steps
BEYOND = 1e6  # times the initial state, or 1
MADE = 0.1  # of all energies, from which on what a balance lacks was made by the method


class LiveRun(Worker, Pulling):
    """A run, its samples, its marks, its plots, and the page that looks at it.

    Everything but `do`, `page` and `close` is for the run's own thread: others hand it work by
    `do`. shown: the present; past: the sample that the page looks back at, if it does. strict:
    whether tolerances are kept to where real time is missed. begun: how often it has begun at a
    start; taken: how many scenes it has taken up so far; files: the scenes that came from files, by
    their names, the last one last, which a page notes. told: called in that thread when the status,
    the scene or the plots have changed.
    """

    def __init__(self, system: System | Scene, told: Callable[[], None] = lambda: None):
        """The module of the system should be in the cache already: it is loaded here."""
        super().__init__()
        self.told, self.page = told, PageState()
        self.status, self.message = PAUSED, ""
        self.plots: dict[str, Plot] = {}
        self._numbers, self.greeted = itertools.count(1), False  # whether a page has shown it
        self.pace, self.taken, self.begun = Pace(), 0, 0
        self.files: dict[str, Scene] | None = None
        self.goes_round = False
        self.past: Chunk | None = None
        system = System.of(system)
        self.undo = Undo(system.scene)
        self.strict = False
        self.critical = Critical(self.do, self.page.touched)
        self.take(system)
        self.start()

    def close(self) -> None:
        """End the thread, and with it the run."""
        self.critical.cancel()
        super().close()

    # The frames --------------------------------------------------------------------------------

    @property
    def busy(self) -> bool:
        """Whether another frame is due."""
        return self.status == RUNNING or self.page.waits

    @property
    def _ended(self) -> bool:
        """Whether the span of the scene is over."""
        return bool(self.shown.t[-1] >= self.live.system.settings.span[1])

    @property
    def lost(self) -> bool:
        """Whether no other value leads on from the state: it has grown too far, or its energy has
        come from nowhere."""
        start, here = np.abs(self.live.system.y0).max(initial=1.0), self.shown
        with np.errstate(all="ignore"):
            energies = asked(self.model, "energy", here.t[-1], here.y[-1], here.p)
            parts = np.concatenate((energies, -here.work[-1], [-here.given, -here.start]))
            kept = abs(parts.sum()) <= MADE * np.abs(parts).sum()
        return not (kept and np.abs(here.y[-1]).max(initial=0.0) <= BEYOND * start)

    def show(self) -> None:
        """Send the page what there is to see of the run."""
        self.page.show(self)

    def failed(self, message: str) -> None:
        """A defect stops the run, and the page says so."""
        self._stop(message)

    def slice(self) -> None:
        """Take as many steps as are due and fit into a frame."""
        self.critical.tick()
        self._follow_hand()
        if self.status != RUNNING:
            return
        due = self.pace.due()
        most = self.live.t + 1000 * self.live.every  # samples, where it goes as fast as it can
        failure = ""
        before = time.thread_time()
        try:
            samples = self.live.advance(min(due, most), SLICE)
        except LiveError as error:
            samples, failure = error.samples, str(error)
        self.pace.spend(time.thread_time() - before)
        self._took(samples)
        if not len(samples.t):  # steps are slow: the picture moves on between samples
            self._look()
            self.page.moved()
        self.pace.reached(self.shown.t[-1])
        if failure:
            self._stop(failure)
        elif self.goes_round and self.past is None and self._ended:
            self.restart()
        elif self.pace.missed and not (self.live.coarsest or self.strict):
            self._roughen()

    def _took(self, samples: Samples) -> None:
        if not len(samples.t):
            return
        chunk = self.store.add(samples)
        self.shown = chunk.last()
        self.page.fed(self.plots, chunk)

    def _stop(self, message: str) -> None:
        self.status, self.message = STOPPED, message
        self._changed()

    def _changed(self) -> None:
        """Tell the page that something beside the picture is other than before."""
        self.page.touched()
        self.told()

    # What can be asked of it: in its thread ----------------------------------------------------

    def take(self, system: System | Scene) -> None:
        """Run another system, from its start; plots go on as far as it has their quantities."""
        system = System.of(system)
        model = build_fastest(system.structure)
        if self.taken:
            self._keep()
        every = self._every(system.settings)
        live, catalogue = Live(system, model, every), Catalogue(system, model)
        self._transfer_plots(catalogue)
        self.model, self.live, self.catalogue = model, live, catalogue
        self.taken += 1
        self.strict = False
        self.page.structure_changed()
        self._begin()

    def restart(self, system: System | Scene | None = None) -> None:
        """Go back to the initial state."""
        self._keep()
        self.live.restart(system)
        self._begin()

    def begin_at(self, sample: Samples, given: float, start: float) -> None:
        """Begin with one sample of another run, at which so much energy [J] was given, and which
        had so much at its start."""
        self.live.go_back(sample, self.live.p, given)
        self.live.energy_start, self.greeted = start, True
        self._begin()

    def _begin(self) -> None:
        live = self.live
        self.begun += 1
        self.store = Store(live.states, live.works, live.energy_start)
        self.store.change(live.p, live.given)
        self.marks, self.past = Marks(), None
        self.undo.begin()
        if self.status != RUNNING:
            self.status = PAUSED
        self.message = ""
        self.page.restarted(self.plots)
        self._first()
        self._resume()
        self.critical.look(live.system)
        self._warned()
        self._changed()

    def _first(self) -> None:
        """Take the sample at the start."""
        self._look()
        try:
            self._took(self.live.advance(self.live.system.settings.span[0], 0.0))
        except LiveError as error:
            self._took(error.samples)
            self.status, self.message = STOPPED, str(error)
        if not self.store.count:  # it begins amid another
            self._took(self.live.here())

    def _look(self) -> None:
        """Show the state as it is now, after something has changed it."""
        live, (t, y, work) = self.live, self.live.here()
        self.shown = Chunk(t, y, work, live.works, live.p, live.given, live.energy_start)

    def _resume(self) -> None:
        self.pace.start(float(self.shown.t[-1]))

    def _warned(self) -> None:
        """Look at what is wrong with the step or the tolerance, which have changed."""
        self.warnings = self.live.warnings()

    def go(self) -> None:
        """Let a run that is paused go on, in the present."""
        self.past = None
        if self.status == PAUSED:
            self.status = RUNNING
            self._resume()
            self._changed()

    def go_round(self) -> None:
        """Let a run go over the span of its scene, and over again, until somebody pauses or changes
        it."""
        self.goes_round = True
        self.go()

    def pause(self) -> None:
        """Pause the run."""
        self.goes_round = False
        if self.status == RUNNING:
            self.status = PAUSED
            self._changed()

    def one_step(self) -> None:
        """Pause the run and take a single step of the method, in the present."""
        self.past = None
        self.pause()
        if self.status == STOPPED:
            return
        try:
            self._took(self.live.one_step())
        except LiveError as error:
            self._took(error.samples)
            self._stop(str(error))
        self._changed()

    def change(self, system: System | Scene, what: str = "") -> None:
        """Take other values of parameters, method, tolerances; what: in words, for the record."""
        then, moved = self.live.system.settings, self.live.change(system)
        now = self.live.system.settings
        if now.output_every != then.output_every:
            self.live.sample_every(self._every(now))
        if now != then:
            self._warned()
            self.strict = False
        if moved:
            self._changed_motion(what)
            self._renew_plots()
            self.critical.look(self.live.system)
        self._mended()

    def roughen(self, on: bool) -> None:
        """Go on by a method and coarser tolerances for looking, or by those of the scene, whatever
        time that takes. Raises InputError."""
        self.live.roughen(on)
        self.strict = not on
        used = self.live.settings
        self._warned()
        self._changed_motion(f"{used.method} at rtol {used.rtol:g}{' for looking' * on}")
        self._resume()
        self._changed()

    def _roughen(self) -> None:
        """Take a tolerance for looking, where that can be had; a loop goes on."""
        around = self.goes_round
        try:
            self.roughen(True)
        except InputError:
            self.strict = True
        self.goes_round = around

    def _mended(self) -> None:
        """After a change, let a run that was stopped go on, if its state is of use."""
        if self.status == STOPPED and not self.lost:
            self.status, self.message = PAUSED, ""
        self._changed()

    def _changed_motion(self, what: str) -> None:
        """Keep apart the samples from here on: the rod moves otherwise."""
        self.goes_round = False
        self.past = None
        if what:
            self.marks.note(self.live.t, what)
        self.store.change(self.live.p, self.live.given)
        self._look()

    def set_speed(self, speed: float) -> None:
        """Set the simulated seconds per second; infinite: as fast as it goes."""
        self.pace.speed = speed
        every = self._every(self.live.system.settings)
        if not math.isclose(every, self.live.every):
            self.live.sample_every(every)
        self._resume()
        self._changed()

    def _every(self, settings: Integrate) -> float:
        """Seconds between samples: those asked for, or less where frames need it."""
        wanted = settings.output_every
        return min(wanted, self.pace.speed * FRAME) if math.isfinite(self.pace.speed) else wanted

    # Looking back ------------------------------------------------------------------------------

    @property
    def seen(self) -> Chunk:
        """What the page looks at: the present, or a sample of the past."""
        return self.past or self.shown

    def look_at(self, t: float) -> None:
        """Show the page the sample nearest to a time [s]; the run itself goes on."""
        if self.store.count:
            self.past = self.store.near(t)
            self.page.touched()

    def look_on(self, by: int) -> None:
        """Show the page the sample so many after the one that it looks at; the last one of all is
        the present."""
        if self.store.count:
            found = self.store.near(float(self.seen.t[-1]), by)
            self.past = found if found.t[-1] < self.store.span[1] else None
            self.page.touched()

    def look_up(self) -> None:
        """Show the page the present again."""
        self.past = None
        self.page.touched()

    # What is taken away -------------------------------------------------------------------------

    def solution(self) -> Recorded:
        """All samples that are kept, each with the parameters that it was made with."""
        pieces = tuple(self.store.chunks()) or (self.shown,)
        work = np.concatenate([piece.work for piece in pieces])
        return Recorded(
            system=self.live.integrated,
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

    def present(self) -> Present:
        """What the page looks at, for the panel of values."""
        live = self.live
        return Present(
            chunk=self.seen,
            counts=live.counts,
            seconds=live.seconds,
            ratio=self.pace.ratio if self.status == RUNNING else None,
            settings=live.settings,
            critical=self.critical.value,
        )
