"""Steppers of fixed step: equal steps from a start, the last one shortened to meet the end."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.stepper import (
    Counts,
    InitialValueProblem,
    Interpolant,
    Rhs,
    StepError,
    hermite,
)
from rodgen.model.methods import TABLEAUX, Tableau

Advance = Callable[[Rhs, float, Array, Array, float], Array]


def explicit_step(
    tableau: Tableau, number: Callable[[Any], Any] = float, added: int = 0
) -> Advance:
    """Make the step of an explicit method: new state from rhs, t, y, the rate at (t, y) and h.

    number: converts the weights; states may be of symbols where it makes such; added: how many of
    the states are neither positions nor velocities.
    """
    rows = [[(at, number(w)) for at, w in enumerate(row) if w] for row in tableau.rows]
    times = [number(c) for c in tableau.c]

    def combine(y: Array, h: float, row: list[tuple[int, Any]], rates: list[Array]) -> Array:
        new: Array = y + h * sum(weight * rates[at] for at, weight in row)
        if tableau.follow:
            half = (len(y) - added) // 2
            new[:half] = y[:half] + h * new[half : 2 * half]
        return new

    def step(rhs: Rhs, t: float, y: Array, f: Array, h: float) -> Array:
        rates = [f]
        for c, row in zip(times[1:], rows, strict=False):
            rates.append(rhs(t + c * h, combine(y, h, row, rates)))
        return combine(y, h, rows[-1], rates)

    return step


class FixedStep:
    """Stepper of a method of fixed step between two break points (see stepper.Stepper)."""

    def __init__(self, problem: InitialValueProblem):
        t, y, end, step = problem.t, problem.y, problem.end, problem.settings.step
        assert step is not None
        tableau = TABLEAUX[problem.settings.method]
        self._advance, self._step = explicit_step(tableau, added=problem.added), step
        self._counts = Counts(rejected=0)

        def rhs(at: float, state: Array) -> Array:
            self._counts.nfev += 1
            return problem.rhs(at, state)

        self._rhs = rhs
        self._start, self._end = t, end
        # A step that would be shorter than a millionth of the others is not taken.
        self._total = max(1, math.ceil((end - t) / step - 1e-6))
        self.t, self.y = t, y
        self._f = rhs(t, y)

    @property
    def counts(self) -> Counts:
        """Steps and evaluations so far."""
        return self._counts

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        self._counts.nsteps += 1
        last = self._counts.nsteps >= self._total
        t = self._end if last else self._start + self._counts.nsteps * self._step
        y = self._advance(self._rhs, self.t, self.y, self._f, t - self.t)
        f = self._rhs(t, y)
        if not np.isfinite(f).all():
            raise StepError("the rates stop being finite in the step after this time")
        self._before = (self.t, self.y, self._f)
        self.t, self.y, self._f = t, y, f
        return last

    def interpolant(self) -> Interpolant:
        """Cubic Hermite interpolant of the ends of the last step."""
        return hermite(*self._before, self.t, self.y, self._f)
