"""Steps compiled with the module: nothing comes back to Python but now and then."""

from __future__ import annotations

import time
from types import ModuleType

import numpy as np

from rodgen.integrate.events import Watch
from rodgen.integrate.files.recorder import Recorder
from rodgen.integrate.stepper import Array, Counts, Happened, State, StepError
from rodgen.scene.tables import EITHER, Integrate

SLICE = 0.03  # seconds between two looks at the clock and at Ctrl-C
FIRST, MOST = 8, 10**7  # steps in a slice: at first, and at most
TRIED = 4.0  # steps ahead in which the failure of a run is looked for
BLOCK = 256  # steps between two looks for events

FAILURES = {
    -1: "the rates stop being finite",
    -2: "the step becomes too small to move on",
    -3: "Newton's method finds no solution, however small the step",
}


class Compiled:
    """A run by a method of the C module (see stepper.Machine)."""

    def __init__(self, model: ModuleType, p: Array, settings: Integrate, t: float, y: Array):
        self._model = model
        step = settings.step if settings.fixed else 0.0
        equal = settings.method in EITHER and settings.fixed
        method = f"{settings.method}_equal_steps" if equal else settings.method
        self._run = model.Run(method, t, y, p, step, settings.rtol, settings.atol)
        self._numbers = self._run.numbers
        self._states, self._quota = len(y), FIRST

    @property
    def t(self) -> float:
        return float(self._numbers.t)

    @property
    def y(self) -> Array:
        state: Array = self._run.state[: self._states]
        return state

    @property
    def end(self) -> float:
        return float(self._numbers.end)

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
        self._judge(self._run.begin(end, low, high, longest))

    def advance(self, recorder: Recorder, watch: Watch, most: int) -> bool:
        if watch.events:
            return self._watched(recorder, watch, most)
        times, rows = recorder.room()
        start = time.perf_counter()
        status, sampled = self._run.on(min(self._quota, most), times, rows)
        took = time.perf_counter() - start
        recorder.took(sampled)
        self._adapt(status, took)
        return self._judge(status)

    def works(self, recorder: Recorder) -> Array:
        work: Array = self._run.state[self._states :].copy()
        return work

    def _adapt(self, status: int, took: float) -> None:
        """As many steps at a time as take a slice."""
        if status == self._model.PAUSED:
            change = min(4.0, max(0.25, SLICE / max(took, 1e-9)))
            self._quota = int(min(MOST, max(1, self._quota * change)))

    def _judge(self, status: int) -> bool:
        """Whether the end is reached; raises StepError for what went wrong."""
        if status in FAILURES:
            raise StepError(FAILURES[status])
        return status == int(self._model.REACHED)

    # Events -----------------------------------------------------------------------------------

    def _watched(self, recorder: Recorder, watch: Watch, most: int) -> bool:
        """Some steps, then a look back at their ends; where something crosses, the step is taken
        again from the same bytes, for its dense output."""
        before = self._run.memory.copy()
        times, rows = recorder.room()
        trace = np.empty((min(BLOCK, self._quota, most) + 1, 1 + 2 * self._states))
        trace[0, 0] = self.t
        trace[0, 1:] = np.concatenate((self.y, self._run.rates[: self._states]))
        first, start = self._numbers.steps, time.perf_counter()
        status, sampled = self._run.on(len(trace) - 1, times, rows, trace[1:])
        block = trace[: self._numbers.steps - first + 1]
        t, y, f = block[:, 0], block[:, 1 : 1 + self._states], block[:, 1 + self._states :]
        found = watch.crossings(t, y, f)
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
        recorder.took(sampled)
        self._adapt(status, time.perf_counter() - start)
        return self._judge(status)

    def _settle(
        self,
        here: list[tuple[int, tuple[float, float]]],
        watch: Watch,
        recorder: Recorder,
        times: Array,
        sampled: int,
    ) -> None:
        """The events of the step that was taken last, in their order."""

        def dense(at: Array) -> Array:
            states: Array = self._run.at(at)[:, : self._states]
            return states

        located = [(watch.locate(number, *span, dense), number) for number, span in here]
        for at, number in watch.in_order(located):
            row = self._run.at(np.array([at]))[0]
            if watch.happens(number, at, row[: self._states]):
                recorder.took(int(np.searchsorted(times[:sampled], at, side="right")))
                recorder.end_at(at, row)
                raise Happened(number, at)

    # Going on later ---------------------------------------------------------------------------

    def state(self) -> State:
        return {"memory": self._run.memory.copy()}

    def restore(self, state: State) -> None:
        memory = state["memory"]
        if memory.shape != self._run.memory.shape:
            raise ValueError("the checkpoint is of another module")
        self._run.memory[:] = memory
