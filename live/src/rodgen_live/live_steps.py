"""Steps and samples of an open-ended run, from one change to the next."""

from __future__ import annotations

import contextlib
import time
from dataclasses import replace
from types import ModuleType

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.diagnosis import failure_message
from rodgen.integrate.events import EventDetector
from rodgen.integrate.methods.compiled_integrator import CompiledIntegrator
from rodgen.integrate.methods.method_choice import make_integrator
from rodgen.integrate.stepper import Counts, StepError
from rodgen.integrate.stretches import (
    CREEP,
    CREPT,
    STRIDE,
    UNBOUNDED,
    Pulse,
    Stretches,
    evaluation_bounds,
    with_span,
)
from rodgen.scene.integration import IntegrationTable
from rodgen.system import System
from rodgen_live.grid_recorder import GridRecorder
from rodgen_live.sample_store import Chunk

STOPS = (StepError, OverflowError)  # what a method ends with that cannot go on


class Windows:
    """Stretches of an open-ended run: windows as long as the scene's span, one after the other.

    Loads are looked at in one window at a time. origin: where the first begins [s]; span: of the
    present window; stretches: in it.
    """

    def __init__(self, system: System, origin: float):
        start, end = system.settings.span
        self._course, self._fixed = system.time_laws, system.settings.has_fixed_step
        self._origin, self.length = origin, end - start
        # To the bit, lest the first window end beside the span.
        self._first = end if origin == start else origin + self.length
        self._number = -1
        self._move_to(0)

    def next_end(self, t: float) -> float:
        """End of the stretch that begins at a time [s]. Raises StepError at a pole."""
        least = t + 4 * float(np.spacing(abs(t)))  # closer, and loads would be asked beyond it
        number = max(0, int((least - self._origin) // self.length))
        # The division may be a rounding beside the borders.
        number -= number > 0 and self._window_start(number) > least
        number += self._window_start(number + 1) <= least
        if number != self._number:
            try:
                self._move_to(number)
            except InputError as error:  # of masses that jump too often there
                raise StepError(str(error)) from None
        for end in self.stretches.ends:
            if end > least:
                return end
        raise StepError(UNBOUNDED)

    def _window_start(self, number: int) -> float:
        return self._first + (number - 1) * self.length if number else self._origin

    def _move_to(self, number: int) -> None:
        self._number = number
        at, over = self.span = self._window_start(number), self._window_start(number + 1)
        if not (self._course.loads or self._course.expressions):
            self.stretches = Stretches([over])
            return
        across: list[Pulse] = []
        if number and not self._fixed:  # a rest may reach across the border
            half = self.length / 2
            across = replace(self._course, start=at - half, end=at + half).pulses()
        course = replace(self._course, start=at, end=over)
        self.stretches = Stretches.of(course, self._fixed, across)


class SystemSteps:
    """Steps of an open-ended run from (t, y) with one system, whose method is chosen.

    origin: start of the run [s]. Raises InputError for a method that cannot be had; what stops the
    first step is raised with that step.
    """

    def __init__(self, system: System, model: ModuleType, t: float, y: Array, origin: float):
        self.system, settings = system, system.settings
        self.machine = make_integrator(model, system.p, settings, t, y.copy())
        self.compiled = isinstance(self.machine, CompiledIntegrator)
        switches = () if settings.has_fixed_step else system.time_laws.switches()
        self._watch = EventDetector([], model, system.p, switches)
        self._windows = Windows(system, origin)
        self._ended, self._pace = True, 0.0
        self._seen, self._look = t, STRIDE
        with contextlib.suppress(*STOPS):
            self._begin()

    def _begin(self) -> None:
        """Begin the next stretch. Raises StepError."""
        end = self._windows.next_end(self.machine.t)
        self.machine.begin(
            end, *evaluation_bounds(self.machine.t, end), self._windows.stretches.half_period
        )
        self._ended = False

    def step_until(self, tape: GridRecorder, goal: int, until: float) -> None:
        """Take steps until the samples before number ``goal`` are there, or the clock
        (time.perf_counter) is at ``until``. Raises StepError."""
        # Compiled steps end with the last sample that is asked for, and can give more of the last
        # step later; those in Python give all samples of a step at once, or never.
        tape.until = goal if self.compiled else None
        while tape.count < goal:
            # As many as fit, by the time that the last ones took.
            left = until - time.perf_counter()
            fit = int(min(STRIDE, left / self._pace)) if self.compiled and self._pace else 1
            self._take_steps(tape, max(1, fit))
            if time.perf_counter() >= until:
                return

    def one_step(self, tape: GridRecorder) -> None:
        """Take exactly one step, without samples. Raises StepError."""
        tape.until = tape.count
        before = self.machine.counts.nsteps
        while self.machine.counts.nsteps == before:
            self._take_steps(tape, 1)

    def _take_steps(self, tape: GridRecorder, most: int) -> None:
        if self._ended:
            self._begin()
        before, start = self.machine.counts.nsteps, time.perf_counter()
        self._ended = self.machine.advance(tape, self._watch, most)
        steps = self.machine.counts.nsteps
        if steps > before:
            self._pace = (time.perf_counter() - start) / (steps - before)
        if steps >= self._look:
            self._check_progress(steps)

    def _check_progress(self, steps: int) -> None:
        """Raise StepError where thousands of steps lead nowhere."""
        if not self._ended and self.machine.t - self._seen < CREEP * self._windows.length:
            raise StepError(CREPT.format(STRIDE, self._seen))
        self._seen, self._look = self.machine.t, steps + STRIDE

    def failure_message(self, error: ArithmeticError) -> str:
        """Message of what stopped it, why, and what to try, as of a run with an end."""
        scene = with_span(self.system.scene, *self._windows.span)
        return failure_message(error, scene, self.machine, self._windows.stretches.pole)


class LiveError(ArithmeticError):
    """A live run stands still until it is changed or restarted; samples: those that became known
    before."""

    def __init__(self, message: str, samples: Chunk):
        super().__init__(message)
        self.samples = samples


class LiveSteps:
    """An open-ended run with one system after the other: its samples, works and costs.

    works: names of the loads without potential; seconds: computing time since the start; given:
    energy [J] that changes, kicks and pulls have put in since then; energy_start: total energy
    there [J], raised_start: that in gravity.
    """

    given: float
    energy_start: float
    raised_start: float

    def _start(self, course: SystemSteps, every: float, works: tuple[str, ...]) -> None:
        self._course, self._failed, self.works = course, "", works
        self._spent, self.seconds = Counts(), 0.0  # of the courses before
        self._base = np.zeros(len(works))  # works before the course [J]
        # The last sample given out, or the last change if later.
        self._known = self.t, self.y, self._base
        self._tape = GridRecorder(self.t, every, len(self.y), self.works)

    def _take_up(self, course: SystemSteps, work: Array, every: float | None = None) -> None:
        """Go on by another course, with the works up to here; every: other seconds between two
        samples."""
        self._spent += self._course.machine.counts
        self._course, self._base, self._failed = course, work, ""
        self._known = self.t, self.y, work
        taken = self._tape.next_index
        if every is not None:
            self._tape = GridRecorder(self.t, every, len(self.y), self.works)
        if taken:  # else the sample at the start is still to come
            self._tape.skip(self.t)

    @property
    def p(self) -> Array:
        """Parameters of the module."""
        return self._course.system.p

    @property
    def t(self) -> float:
        """Time that the method has reached [s]; the samples given out may end before."""
        return self._course.machine.t

    @property
    def y(self) -> Array:
        """State at t."""
        return self._course.machine.y.copy()

    @property
    def settings(self) -> IntegrationTable:
        """Method, step and tolerances in use."""
        return self._course.system.settings

    @property
    def every(self) -> float:
        """Seconds between two samples."""
        return self._tape.every

    @property
    def counts(self) -> Counts:
        """Steps and evaluations since the start."""
        total = Counts()
        total += self._spent
        total += self._course.machine.counts
        return total

    def here(self) -> Chunk:
        """Sample at which a change or a kick would act now; after one, its result."""
        return self._single_sample(*self._point_of_change())

    def advance(self, to: float, wall: float) -> Chunk:
        """Go on to a time [s] for so many seconds at most, or one step, and return the new samples
        up to that time. Raises LiveError, again and again until something is changed."""
        return self._run_steps(self._tape.count_until(to), wall)

    def one_step(self) -> Chunk:
        """Take one step of the method, and return a sample at its end; those before it that were
        not given out are left out. Raises LiveError."""
        self._run_steps(0, None)
        self._known = self._at_end()
        self._tape.skip(self.t)
        return self._single_sample(*self._known)

    def _run_steps(self, goal: int, wall: float | None) -> Chunk:
        """Take steps for so many seconds, or a single one if None, and return the new samples
        before number ``goal``."""
        start = time.perf_counter()
        if self._failed:
            raise LiveError(self._failed, self._take_samples(0))
        try:
            with np.errstate(all="ignore"):
                if wall is None:
                    self._course.one_step(self._tape)
                else:
                    if self._tape.count == 0 < goal:
                        self._tape.begin(self._course.machine.y)
                    self._course.step_until(self._tape, goal, start + wall)
        except STOPS as error:
            with np.errstate(all="ignore"):
                self._failed = self._course.failure_message(error)
            raise LiveError(self._failed, self._take_samples(goal)) from None
        finally:
            self.seconds += time.perf_counter() - start
        return self._take_samples(goal)

    def _take_samples(self, goal: int) -> Chunk:
        """Take the samples before number ``goal`` that were not given out yet."""
        with np.errstate(all="ignore"):
            self._course.machine.works(self._tape)  # as far as they were put off
            t, y, work = self._tape.take(goal)
            work = self._base + work
        if len(t):
            self._known = float(t[-1]), y[-1].copy(), work[-1].copy()
        return self._chunk(t, y, work)

    def _chunk(self, t: Array, y: Array, work: Array) -> Chunk:
        start = self.energy_start, self.raised_start
        return Chunk(t, y, work, self.works, self.p, self.given, *start)

    def _single_sample(self, t: float, y: Array, work: Array) -> Chunk:
        return self._chunk(np.array([t]), y[None], work[None])

    def _point_of_change(self) -> tuple[float, Array, Array]:
        """Time [s], state and works [J] at which a change acts."""
        ahead = self._tape.time(self._tape.next_index) <= self.t
        return self._known if ahead else self._at_end()

    def _at_end(self) -> tuple[float, Array, Array]:
        """Time [s], state and works [J] at the end of the last step."""
        with np.errstate(all="ignore"):
            return self.t, self.y, self._base + self._course.machine.works(self._tape)
