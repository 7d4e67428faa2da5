"""Steps compiled with the module: nothing comes back to Python but now and then."""

from __future__ import annotations

import time
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.emit.targets import target_of
from rodgen.integrate.events import Found, Switching, Watch
from rodgen.integrate.machine import Happened, State
from rodgen.integrate.mass_jumps import ROW, MassJumps
from rodgen.integrate.samples import Recorder
from rodgen.integrate.stepper import Counts, StepError
from rodgen.model.methods import COMPILED, EITHER
from rodgen.native.run import IMPLICIT
from rodgen.scene.integration import AUTO, Integrate

SLICE = 0.03  # seconds between two looks at the clock and at Ctrl-C
FIRST, MOST = 8, 10**7  # steps in a slice: at first, and at most
TRIED = 4.0  # steps ahead in which the failure of a run is looked for
SHORT, BLOCK = 8, 256  # steps between two looks for events, at least and at most

FAILURES = {
    -1: "the rates stop being finite",
    -2: "the step becomes too small to move on",
    -3: "Newton's method finds no solution, however small the step",
}


def parts(settings: Integrate, target: str | None) -> tuple[str, ...]:
    """What of a module a run is begun with; what else it asks for comes then. target: None for C
    where it can be built."""
    if settings.method == AUTO or (target and not target_of(target).compiled):
        return ("rhs", "power")
    if settings.method in IMPLICIT:
        return ("flow", "newton", "power")
    return ("flow", "power") if settings.method in COMPILED else ("rhs", "power")


class Compiled:
    """A run by a method of the C module (see stepper.Machine)."""

    def __init__(self, model: ModuleType, p: Array, settings: Integrate, t: float, y: Array):
        self._model = model
        step = settings.step if settings.fixed else 0.0
        equal = settings.method in EITHER and settings.fixed
        method = f"{settings.method}_equal_steps" if equal else settings.method
        self._run = model.Run(method, t, y, p, step, *settings.per_step)
        self._numbers = self._run.numbers
        self._states, self._quota, self._block = len(y), FIRST, BLOCK
        self._stretch, self._switch = (-np.inf, np.inf, np.inf), Switching()
        self._jumps = MassJumps(model, p)

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
    def asked(self) -> list[float]:
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
        come = self._jumps.begin(self.t, self.y, end, low, high)
        if come:
            self._run.state[ROW] += come
        self._stretch = low, high, longest
        self._switch = Switching(end, self.t)
        self._judge(self._run.begin(end, low, high, longest))

    def advance(self, recorder: Recorder, watch: Watch, most: int) -> bool:
        if watch.events:
            return self._watched(recorder, watch, most)
        times, rows = recorder.room()
        start = time.perf_counter()
        status, sampled = self._run.on(min(self._quota, most), times, rows)
        took = time.perf_counter() - start
        self._have_come(times[:sampled], rows)
        recorder.took(sampled)
        self._adapt(status, took)
        return self._judge(status)

    def works(self, recorder: Recorder) -> Array:
        work: Array = self._run.state[self._states :].copy()
        if come := self._jumps.at_end(self.t, self.y):
            work[ROW] += come
        return work

    def _have_come(self, times: Array, rows: Array) -> None:
        """Add to samples at the end of the stretch what has come with masses that jump there."""
        if len(times) and (come := self._jumps.at_end(float(times[-1]), self.y)):
            rows[len(times) - 1, ROW] += come

    def _adapt(self, status: int, took: float) -> None:
        """As many steps at a time as take a slice."""
        if status == self._model.PAUSED:
            change = min(4.0, max(0.25, SLICE / max(took, 1e-9)))
            self._quota = int(min(MOST, max(1, self._quota * change)))

    def _judge(self, status: int) -> bool:
        """Whether the end is reached; raises StepError for what went wrong."""
        if status in FAILURES:
            raise StepError(FAILURES[status])
        if status != int(self._model.REACHED):
            return False
        if self._numbers.end == self._switch.goal:
            return True
        self._switch.arrive(self.t)
        return self._judge(self._run.begin(self._switch.goal, *self._stretch))

    # Events -----------------------------------------------------------------------------------

    def _watched(self, recorder: Recorder, watch: Watch, most: int) -> bool:
        """Some steps, then a look back at their ends; where something crosses, the step is taken
        again from the same bytes, for its dense output."""
        before = self._run.memory.copy()
        times, rows = recorder.room()
        trace = np.empty((min(self._block, self._quota, most) + 1, 1 + 2 * self._states))
        trace[0, 0] = self.t
        trace[0, 1:] = np.concatenate((self.y, self._run.rates[: self._states]))
        first, start = self._numbers.steps, time.perf_counter()
        status, sampled = self._run.on(len(trace) - 1, times, rows, trace[1:])
        block = trace[: self._numbers.steps - first + 1]
        t, y, f = block[:, 0], block[:, 1 : 1 + self._states], block[:, 1 + self._states :]
        found = self._switch.seen(watch, t, y, f)
        switch = self._first_switch(found, watch, before, t)
        self._block = min(BLOCK, 2 * self._block)
        if switch:
            k, when, sides = switch
            # What was stepped beyond a switch is lost: the next one may be as far as this one was.
            self._block = min(BLOCK, max(SHORT, 2 * k))
            self._run.memory[:] = before
            status, sampled = self._run.on(k, times, rows)
            found = [crossing for crossing in found if crossing[0] < k]
            self._switch.head_for(sides)
            self._numbers.end = when
        found = [crossing for crossing in found if not watch.switching(crossing[1])]
        if found:
            after = self._run.memory.copy()
            self._run.memory[:] = before
            at = 0
            for k in sorted({k for k, _, _ in found}):
                self._run.on(k + 1 - at, times[:0], rows[:0])
                at = k + 1
                here = [(number, span) for step, number, span in found if step == k]
                self._settle(here, watch, recorder, times, sampled)
            self._run.memory[:] = after
        self._have_come(times[:sampled], rows)
        recorder.took(sampled)
        self._adapt(status, time.perf_counter() - start)
        return False if switch or self._goes_on(status, watch) else self._judge(status)

    def _goes_on(self, status: int, watch: Watch) -> bool:
        """Whether a run that is where a law of the motion was to switch has to step a little
        further for that."""
        n = self._numbers
        if status != int(self._model.REACHED) or n.end == self._switch.goal:
            return False
        f = self._run.rates[: self._states]
        further = self._switch.further(watch, n.t, self.y, f, n.t - n.before)
        n.end = min(further, self._switch.goal)
        return bool(n.end > n.t)

    def _first_switch(
        self, found: list[Found], watch: Watch, before: NDArray[np.uint8], t: Array
    ) -> tuple[int, float, dict[int, float]] | None:
        """The step, from the bytes before the first one on, in which a law of the motion switches
        first, when, and which numbers that has, with their signs before."""
        steps = sorted({k for k, number, _ in found if watch.switching(number)})
        after = self._run.memory.copy()
        self._run.memory[:] = before
        nothing, at = np.empty(0), 0
        try:
            for k in steps:
                self._run.on(k + 1 - at, nothing, np.empty((0, len(self._run.state))))
                at = k + 1
                here = [(n, span) for step, n, span in found if step == k and watch.switching(n)]
                first = watch.first_switch(here, float(t[k]), self._dense)
                if first:
                    return (k, *first)
            return None
        finally:
            self._run.memory[:] = after

    def _dense(self, at: Array) -> Array:
        """States (K, states) at times (K,) in the step that was taken last."""
        states: Array = self._run.at(at)[:, : self._states]
        return states

    def _settle(
        self,
        here: list[tuple[int, tuple[float, float]]],
        watch: Watch,
        recorder: Recorder,
        times: Array,
        sampled: int,
    ) -> None:
        """The events of the step that was taken last, in their order."""
        located = [(watch.locate(number, *span, self._dense), number) for number, span in here]
        for at, number in watch.in_order(located):
            row = self._run.at(np.array([at]))[0]
            if watch.happens(number, at, row[: self._states]):
                recorder.took(int(np.searchsorted(times[:sampled], at, side="right")))
                recorder.end_at(at, row)
                raise Happened(number, at)

    # Going on later ---------------------------------------------------------------------------

    def state(self) -> State:
        return {"memory": self._run.memory.copy(), **self._switch.state()}

    def restore(self, state: State) -> None:
        memory, method = state["memory"], self._numbers.method
        if memory.shape != self._run.memory.shape:
            raise ValueError("the checkpoint is of another module")
        self._run.memory[:] = memory
        self._numbers.method = method  # another number, where methods were added since
        self._switch = Switching.of(state)
        self._stretch = self._numbers.low, self._numbers.high, self._numbers.longest
        self._jumps.go_on(self.end, self._numbers.high)
