"""Integrator in C: steps compiled with the module, which seldom come back to Python."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.emit.targets import target_of
from rodgen.integrate.events import Bracket, EventDetector, Found, SwitchProgress
from rodgen.integrate.jumps import Jumps
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.stepper import Counts, StepError
from rodgen.integrate.stretches import EventStop, State
from rodgen.model.methods import COMPILED, EITHER
from rodgen.native.native_run import IMPLICIT
from rodgen.scene.integration import AUTO, IntegrationTable

SLICE = 0.03  # seconds between two looks at the clock and at Ctrl-C
FIRST, MOST = 8, 10**7  # steps in a slice: at first, and at most
TRIED = 4.0  # steps ahead in which the failure of a run is looked for
SHORT, BLOCK = 8, 256  # steps between two looks for events, at least and at most

FAILURES = {
    -1: "the rates stop being finite",
    -2: "the step becomes too small to move on",
    -3: "Newton's method finds no solution, however small the step",
}


def initial_parts(settings: IntegrationTable, target: str | None) -> tuple[str, ...]:
    """Parts of a module that a run begins with; others are added when it asks for them. target:
    None for C where it can be built."""
    if settings.method == AUTO or (target and not target_of(target).compiled):
        return ("rhs", "power")
    if settings.method in IMPLICIT:
        return ("flow", "newton", "power")
    return ("flow", "power") if settings.method in COMPILED else ("rhs", "power")


def compiled_name(method: str, equal: bool) -> str:
    """Name that a method has in C; equal: its steps are."""
    return f"{method}_equal_steps" if equal and method in EITHER else method


def next_quota(quota: int, took: float) -> int:
    """Number of steps that fill a slice, where so many took a time [s]."""
    change = min(4.0, max(0.25, SLICE / max(took, 1e-9)))
    return int(min(MOST, max(1, quota * change)))


class CompiledIntegrator:
    """Integrator of a run by a method of the C module (see stretches.Integrator)."""

    def __init__(self, model: ModuleType, p: Array, settings: IntegrationTable, t: float, y: Array):
        self._model = model
        step = settings.step if settings.has_fixed_step else 0.0
        method = compiled_name(settings.method, settings.has_fixed_step)
        self._run = model.Run(method, t, y, p, step, *settings.step_tolerances)
        self._numbers = self._run.numbers
        self._states, self._quota, self._block = len(y), FIRST, BLOCK
        self._stretch, self._switch = (-np.inf, np.inf, np.inf), SwitchProgress()
        self._jumps = Jumps(model, p)

    @property
    def t(self) -> float:
        return float(self._numbers.t)

    @property
    def y(self) -> Array:
        state: Array = self._run.state[: self._states]
        return state

    @property
    def end(self) -> float:
        return self._switch.goal

    @property
    def load_times(self) -> list[float]:
        n = self._numbers
        low, high = max(n.t, n.low), min(n.end, n.high)
        # A step that fails is made shorter each time: times on all scales, those of the first too.
        ahead = n.t + (high - n.t) * 2.0 ** -np.arange(0.0, 60.0, 0.5)
        tried = ahead[ahead - n.t <= max(TRIED * n.step, TRIED * (n.t - n.before))]
        return [low, *(float(at) for at in tried)]

    @property
    def counts(self) -> Counts:
        n = self._numbers
        return Counts(n.steps, n.rejected, n.rhs, n.jacobian, n.factorisations)

    def begin(self, end: float, low: float, high: float, longest: float) -> None:
        jump = self._jumps.begin(self.t, self.y, end, low, high)
        if jump is not None:
            jump.add_to(self._run.state, self._states)
        self._stretch = low, high, longest
        self._switch = SwitchProgress(end, self.t)
        self._check_status(self._run.begin(end, low, high, longest))

    def advance(self, recorder: Recorder, watch: EventDetector, most: int) -> bool:
        if watch.events:
            return self._advance_with_events(recorder, watch, most)
        times, rows = recorder.free_rows()
        start = time.perf_counter()
        status, sampled = self._run.advance(min(self._quota, most), times, rows)
        took = time.perf_counter() - start
        self._commit(recorder, times[:sampled], rows)
        self._adapt(status, took)
        return self._check_status(status)

    def works(self, recorder: Recorder) -> Array:
        work: Array = self._run.state[self._states :].copy()
        jump = self._jumps.at_end(self.t, self.y)
        return work if jump is None else work + jump.work

    def _commit(self, recorder: Recorder, times: Array, rows: Array) -> None:
        """Commit the samples at these times, the one at the end of the stretch with what jumps
        there."""
        jump = self._jumps.at_end(float(times[-1]), self.y) if len(times) else None
        if jump is not None:
            jump.add_to(rows[len(times) - 1], self._states)
        recorder.commit(len(times))

    def _adapt(self, status: int, took: float) -> None:
        """Adapt the steps that are taken at a time to the length of a slice."""
        if status == self._model.PAUSED:
            self._quota = next_quota(self._quota, took)

    def _check_status(self, status: int) -> bool:
        """Return whether the end is reached. Raises StepError for what went wrong."""
        if status in FAILURES:
            raise StepError(FAILURES[status])
        if status != int(self._model.REACHED):
            return False
        if self._numbers.end == self._switch.goal:
            return True
        self._switch.arrive(self.t)
        return self._check_status(self._run.begin(self._switch.goal, *self._stretch))

    # Events -----------------------------------------------------------------------------------

    def _advance_with_events(self, recorder: Recorder, watch: EventDetector, most: int) -> bool:
        """Take some steps, then look back at their ends; where something crosses, the step is taken
        again from the same bytes, for its dense output."""
        before = self._run.memory.copy()
        times, rows = recorder.free_rows()
        trace = np.empty((min(self._block, self._quota, most) + 1, 1 + 2 * self._states))
        trace[0, 0] = self.t
        trace[0, 1:] = np.concatenate((self.y, self._run.rates[: self._states]))
        first, start = self._numbers.steps, time.perf_counter()
        status, sampled = self._run.advance(len(trace) - 1, times, rows, trace[1:])
        block = trace[: self._numbers.steps - first + 1]
        t, y, f = block[:, 0], block[:, 1 : 1 + self._states], block[:, 1 + self._states :]
        found = self._switch.find_crossings(watch, t, y, f)
        switch = self._first_switch(found, watch, before, t)
        self._block = min(BLOCK, 2 * self._block)
        if switch:
            k, when, sides = switch
            # What was stepped beyond a switch is lost: the next one may be as far as this one was.
            self._block = min(BLOCK, max(SHORT, 2 * k))
            self._run.memory[:] = before
            status, sampled = self._run.advance(k, times, rows)
            found = [crossing for crossing in found if crossing[0] < k]
            self._switch.head_for(sides)
            self._numbers.end = when
        found = [crossing for crossing in found if not watch.is_switch(crossing[1])]
        if found:
            after = self._run.memory.copy()
            for _, here in self._retake_steps(found, before):
                self._record_events(here, watch, recorder, times[:sampled])
            self._run.memory[:] = after
        self._commit(recorder, times[:sampled], rows)
        self._adapt(status, time.perf_counter() - start)
        if switch or self._extend_past_switch(status, watch):
            return False
        return self._check_status(status)

    def _extend_past_switch(self, status: int, watch: EventDetector) -> bool:
        """Go a little further where a law of the motion was to switch and has not; return whether
        that is needed."""
        n = self._numbers
        if status != int(self._model.REACHED) or n.end == self._switch.goal:
            return False
        f = self._run.rates[: self._states]
        further = self._switch.next_goal(watch, n.t, self.y, f, n.t - n.before)
        n.end = min(further, self._switch.goal)
        return bool(n.end > n.t)

    def _first_switch(
        self, found: list[Found], watch: EventDetector, before: NDArray[np.uint8], t: Array
    ) -> tuple[int, float, dict[int, float]] | None:
        """Find the step, from the bytes before the first one on, in which a law of the motion
        switches first, when, and which numbers that has, with their signs before."""
        switches = [crossing for crossing in found if watch.is_switch(crossing[1])]
        after = self._run.memory.copy()
        try:
            for k, here in self._retake_steps(switches, before):
                if first := watch.first_switch(here, float(t[k]), self._dense_output):
                    return (k, *first)
            return None
        finally:
            self._run.memory[:] = after

    def _retake_steps(
        self, found: list[Found], before: NDArray[np.uint8]
    ) -> Iterator[tuple[int, list[Bracket]]]:
        """Take the steps in which something crosses again, from the bytes before the first one;
        yields the number of each, and what crosses in it."""
        self._run.memory[:], at = before, 0
        for k, crossings in groupby(found, key=itemgetter(0)):
            self._run.advance(k + 1 - at, np.empty(0), np.empty((0, len(self._run.state))))
            at = k + 1
            yield k, [(number, span) for _, number, span in crossings]

    def _dense_output(self, at: Array) -> Array:
        """States (K, states) at times (K,) in the last step."""
        states: Array = self._run.state_at(at)[:, : self._states]
        return states

    def _record_events(
        self, here: list[Bracket], watch: EventDetector, recorder: Recorder, times: Array
    ) -> None:
        """Record the events of the last step, in their order; times: of the samples."""
        for at, number in watch.locate_all(here, self._dense_output):
            row = self._run.state_at(np.array([at]))[0]
            if watch.record_event(number, at, row[: self._states]):
                recorder.commit(int(np.searchsorted(times, at, side="right")))
                recorder.end_at(at, row)
                raise EventStop(number, at)

    # Going on later ---------------------------------------------------------------------------

    def state(self) -> State:
        return {"memory": self._run.memory.copy(), **self._switch.state()}

    def restore(self, state: State) -> None:
        memory, method = state["memory"], self._numbers.method
        if memory.shape != self._run.memory.shape:
            raise ValueError("the checkpoint is of another module")
        self._run.memory[:] = memory
        self._numbers.method = method  # another number, where methods were added since
        self._switch = SwitchProgress.of(state)
        self._stretch = self._numbers.low, self._numbers.high, self._numbers.longest
        self._jumps.resume_stretch(self.end, self._numbers.high)
