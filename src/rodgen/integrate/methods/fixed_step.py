"""Methods of fixed step: equal steps from a start, the last one shortened to meet the end."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from rodgen.integrate.methods import euler, rk4, semi_implicit_euler, thesis_runge_kutta
from rodgen.integrate.stepper import Array, Counts, Interpolant, Rhs, StepError, hermite

Advance = Callable[[Rhs, float, Array, Array, float], Array]
METHODS: dict[str, Advance] = {
    "euler": euler.advance,
    "semi_implicit_euler": semi_implicit_euler.advance,
    "rk4": rk4.advance,
    "thesis_runge_kutta": thesis_runge_kutta.advance,
}


class FixedStep:
    """A method of fixed step between two break points (see stepper.Stepper)."""

    def __init__(self, name: str, rhs: Rhs, t: float, y: Array, end: float, step: float):
        self._advance, self._step = METHODS[name], step
        self._counts = Counts(rejected=0)

        def counted(at: float, state: Array) -> Array:
            self._counts.rhs += 1
            return rhs(at, state)

        self._rhs = counted
        self._start, self._end = t, end
        # A step that would be shorter than a millionth of the others is not taken.
        self._total = max(1, math.ceil((end - t) / step - 1e-6))
        self.t, self.y = t, y
        self._f = counted(t, y)

    @property
    def counts(self) -> Counts:
        """Cost so far."""
        return self._counts

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        self._counts.steps += 1
        last = self._counts.steps >= self._total
        t = self._end if last else self._start + self._counts.steps * self._step
        y = self._advance(self._rhs, self.t, self.y, self._f, t - self.t)
        f = self._rhs(t, y)
        if not np.isfinite(f).all():
            raise StepError("the rates stop being finite in the step after this time")
        self._before = (self.t, self.y, self._f)
        self.t, self.y, self._f = t, y, f
        return last

    def interpolant(self) -> Interpolant:
        """Cubic through the ends of the last step."""
        return hermite(*self._before, self.t, self.y, self._f)
