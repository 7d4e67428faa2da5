"""Curves of periodic motions: what their equations share, whatever parameter they have."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace

import numpy as np

from rodgen.analyse.curves.curve import Problem
from rodgen.analyse.cycles.closing import Linearised, Orbit
from rodgen.analyse.cycles.elimination import Complex, Condensed
from rodgen.analyse.cycles.quotient import Quotient
from rodgen.analyse.cycles.shooting import Shooting
from rodgen.arrays import Array

KEPT = 64  # linearised orbits
LARGEST = 50.0  # logarithm of a period over the first


class Orbits(Problem):
    """u: states at the starts of segments, the rates over the first frequency; the logarithm of the
    period over the first, unless that is given (forced); the angle by which the rod turns [rad],
    where that is unknown; what else there is, and the parameter."""

    def __init__(self, quotient: Quotient, orbit: Orbit, others: int, forced: bool = False):
        """orbit: near the first motion; others: how many numbers u has beside these."""
        self.quotient, self.first, self.forced = quotient, orbit, forced
        self.count, size = orbit.x.shape
        self.states = orbit.x.size
        rate = 2 * np.pi / orbit.period
        self.scale = np.where(np.arange(size) < quotient.positions, 1.0, rate)
        more = (not forced) + quotient.turns + others
        self.weights = np.append(np.full(self.states, 1 / self.states), np.ones(more))
        self._known: dict[bytes, tuple[Orbit, Linearised]] = {}

    @abstractmethod
    def shooting(self, u: Array) -> Shooting:
        """The equations of closing at u."""

    def given_period(self, u: Array) -> float:
        """The period [s] where it is given."""
        raise NotImplementedError

    def look_along(self, ways: Array, orbit: Orbit) -> None:
        """Let the phase be that of an orbit: first states differ from its own across these ways."""
        ways = ways / self.scale
        self._ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        self._reference = orbit.x[0] / self.scale

    def start_of(self, orbit: Orbit) -> list[Array]:
        """What u of an orbit begins with."""
        parts = [(orbit.x / self.scale).ravel()]
        if not self.forced:
            parts.append(np.array([np.log(orbit.period / self.first.period)]))
        if self.quotient.turns:
            parts.append(np.array([orbit.angle]))
        return parts

    def orbit(self, u: Array) -> Orbit:
        """The orbit of u."""
        x = u[: self.states].reshape(self.count, -1) * self.scale
        more = u[self.states :].tolist()
        if self.forced:
            period = self.given_period(u)
        else:
            period = self.first.period * float(np.exp(np.clip(more.pop(0), -LARGEST, LARGEST)))
        angle = more.pop(0) if self.quotient.turns else self.first.angle
        return replace(self.first, x=x, period=period, angle=angle)

    def known(self, u: Array) -> tuple[Orbit, Linearised]:
        """The orbit of u and its segments' derivatives, kept for a while."""
        key = u.tobytes()
        if key not in self._known:
            while len(self._known) >= KEPT:
                self._known.pop(next(iter(self._known)))
            orbit = self.orbit(u)
            self._known[key] = orbit, self.shooting(u).linearised(orbit)
        return self._known[key]

    def closing(self, u: Array) -> tuple[Array, Array, int]:
        """F and its derivatives, of which the closing of the segments and the phase are filled in;
        from which column on the others begin."""
        orbit, made = self.known(u)
        m, size = orbit.x.shape
        J, F = np.zeros((len(u) - 1, len(u))), np.zeros(len(u) - 1)
        columns = [one.copy() for one in made.B]
        for one in columns if not self.forced else ():
            one[:, 0] *= orbit.period
        width = columns[0].shape[1]
        J[: self.states, self.states : self.states + width] = np.vstack(
            [one / self.scale[:, None] for one in columns]
        )
        for i, (G, r) in enumerate(zip(made.G, made.r, strict=True)):
            rows, after = slice(i * size, (i + 1) * size), (i + 1) % m
            J[rows, i * size : (i + 1) * size] += G * self.scale / self.scale[:, None]
            J[rows, after * size : (after + 1) * size] -= np.eye(size)
            F[rows] = -r / self.scale
        for k, way in enumerate(self._ways):
            J[self.states + k, :size] = way
            F[self.states + k] = way @ (orbit.x[0] / self.scale - self._reference)
        return F, J, self.states + width

    def multipliers(self, u: Array) -> Complex:
        """All of them, the largest first."""
        return Condensed.of(self.known(u)[1].G).multipliers()
