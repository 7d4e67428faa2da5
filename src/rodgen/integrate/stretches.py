"""Stretches of a run: from one time that steps must meet to the next, up to the end or a pole."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.events import Watch
from rodgen.integrate.machine import Machine
from rodgen.integrate.samples import Recorder
from rodgen.integrate.stepper import StepError
from rodgen.scene import Scene
from rodgen.scene.course import Course
from rodgen.scene.expression import Expression
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
    """Times to step to in the span of a scene, one after the other (ends): break points, and its
    end, or just before the first pole of a load; swing: the fastest of the loads [s], see
    Course.swing."""

    ends: list[float]
    pole: Pole = None
    swing: float = np.inf

    @classmethod
    def of(cls, course: Course, fixed: bool, more: Iterable[Pulse] = ()) -> Stretches:
        """fixed: whether steps are all equal; more: pulses besides those of the span."""
        start, end = course.start, course.end
        breaks, pole, swing = course.breaks(), course.pole(), course.swing()
        last = pole[0] - NEAREST * float(np.spacing(abs(pole[0]))) if pole else end
        if not fixed:  # what steps that grow in a time of rest would pass over
            # A pulse may rise slowly before its change counts: from its own length earlier on, lest
            # a method whose stages leave out the end of a step pass over what comes before.
            pulses = (*course.pulses(), *more)
            found = (at for begin, peak, over in pulses for at in (2 * begin - over, peak))
            breaks = _apart(sorted({*breaks, *found}), set(breaks), WAKES * (end - start))
        ends = [*(at for at in breaks if start < at < last), *([last] if last > start else [])]
        return cls(ends, pole, swing)


def _apart(times: list[float], kept: set[float], least: float) -> list[float]:
    """Times without those that are closer than the least to one that is kept."""
    fixed = np.array(sorted(kept))
    return [at for at in times if at in kept or not len(fixed) or np.abs(fixed - at).min() > least]


def inside(start: float, end: float) -> tuple[float, float]:
    """Times at which loads may be asked for their values between start and end.

    There a load may jump: each side of it sees its own value. Of a stretch of a few roundings that
    is the time in the middle.
    """
    low, high = float(start + 8 * np.spacing(abs(start))), float(end - 8 * np.spacing(abs(end)))
    return (low, high) if low <= high else (0.5 * (low + high),) * 2


def step_to(
    end: float,
    machine: Machine,
    recorder: Recorder,
    watch: Watch,
    budget: int,
    look: Callable[[], None],
) -> None:
    """Step to the end [s] of the stretch that was begun, with samples; look: is called every few
    hundredths of a second. Raises StepError, also where the budget of steps is used up, and
    Happened where an event ends the run."""
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
    """Stretches of a run without an end: windows as long as the scene's span, one after the other.

    What a load does is looked for in one window at a time. origin: where the first begins [s];
    span: of the present window, stretches: those of it.
    """

    def __init__(self, system: System, origin: float):
        start, end = system.settings.span
        self._course, self._fixed = system.course, system.settings.fixed
        self._origin, self.length = origin, end - start
        # To the bit, lest the first window end beside the span.
        self._first = end if origin == start else origin + self.length
        self._number = -1
        self._look_at(0)

    def after(self, t: float) -> float:
        """The end of the stretch that begins at a time [s]. Raises StepError at a pole."""
        least = t + 4 * float(np.spacing(abs(t)))  # closer, and loads would be asked beyond it
        number = max(0, int((least - self._origin) // self.length))
        # The division may be a rounding beside the borders.
        number -= number > 0 and self._border(number) > least
        number += self._border(number + 1) <= least
        if number != self._number:
            try:
                self._look_at(number)
            except InputError as error:  # of masses that jump too often there
                raise StepError(str(error)) from None
        for end in self.stretches.ends:
            if end > least:
                return end
        raise StepError(UNBOUNDED)

    def _border(self, number: int) -> float:
        """Where a window begins [s]."""
        return self._first + (number - 1) * self.length if number else self._origin

    def _look_at(self, number: int) -> None:
        """Take the window of this number."""
        self._number = number
        at, over = self.span = self._border(number), self._border(number + 1)
        if not (self._course.loads or self._course.all):
            self.stretches = Stretches([over])
            return
        across: list[Pulse] = []
        if number and not self._fixed:  # a rest may reach across the border
            half = self.length / 2
            across = replace(self._course, start=at - half, end=at + half).pulses()
        course = replace(self._course, start=at, end=over)
        self.stretches = Stretches.of(course, self._fixed, across)


def window(scene: Scene, start: float, end: float) -> Scene:
    """The scene with another span, which need not be checked."""
    return scene.with_settings(scene.integrate.model_copy(update={"span": [start, end]}))
