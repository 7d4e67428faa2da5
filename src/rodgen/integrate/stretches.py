"""Stretches of a run between times that steps must meet, and the interface of integrators, which
take the steps, samples and events of a stretch.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.events import EventDetector
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.stepper import Counts, StepError
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.time_laws import TimeLaws

State = dict[str, NDArray[Any]]

NEAREST = 64  # roundings of the time before a pole, where steps end: at the pole is no state
STRIDE, CREEP = 10_000, 1e-9  # so many steps go at least this share of the way
# What runs are stopped by, beside what a method says.
SPENT, CREPT = "the budget of {} steps is used up", "{} steps brought it no further than from {} s"
UNBOUNDED = "a load grows beyond all bounds"
WAKES = 1e-4  # share of the span around a break point in which a pulse is met anyway

Pulse = tuple[float, float, float]  # begin, peak and end [s]
Pole = tuple[float, Expression] | None


class EventStop(Exception):  # noqa: N818, an event is no error
    """An event, by its number in the scene, ends the run at a time [s]."""

    def __init__(self, number: int, t: float):
        super().__init__(number, t)
        self.number, self.t = number, t


class Integrator(Protocol):
    """Interface of integrators: a method on its way through a run, in C or in Python."""

    @property
    def t(self) -> float:
        """Time that it has reached [s]."""
        ...

    @property
    def y(self) -> Array:
        """State at this time."""
        ...

    @property
    def end(self) -> float:
        """End of the present stretch [s]."""
        ...

    @property
    def load_times(self) -> list[float]:
        """Times [s] at which loads were evaluated of late."""
        ...

    @property
    def counts(self) -> Counts:
        """Steps and evaluations so far."""
        ...

    def begin(self, end: float, low: float, high: float, longest: float) -> None:
        """Begin a stretch up to end [s]. Loads are evaluated between low and high; longest: largest
        step [s] of methods that choose theirs. Raises StepError."""
        ...

    def advance(self, recorder: Recorder, watch: EventDetector, most: int) -> bool:
        """Take at most so many steps, for a few hundredths of a second; True at the end of the
        stretch. Raises StepError, and EventStop where an event ends the run."""
        ...

    def works(self, recorder: Recorder) -> Array:
        """Work of every load since the start [J], (works,); put into the samples so far too."""
        ...

    def state(self) -> State:
        """Arrays from which it goes on to the same bits; ValueError where there can be none."""
        ...

    def restore(self, state: State) -> None:
        """Restore arrays of `state`, before `begin` or in the stretch that they were taken in."""
        ...


@dataclass(frozen=True)
class Stretches:
    """Times in the span of a scene that steps must meet, ascending (ends): break points, and the
    end, or a time just before the first pole of a load; half_period: of the fastest load [s], see
    TimeLaws.half_period."""

    ends: list[float]
    pole: Pole = None
    half_period: float = np.inf

    @classmethod
    def of(cls, laws: TimeLaws, fixed: bool, more: Iterable[Pulse] = ()) -> Stretches:
        """Find the stretches in the span of laws; fixed: all steps are equal; more: more pulses."""
        start, end = laws.start, laws.end
        breaks, pole, half_period = laws.breaks(), laws.first_pole(), laws.half_period()
        last = pole[0] - NEAREST * float(np.spacing(abs(pole[0]))) if pole else end
        if not fixed:  # what steps that grow in a time of rest would pass over
            # A pulse may rise slowly before its change counts: from its own length earlier on, lest
            # a method whose stages leave out the end of a step pass over what comes before.
            pulses = (*laws.pulses(), *more)
            found = (at for begin, peak, over in pulses for at in (2 * begin - over, peak))
            breaks = _drop_close(sorted({*breaks, *found}), set(breaks), WAKES * (end - start))
        ends = [*(at for at in breaks if start < at < last), *([last] if last > start else [])]
        return cls(ends, pole, half_period)

    def between(self, start: float, end: float) -> Stretches:
        """Stretches from a start to an earlier end [s]."""
        inner = self.ends[bisect_right(self.ends, start) : bisect_left(self.ends, end)]
        return replace(self, ends=[*inner, end], pole=None)

    def walk(
        self,
        machine: Integrator,
        recorder: Recorder,
        watch: EventDetector,
        budget: int,
        look: Callable[[], None] = lambda: None,
    ) -> None:
        """Step from where the machine is to the last end, with samples; budget: of steps; look:
        called every few hundredths of a second. Raises StepError, also at a pole and where the
        budget is used up, and EventStop where an event ends the run."""
        if recorder.count == 0 and recorder.times[0] == machine.t:
            recorder.begin(machine.y)
        for end in self.ends:
            if end <= machine.t:
                continue
            if machine.end != end:  # else it was restored in the middle of this stretch
                before = machine.y.copy()
                machine.begin(end, *evaluation_bounds(machine.t, end), self.half_period)
                _record_jump(before, machine, recorder, watch)
            _step_to(end, machine, recorder, watch, budget, look)
        if self.pole:  # a step across it would be finite, and wrong
            raise StepError(UNBOUNDED)


def _record_jump(
    before: Array, machine: Integrator, recorder: Recorder, watch: EventDetector
) -> None:
    """Record the events whose value the state passed as it jumped at the start of a stretch, from
    what it was before. Raises EventStop where one of them ends the run."""
    t, y = machine.t, machine.y
    if np.array_equal(before, y, equal_nan=True):
        return
    for number in watch.events_at_jump(t, before, y):
        if watch.record_event(number, t, y):
            recorder.end_at(t, np.concatenate((y, machine.works(recorder))))
            raise EventStop(number, t)


def _drop_close(times: list[float], kept: set[float], least: float) -> list[float]:
    """Drop the times that are closer than the least to a kept one; kept ones stay."""
    fixed = np.array(sorted(kept))
    return [at for at in times if at in kept or not len(fixed) or np.abs(fixed - at).min() > least]


def evaluation_bounds(start: float, end: float) -> tuple[float, float]:
    """Bounds of the times at which loads are evaluated between start and end.

    A load may jump at either end: each side of the jump sees its own value. In a stretch of a few
    roundings both bounds are the time in the middle.
    """
    low, high = float(start + 8 * np.spacing(abs(start))), float(end - 8 * np.spacing(abs(end)))
    return (low, high) if low <= high else (0.5 * (low + high),) * 2


def _step_to(
    end: float,
    machine: Integrator,
    recorder: Recorder,
    watch: EventDetector,
    budget: int,
    look: Callable[[], None],
) -> None:
    """Step to the end [s] of the present stretch."""
    seen, least = machine.t, CREEP * (end - machine.t)
    goal = machine.counts.nsteps + STRIDE
    done = False
    while not done:
        most = budget - machine.counts.nsteps
        if most <= 0 and machine.t < end:
            raise StepError(SPENT.format(budget))
        most = max(0, min(most, goal - machine.counts.nsteps))
        done = machine.advance(recorder, watch, most)
        if machine.counts.nsteps >= goal:
            goal = machine.counts.nsteps + STRIDE
            if not done and machine.t - seen < least:
                raise StepError(CREPT.format(STRIDE, seen))
            seen = machine.t
        look()


def with_span(scene: Scene, start: float, end: float) -> Scene:
    """Scene with another span, which is not validated."""
    return scene.with_settings(scene.integrate.model_copy(update={"span": [start, end]}))
