"""Stretches of a run between times that steps must meet, up to its end or a pole of a load."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.events import EventDetector
from rodgen.integrate.integrator import Integrator
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.stepper import StepError
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.time_laws import TimeLaws
from rodgen.system import System

NEAREST = 64  # roundings of the time before a pole, where steps end: at the pole is no state
STRIDE, CREEP = 10_000, 1e-9  # so many steps go at least this share of the way
# What runs are stopped by, beside what a method says.
SPENT, CREPT = "the budget of {} steps is used up", "{} steps brought it no further than from {} s"
UNBOUNDED = "a load grows beyond all bounds"
WAKES = 1e-4  # share of the span around a break point in which a pulse is met anyway

Pulse = tuple[float, float, float]  # begin, peak and end [s]
Pole = tuple[float, Expression] | None


@dataclass(frozen=True)
class Stretches:
    """Times in the span of a scene that steps must meet, ascending (ends): break points, and the
    end, or a time just before the first pole of a load; swing: half a period of the fastest load
    [s], see TimeLaws.half_period."""

    ends: list[float]
    pole: Pole = None
    swing: float = np.inf

    @classmethod
    def of(cls, course: TimeLaws, fixed: bool, more: Iterable[Pulse] = ()) -> Stretches:
        """Find the stretches of a course; fixed: all steps are equal; more: other pulses."""
        start, end = course.start, course.end
        breaks, pole, swing = course.breaks(), course.first_pole(), course.half_period()
        last = pole[0] - NEAREST * float(np.spacing(abs(pole[0]))) if pole else end
        if not fixed:  # what steps that grow in a time of rest would pass over
            # A pulse may rise slowly before its change counts: from its own length earlier on, lest
            # a method whose stages leave out the end of a step pass over what comes before.
            pulses = (*course.pulses(), *more)
            found = (at for begin, peak, over in pulses for at in (2 * begin - over, peak))
            breaks = _drop_close(sorted({*breaks, *found}), set(breaks), WAKES * (end - start))
        ends = [*(at for at in breaks if start < at < last), *([last] if last > start else [])]
        return cls(ends, pole, swing)

    def until(self, end: float) -> Stretches:
        """Stretches up to an earlier end [s]."""
        return replace(self, ends=[*(at for at in self.ends if at < end), end], pole=None)

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
                machine.begin(end, *evaluation_bounds(machine.t, end), self.swing)
            _step_to(end, machine, recorder, watch, budget, look)
        if self.pole:  # a step across it would be finite, and wrong
            raise StepError(UNBOUNDED)


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


class Windows:
    """Stretches of an open-ended run: windows as long as the scene's span, one after the other.

    Loads are looked at in one window at a time. origin: where the first begins [s]; span: of the
    present window; stretches: in it.
    """

    def __init__(self, system: System, origin: float):
        start, end = system.settings.span
        self._course, self._fixed = system.time_functions, system.settings.has_fixed_step
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
        """Start of a window [s], by its number."""
        return self._first + (number - 1) * self.length if number else self._origin

    def _move_to(self, number: int) -> None:
        """Move to the window of this number, and find its stretches."""
        self._number = number
        at, over = self.span = self._window_start(number), self._window_start(number + 1)
        if not (self._course.loads or self._course.all):
            self.stretches = Stretches([over])
            return
        across: list[Pulse] = []
        if number and not self._fixed:  # a rest may reach across the border
            half = self.length / 2
            across = replace(self._course, start=at - half, end=at + half).pulses()
        course = replace(self._course, start=at, end=over)
        self.stretches = Stretches.of(course, self._fixed, across)


def with_span(scene: Scene, start: float, end: float) -> Scene:
    """Scene with another span, which is not validated."""
    return scene.with_settings(scene.integrate.model_copy(update={"span": [start, end]}))
