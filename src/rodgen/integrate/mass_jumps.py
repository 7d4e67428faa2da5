"""Energy of masses that come or go at one moment: at a jump of a mass in time the motion goes on,
and the energy of the rod jumps.

What leaves has the velocity and the height of its place, so that the energy which it takes along
is the difference of the rod's energies with the masses before and after, of one and the same
state. In a stretch between two break points the work of emptying is the integral of its power; at
the ends of stretches these differences are added. A sample at a break point has the masses of that
very time.
"""

from __future__ import annotations

import math
from types import ModuleType

from rodgen.arrays import Array
from rodgen.loading.module import asked, structure_of

ROW = -1  # of the work of emptying: the last of all works


class MassJumps:
    """What jumps of the masses of a rod add to the work of emptying, as its run goes from stretch
    to stretch. Between times at which nothing can jump it is zero."""

    def __init__(self, model: ModuleType, p: Array):
        self._model, self._p = model, p
        self._possible = may_jump(model)
        self._high, self._end = math.nan, math.nan

    def begin(self, t: float, y: Array, end: float, low: float, high: float) -> float:
        """Energy [J] that comes with the masses at time t in state y, where the stretch before, or
        the run, ends or begins; end: of the next stretch, in which masses are asked for between
        low and high."""
        before = self._high if self._end == t else t
        self.go_on(end, high)
        return self._gained(before, low, y)

    def go_on(self, end: float, high: float) -> None:
        """Be in a stretch that was begun before."""
        self._end, self._high = end, high

    def at_end(self, t: float, y: Array) -> float:
        """The part of that energy [J] that is there at time t itself, in state y, where the stretch
        ends then; else zero."""
        return self._gained(self._high, t, y) if t == self._end else 0.0

    def _gained(self, before: float, after: float, y: Array) -> float:
        """Energy [J] of a state with the masses of one time less that with those of another."""
        if not self._possible:
            return 0.0
        gained = self._energy(after, y) - self._energy(before, y)
        return gained if math.isfinite(gained) else 0.0

    def _energy(self, t: float, y: Array) -> float:
        return float(sum(asked(self._model, "energy", t, y, self._p)))


def may_jump(model: ModuleType) -> bool:
    """Whether a module has masses whose laws compare something."""
    return any(law.corners() for law in structure_of(model).open_masses.values())
