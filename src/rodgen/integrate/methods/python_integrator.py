"""Integrator in Python, step by step: samples, work and events between the steps."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType
from typing import TypeVar

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.events import EventDetector, SwitchProgress
from rodgen.integrate.jumps import Jumps
from rodgen.integrate.methods.gauss_steps import GaussEqualSteps, GaussStep
from rodgen.integrate.methods.python_steppers import CvodeStep, FixedStep, ScipyStep
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.stability import extra_states_of, largest_stable_step
from rodgen.integrate.stepper import Counts, InitialValueProblem, Interpolant, StepError, Stepper
from rodgen.integrate.stretches import EventStop, State
from rodgen.loading.generated_module import call_module
from rodgen.model.methods import TABLEAUX
from rodgen.model.rod import BOUNDARIES
from rodgen.scene.integration import IntegrationTable

SLICE = 0.03  # seconds
# Gauss-Legendre on [0, 1]: exact to order 8, beyond every interpolant in use.
_GAUSS = np.polynomial.legendre.leggauss(4)
NODES, WEIGHTS = (_GAUSS[0] + 1) / 2, _GAUSS[1] / 2
RECENT = 100  # evaluations that are looked at when a run stops, more than a step tries at once
BUFFER = 256  # steps whose power is evaluated at once

# Those that neither SciPy has nor a tableau gives.
OWN: dict[str, Callable[[InitialValueProblem], Stepper]] = {"gauss": GaussStep, "cvode": CvodeStep}
TURN = 2 * np.pi
Value = TypeVar("Value")


def make_stepper(problem: InitialValueProblem) -> Stepper:
    """Create the stepper of a problem. Raises StepError, and InputError where it is missing."""
    method = problem.settings.method
    if problem.settings.has_fixed_step:
        return FixedStep(problem) if method in TABLEAUX else GaussEqualSteps(problem)
    return OWN.get(method, ScipyStep)(problem)


class PythonIntegrator:
    """Integrator of a run by a stepper in Python (see stretches.Integrator)."""

    def __init__(self, model: ModuleType, p: Array, settings: IntegrationTable, t: float, y: Array):
        self._model, self._p, self._settings = model, p, settings
        self.t, self.y = t, y
        self._switch, self._to, self._longest = SwitchProgress(t, t), t, np.inf
        self._window = (-np.inf, np.inf)
        self._asked: deque[float] = deque(maxlen=RECENT)
        self._stepper: Stepper | None = None
        self._done = Counts()
        self._work, self._jumps = WorkQuadrature(model, p), Jumps(model, p)
        self._last: tuple[float, Array] | None = None

    @property
    def load_times(self) -> list[float]:
        return list(self._asked)

    @property
    def counts(self) -> Counts:
        return self._done if self._stepper is None else self._done + self._stepper.counts

    def rhs(self, t: float, y: Array) -> Array:
        """Rates at a time, which is kept inside the stretch between two break points."""
        low, high = self._window
        at = min(max(t, low), high)
        self._asked.append(at)
        rates: Array = self._model.rhs(at, y, self._p)
        return rates

    def jac(self, t: float, y: Array) -> Array:
        """Jacobian of the rates, at a time that is kept inside the stretch."""
        low, high = self._window
        jacobian: Array = self._model.jac(min(max(t, low), high), y, self._p)
        return jacobian

    @property
    def end(self) -> float:
        return self._switch.goal

    def begin(self, end: float, low: float, high: float, longest: float) -> None:
        jump = self._jumps.begin(self.t, self.y, end, low, high)
        if jump is not None:
            self.y = self.y.copy()
            jump.add_to(self.y, len(self.y))
            self._work.come = self._work.come + jump.work
        self._window, self._longest = (low, high), longest
        self._switch = SwitchProgress(end, self.t)
        self._start_stepper(end)

    def _start_stepper(self, end: float) -> None:
        """Begin steps up to the end of the stretch, or to where a law of the motion switches."""
        self._done, self._stepper = self.counts, None
        self._to, self._last = end, None
        settings, model, longest = self._settings, self._model, self._longest

        def longest_step(t: float, y: Array) -> float:
            stable = largest_stable_step(settings.method, model, t, y, self._p)
            return min(longest, stable or np.inf)

        added, base = len(extra_states_of(model)), 2 * BOUNDARIES[model.BOUNDARY].translates
        start = self.rhs, self.jac, self.t, self.y
        problem = InitialValueProblem(*start, end, settings, longest_step, added)
        # Equal steps have no tolerance that whole turns could loosen, and times of their own.
        if settings.has_fixed_step:
            self._stepper = make_stepper(problem)
        else:
            angles = slice(base, (len(self.y) - added) // 2)
            self._stepper = rebase(make_stepper, problem, angles)

    def advance(self, recorder: Recorder, watch: EventDetector, most: int) -> bool:
        stepper = self._stepper
        assert stepper is not None
        recorder.before_writing = lambda: self._work.flush(recorder)
        until, taken = time.perf_counter() + SLICE, 0
        while taken < most:
            done = stepper.step()
            taken += 1
            if not np.isfinite(stepper.y).all():
                raise StepError("the state stops being finite")
            if watch.events and self._find_events(stepper, recorder, watch):
                stepper = self._stepper  # which begins where the step began
                assert stepper is not None
                continue
            self._record_step(recorder, stepper.t, stepper.y, stepper.interpolant)
            before, self.t, self.y = self.t, stepper.t, stepper.y
            if done and self._to < self.end:
                f, h = self.rhs(self.t, self.y), self.t - before
                further = self._switch.next_goal(watch, self.t, self.y, f, h)
                if further == self.t:
                    self._switch.arrive(self.t)
                    further = self.end
                self._start_stepper(min(further, self.end))
                return False
            if done or time.perf_counter() > until:
                return done
        return False

    def _record_step(
        self, recorder: Recorder, t1: float, y1: Array, interpolant: Callable[[], Interpolant]
    ) -> None:
        """Record the samples and the work of a step to t1 that ends in y1."""
        states, at = recorder.states, None
        t0 = self.t
        while True:
            times, rows = recorder.free_rows()
            count = int(np.searchsorted(times, t1, side="right"))
            inside = times[:count]
            # A sample at the very end of the step is its state, not an interpolation.
            ends_here = count > 0 and inside[-1] == t1
            between = inside[:-1] if ends_here else inside
            if len(between) or (self._work.terms and t0 < t1):
                at = at or interpolant()
            if len(between):
                assert at is not None
                rows[: len(between), :states] = at(between)
            jump = self._jumps.at_end(t1, y1) if ends_here else None
            if ends_here:
                rows[count - 1, :states] = y1
                if jump is not None:
                    jump.add_to(rows[count - 1], states)
            whole = count < len(times) or not len(times)
            stop = t1 if whole or ends_here else float(inside[-1])
            if at is not None and self._work.terms and t0 < stop:
                here = self._work.none if jump is None else jump.work
                self._work.add(t0, inside, stop, at, recorder.count, here)
            t0 = stop
            recorder.commit(count)
            if whole or ends_here:
                break
        if len(self._work.waiting) > BUFFER:
            self._work.flush(recorder)

    def _find_events(self, stepper: Stepper, recorder: Recorder, watch: EventDetector) -> bool:
        """Record events inside the step that was just taken; True if it is given up, since a law of
        the motion switches in it, for steps that end there."""
        t1, y1 = stepper.t, stepper.y
        f0 = self._last[1] if self._last else self.rhs(self.t, self.y)
        f1 = self.rhs(t1, y1)
        block = np.array([self.t, t1]), np.stack((self.y, y1)), np.stack((f0, f1))
        found = self._switch.find_crossings(watch, *block)
        at = stepper.interpolant() if found else None
        switching = [(n, span) for _, n, span in found if watch.is_switch(n)]
        if at and switching and (first := watch.first_switch(switching, self.t, at)):
            when, sides = first
            if when < t1:
                self._switch.head_for(sides)
                self._start_stepper(when)
                return True
        self._last = t1, f1
        found = [crossing for crossing in found if not watch.is_switch(crossing[1])]
        if not (at and found):
            return False
        for when, number in watch.locate_all([crossing[1:] for crossing in found], at):
            y = at(np.array([when]))[0]
            if watch.record_event(number, when, y):
                self._record_step(recorder, when, y, stepper.interpolant)
                self.t, self.y = when, y
                recorder.before_writing()
                recorder.end_at(when, np.concatenate((y, self._work.totals)))
                raise EventStop(number, when)
        return False

    def works(self, recorder: Recorder) -> Array:
        self._work.flush(recorder)
        totals = self._work.totals.copy()
        jump = self._jumps.at_end(self.t, self.y)
        return totals + self._work.come + (0.0 if jump is None else jump.work)

    def state(self) -> State:
        """Raise ValueError: only compiled methods can be put down."""
        raise ValueError("only compiled methods can be put down and taken up again")

    def restore(self, state: State) -> None:
        raise ValueError("only compiled methods can be put down and taken up again")


class WorkQuadrature:
    """Work of every load without potential, by quadrature over each step; waiting: stretches whose
    power is not integrated yet."""

    def __init__(self, model: ModuleType, p: Array):
        self._model, self._p = model, p
        self.terms = loads_at_work(model)
        self.totals = np.zeros(len(self.terms))
        self.waiting: list[tuple[Array, Array, Array, list[int], Array, Array]] = []
        self.none = np.zeros(len(self.terms))
        self.come = self.none  # work [J] of what has jumped since the last stretch

    def add(
        self, t0: float, inside: Array, t1: float, at: Interpolant, sample: int, here: Array
    ) -> None:
        """Add a stretch from t0 to t1 with samples at the times inside, the first of them number
        ``sample``; here: works [J] at the last of them of what jumps there."""
        ends_here = len(inside) > 0 and inside[-1] == t1
        edges = np.concatenate(([t0], inside, [] if ends_here else [t1]))
        widths = np.diff(edges)
        nodes = (edges[:-1, None] + widths[:, None] * NODES).ravel()
        # Which sample each stretch ends at; the last stretch may end at none.
        samples = [*range(sample, sample + len(inside)), *([] if ends_here else [-1])]
        self.waiting.append((nodes, at(nodes), widths, samples, self.come, here))
        self.come = self.none

    def flush(self, recorder: Recorder) -> None:
        """Integrate the power over the steps that wait, and write it into their samples."""
        if not self.waiting or not self.terms:
            return
        nodes, states, widths, samples, come, here = zip(*self.waiting, strict=True)
        at_nodes = np.concatenate(nodes), np.concatenate(states), self._p
        power = call_module(self._model, "power", at_nodes[0], *at_nodes)
        width = np.concatenate(widths)
        ends = np.array([sample for some in samples for sample in some])
        last = np.cumsum([len(some) for some in widths]) - 1
        first = np.concatenate(([0], last[:-1] + 1))
        totals, begun, ended = self.totals.copy(), np.array(come), np.array(here)
        for at, values in enumerate(power.values()):
            stretches = width * (values.reshape(-1, len(NODES)) @ WEIGHTS)
            stretches[first] += begun[:, at]
            sums = totals[at] + np.cumsum(stretches)
            totals[at] = sums[-1]
            sums[last] += ended[:, at]
            for sample, total in zip(ends, sums, strict=True):
                if sample >= 0:
                    recorder.row(sample)[recorder.states + at] = total
        # Only now: an interrupt before this line has the same steps integrated again.
        self.totals, self.waiting = totals, []


def rebase(
    make: Callable[[InitialValueProblem], Stepper], problem: InitialValueProblem, angles: slice
) -> Stepper:
    """Make a stepper on time since its stretch began, and on angles less their whole turns; angles:
    which of the states are.

    A rod that has turned a million times bends as before, but a relative tolerance of its angles
    would allow a million times the error. Far from zero the times of steps are rounded, and methods
    that add up the unrounded steps would integrate another motion.
    """
    y = problem.y
    turns = np.zeros(len(y))
    turns[angles] = TURN * np.trunc(y[angles] / TURN)
    if not np.isfinite(turns).all():
        turns[:] = 0.0
    if problem.t == 0 and not turns.any():
        return make(problem)
    return _RebasedStepper(make, problem, turns)


class _RebasedStepper:
    """Stepper on y less the turns, from time zero (see stepper.Stepper)."""

    def __init__(
        self,
        make: Callable[[InitialValueProblem], Stepper],
        problem: InitialValueProblem,
        turns: Array,
    ):
        self._turns, self._start, self._end = turns, problem.t, problem.end
        self._inner = make(
            replace(
                problem,
                rhs=self._shift(problem.rhs),
                jac=self._shift(problem.jac),
                longest=self._shift(problem.longest),
                t=0.0,
                y=problem.y - turns,
                end=problem.end - problem.t,
            )
        )
        self.t, self.y = problem.t, problem.y

    def _shift(self, function: Callable[[float, Array], Value]) -> Callable[[float, Array], Value]:
        return lambda past, state: function(self._start + past, state + self._turns)

    @property
    def counts(self) -> Counts:
        """Steps and evaluations so far."""
        return self._inner.counts

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        done = self._inner.step()
        self.t = self._end if done else self._start + self._inner.t
        self.y = self._inner.y + self._turns
        return done

    def interpolant(self) -> Interpolant:
        """Dense output of the last step: a function from times inside it to states (T, states)."""
        inside = self._inner.interpolant()
        return lambda times: inside(times - self._start) + self._turns
