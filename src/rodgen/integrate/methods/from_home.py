"""A method in Python on time since its stretch began, and on angles less their whole turns.

A rod that has turned a million times bends as before, but a relative tolerance of its angles would
allow a million times the error. Far from zero the times of steps are rounded, and methods that
take the steps themselves as they were meant add up another motion.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rodgen.integrate.stepper import Array, Counts, Interpolant, Rhs, Stepper

TURN = 2 * np.pi

Longest = Callable[[float, Array], float]
# From rhs, jac, the largest stable step, time, state and end.
Make = Callable[[Rhs, Rhs, Longest, float, Array, float], Stepper]


def from_home(
    make: Make,
    angles: slice,
    rhs: Rhs,
    jac: Rhs,
    longest: Longest,
    t: float,
    y: Array,
    end: float,
) -> Stepper:
    """A method from (t, y) to end; angles: which states are."""
    turns = np.zeros(len(y))
    turns[angles] = TURN * np.trunc(y[angles] / TURN)
    if not np.isfinite(turns).all():
        turns[:] = 0.0
    if t == 0 and not turns.any():
        return make(rhs, jac, longest, t, y, end)
    return _FromHome(make, turns, rhs, jac, longest, t, y, end)


class _FromHome:
    """The method on y less the turns, from time zero (see stepper.Stepper)."""

    def __init__(
        self,
        make: Make,
        turns: Array,
        rhs: Rhs,
        jac: Rhs,
        longest: Longest,
        t: float,
        y: Array,
        end: float,
    ):
        self._turns, self._start, self._end = turns, t, end
        self._inner = make(
            lambda past, state: rhs(t + past, state + turns),
            lambda past, state: jac(t + past, state + turns),
            lambda past, state: longest(t + past, state + turns),
            0.0,
            y - turns,
            end - t,
        )
        self.t, self.y = t, y

    @property
    def counts(self) -> Counts:
        return self._inner.counts

    def step(self) -> bool:
        done = self._inner.step()
        self.t = self._end if done else self._start + self._inner.t
        self.y = self._inner.y + self._turns
        return done

    def interpolant(self) -> Interpolant:
        inside = self._inner.interpolant()
        return lambda times: inside(times - self._start) + self._turns
