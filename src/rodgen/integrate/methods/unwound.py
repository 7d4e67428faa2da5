"""A method in Python on angles less their whole turns, so that its tolerance knows none of them.

A rod that has turned a million times bends as before, but a relative tolerance of its angles would
allow a million times the error.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rodgen.integrate.stepper import Array, Counts, Interpolant, Rhs, Stepper

TURN = 2 * np.pi

Make = Callable[[Rhs, Rhs, float, Array, float], Stepper]


def unwound(
    make: Make, angles: slice, rhs: Rhs, jac: Rhs, t: float, y: Array, end: float
) -> Stepper:
    """A method from (t, y) to end; angles: which states are."""
    turns = np.zeros(len(y))
    turns[angles] = TURN * np.trunc(y[angles] / TURN)
    if not turns.any() or not np.isfinite(turns).all():
        return make(rhs, jac, t, y, end)
    return _Unwound(make, turns, rhs, jac, t, y, end)


class _Unwound:
    """The method on y less the turns (see stepper.Stepper)."""

    def __init__(
        self, make: Make, turns: Array, rhs: Rhs, jac: Rhs, t: float, y: Array, end: float
    ):
        self._turns = turns
        self._inner = make(
            lambda at, state: rhs(at, state + turns),
            lambda at, state: jac(at, state + turns),
            t,
            y - turns,
            end,
        )
        self.t, self.y = t, y

    @property
    def counts(self) -> Counts:
        return self._inner.counts

    def step(self) -> bool:
        done = self._inner.step()
        self.t, self.y = self._inner.t, self._inner.y + self._turns
        return done

    def interpolant(self) -> Interpolant:
        inside = self._inner.interpolant()
        return lambda times: inside(times) + self._turns
