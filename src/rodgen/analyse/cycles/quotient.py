"""What of a state counts for its motion: cycles are sought up to rigid motions of the whole rod.

Where nothing depends on where joint 0 is, nor (without drag) on how fast it moves, these states are
left out; where loads turn with the rod, or there are none, turning the whole rod turns the motion,
and a motion that comes back turned by an angle is a cycle: a relative periodic motion. What is so
is seen from the derivatives of the rates, not from the names of the loads.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.model.rod import BOUNDARIES

PLACES = 3  # states at which the derivatives are looked at
ASIDE = 0.1  # rad, and rad/s, beside the motion: there no symmetry is by chance
SAME = 1e-9  # of the sizes of what is compared: roundings


@dataclass(frozen=True)
class Quotient:
    """kept: indices of the states that count; turns: whether turning the rod turns its motion;
    angles, velocity: where among those kept the angles and the velocity of joint 0 are (the latter
    empty where it does not count); positions: how many of them are angles or places; led: where
    among those kept the rates of these are; origin: a state (states,) of which the others are
    taken."""

    kept: NDArray[np.intp]
    turns: bool
    angles: NDArray[np.intp]
    velocity: NDArray[np.intp]
    positions: int
    led: NDArray[np.intp]
    origin: Array = field(repr=False)

    @classmethod
    def of(cls, model: ModuleType, p: Array, t: float, y: Array) -> Quotient:
        """Of a module with parameters p, seen at a time t [s] about a state y (states,)."""
        base = 2 * BOUNDARIES[model.BOUNDARY].translates
        half = (len(y) - len(getattr(model, "STATES", ()))) // 2
        random = np.random.default_rng(1)
        near = [y + ASIDE * random.standard_normal(len(y)) for _ in range(PLACES)]
        J = [model.jac(t, one, p) for one in near]
        out = list[int]()
        for first in (0, half) if base else ():
            pair = np.array([first, first + 1])
            # Places are led by velocities: only what is kept must not follow them.
            rows = np.setdiff1d(np.arange(len(y)), [*out, *pair.tolist()])
            if any(one[np.ix_(rows, pair)].any() for one in J):
                break
            out += pair.tolist()
        kept = np.setdiff1d(np.arange(len(y)), out)
        angles = np.flatnonzero((kept >= base) & (kept < half))
        velocity = np.flatnonzero((kept >= half) & (kept < half + base))
        positions = int((kept < half).sum())
        led = np.searchsorted(kept, kept[:positions] + half)
        made = cls(kept, False, angles, velocity, positions, led, y.copy())
        placed = base > 0 and 0 in kept
        turns = not placed and all(
            made._turned_alike(model.rhs(t, one, p), matrix, one)
            for one, matrix in zip(near, J, strict=True)
        )
        return replace(made, turns=turns)

    def _turned_alike(self, f: Array, J: Array, y: Array) -> bool:
        """Whether rates f with the derivatives J turn with the state, to first order."""
        way = self.turning(y[self.kept])
        there = J[np.ix_(self.kept, self.kept)]
        change, f = there @ way - self._across(f[self.kept]), f[self.kept]
        sizes = np.abs(there) @ np.abs(way) + np.abs(self._across(f))
        return bool((np.abs(change) <= SAME * np.maximum(sizes, 1e-6 * sizes.max())).all())

    def _across(self, x: Array) -> Array:
        """Velocities of joint 0 turned by a right angle, and zeros."""
        made = np.zeros_like(x)
        if len(self.velocity):
            vx, vy = self.velocity
            made[..., vx], made[..., vy] = -x[..., vy], x[..., vx]
        return made

    @property
    def size(self) -> int:
        """How many states count."""
        return len(self.kept)

    def turning(self, x: Array) -> Array:
        """How the states that count change (size,) as the rod is turned, by the angle."""
        way = self._across(x)
        way[..., self.angles] = 1.0
        return way

    def turned(self, x: Array, angle: float) -> Array:
        """States x (..., size) of the rod turned by an angle [rad]."""
        made = x.copy()
        made[..., self.angles] += angle
        if len(self.velocity):
            across = self._across(x)
            at = self.velocity
            made[..., at] = np.cos(angle) * x[..., at] + np.sin(angle) * across[..., at]
        return made

    def turned_columns(self, V: Array, angle: float) -> Array:
        """Directions V (size, k) turned by an angle."""
        if not len(self.velocity):
            return V
        made = V.copy()
        at = self.velocity
        made[at] = np.cos(angle) * V[at] + np.sin(angle) * self._across(V.T).T[at]
        return made

    def lifted(self, x: Array, like: Array | None = None) -> Array:
        """Whole states (..., states) of those that count; like: of which the others are taken."""
        rest = self.origin if like is None else like
        made = np.broadcast_to(rest, (*x.shape[:-1], len(rest))).copy()
        made[..., self.kept] = x
        return made
