"""Stretches of a run: from one time that steps must meet to the next, up to the end or a pole."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rodgen.integrate.stepper import StepError
from rodgen.scene import Scene
from rodgen.scene.expression import Expression

NEAREST = 64  # roundings of the time before a pole, where steps end: at the pole is no state
WAKES = 1e-4  # share of the span around a break point in which a pulse is met anyway

Pulse = tuple[float, float, float]  # begin, peak and end [s]
Pole = tuple[float, Expression] | None


def ends(scene: Scene, breaks: list[float], pulses: Iterable[Pulse], pole: Pole) -> list[float]:
    """Times to step to, one after the other: break points, and the end, or just before the first
    pole."""
    start, end = scene.integrate.span
    last = pole[0] - NEAREST * float(np.spacing(abs(pole[0]))) if pole else end
    if not scene.integrate.fixed:  # what steps that grow in a time of rest would pass over
        # A pulse may rise slowly before its change counts: from its own length earlier on, lest
        # a method whose stages leave out the end of a step pass over what comes before.
        found = (at for begin, peak, over in pulses for at in (2 * begin - over, peak))
        breaks = _apart(sorted({*breaks, *found}), set(breaks), WAKES * (end - start))
    return [*(at for at in breaks if start < at < last), *([last] if last > start else [])]


def _apart(times: list[float], kept: set[float], least: float) -> list[float]:
    """Times without those that are closer than the least to one that is kept."""
    fixed = np.array(sorted(kept))
    return [at for at in times if at in kept or not len(fixed) or np.abs(fixed - at).min() > least]


def inside(start: float, end: float) -> tuple[float, float]:
    """Times at which loads may be asked for their values between start and end.

    There a load may jump: each side of it sees its own value.
    """
    return float(start + 8 * np.spacing(abs(start))), float(end - 8 * np.spacing(abs(end)))


class Windows:
    """Stretches of a run without an end: windows as long as the scene's span, one after the other.

    What a load does is looked for in one window at a time. origin: where the first begins [s].
    """

    def __init__(self, scene: Scene, origin: float):
        start, end = scene.integrate.span
        self._scene, self._origin, self.length = scene, origin, end - start
        # To the bit, lest the first window end beside the span.
        self._first = end if origin == start else origin + self.length
        self._number = -1
        self._ends: list[float] = []
        self.scene = scene
        self.pole: Pole = None
        self.swing = np.inf  # the fastest of the loads [s], see Scene.swing
        self._look_at(0)

    def after(self, t: float) -> float:
        """The end of the stretch that begins at a time [s]. Raises StepError at a pole."""
        least = t + 4 * float(np.spacing(abs(t)))  # closer, and loads would be asked beyond it
        number = max(0, int((least - self._origin) // self.length))
        # The division may be a rounding beside the borders.
        number -= number > 0 and self._border(number) > least
        number += self._border(number + 1) <= least
        if number != self._number:
            self._look_at(number)
        for end in self._ends:
            if end > least:
                return end
        raise StepError("a load grows beyond all bounds")

    def _border(self, number: int) -> float:
        """Where a window begins [s]."""
        return self._first + (number - 1) * self.length if number else self._origin

    def _look_at(self, number: int) -> None:
        """Take the window of this number."""
        self._number = number
        if not self._scene.timed:
            self._ends = [self._border(number + 1)]
            return
        at, over = self._border(number), self._border(number + 1)
        self.scene = window(self._scene, at, over)
        breaks, self.pole = self.scene.breaks(), self.scene.pole()
        self.swing = self.scene.swing()
        pulses = self.scene.pulses()
        if number and not self.scene.integrate.fixed:  # a rest may reach across the border
            half = self.length / 2
            across = window(self._scene, at - half, at + half).pulses()
            pulses = sorted({*pulses, *across})
        self._ends = ends(self.scene, breaks, pulses, self.pole)


def window(scene: Scene, start: float, end: float) -> Scene:
    """The scene with another span, which need not be checked."""
    settings = scene.integrate.model_copy(update={"span": [start, end]})
    return scene.model_copy(update={"integrate": settings})
