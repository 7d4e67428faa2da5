"""Jumps of the energy of a rod where masses come or go at one moment in time.

At a jump of a mass the motion goes on. What leaves has the velocity and the height of its place, so
that the energy which it takes along is the difference of the rod's energies with the masses before
and after, in one and the same state. In a stretch between two break points the work of emptying is
the integral of its power; at the ends of stretches these differences are added. A sample at a break
point has the masses of that very time.
"""

from __future__ import annotations

import math
from types import ModuleType

from rodgen.arrays import Array
from rodgen.loading.generated_module import call_module, structure_of

ROW = -1  # of the work of emptying: the last of all works


class MassJumps:
    """Energy that jumps of the masses of a rod add to the work of emptying, as its run goes from
    stretch to stretch. Zero in between, and where nothing can jump."""

    def __init__(self, model: ModuleType, p: Array):
        self._model, self._p = model, p
        self._possible = has_mass_jumps(model)
        self._high, self._end = math.nan, math.nan

    def begin(self, t: float, y: Array, end: float, low: float, high: float) -> float:
        """Begin a stretch, and return the energy [J] that comes with the masses at its start, time
        t in state y. end: of the stretch; low, high: bounds of the times of its masses."""
        before = self._high if self._end == t else t
        self.resume_stretch(end, high)
        return self._energy_gain(before, low, y)

    def resume_stretch(self, end: float, high: float) -> None:
        """Continue in a stretch that was begun before."""
        self._end, self._high = end, high

    def gain_at_end(self, t: float, y: Array) -> float:
        """Energy [J] that comes by time t itself with masses that jump there, in state y, where the
        stretch ends then; else zero."""
        return self._energy_gain(self._high, t, y) if t == self._end else 0.0

    def _energy_gain(self, before: float, after: float, y: Array) -> float:
        """Energy [J] of a state with the masses of time after, less that with those of before."""
        if not self._possible:
            return 0.0
        gained = self._energy(after, y) - self._energy(before, y)
        return gained if math.isfinite(gained) else 0.0

    def _energy(self, t: float, y: Array) -> float:
        return float(sum(call_module(self._model, "energy", t, y, self._p)))


def has_mass_jumps(model: ModuleType) -> bool:
    """Whether the law of a mass of a module compares something, so that the mass may jump."""
    return any(law.corners() for law in structure_of(model).open_masses.values())
