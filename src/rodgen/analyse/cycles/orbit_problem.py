"""Curves of periodic motions: the equations of their closing, whatever the parameter is."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import Any

import numpy as np

from rodgen.analyse.curves.curve import ContinuationProblem
from rodgen.analyse.cycles.cycle_result import nontrivial
from rodgen.analyse.cycles.elimination import Complex, CondensedSystem
from rodgen.analyse.cycles.periodicity import Linearisation, Orbit
from rodgen.analyse.cycles.shooting import Shooting
from rodgen.analyse.cycles.symmetry import SymmetryReduction
from rodgen.arrays import Array

KEPT = 64  # linearised orbits
LARGEST = 50.0  # logarithm of a period over the first


class OrbitProblem(ContinuationProblem):
    """Base of curves of periodic motions. u: states at the starts of segments, rates over the first
    frequency; log(period / the first), unless given (forced); the angle by which the rod turns
    [rad], where unknown; further unknowns, and the parameter.

    growth: by which a multiplier exceeds 1 at least where the motion is unstable.
    """

    growth: float

    def __init__(
        self, quotient: SymmetryReduction, orbit: Orbit, others: int, forced: bool = False
    ):
        """orbit: near the first motion; others: how many entries of u come after the angle."""
        self.quotient, self.first, self.forced = quotient, orbit, forced
        self.count, size = orbit.x.shape
        self.states = orbit.x.size
        rate = 2 * np.pi / orbit.period
        self.scale = np.where(np.arange(size) < quotient.positions, 1.0, rate)
        more = (not forced) + quotient.turns + others
        self.weights = np.append(np.full(self.states, 1 / self.states), np.ones(more))
        self._known: dict[bytes, tuple[Orbit, Linearisation]] = {}

    @property
    @abstractmethod
    def trivial(self) -> int:
        """Number of multipliers that are 1 along the whole curve."""

    @abstractmethod
    def shooting(self, u: Array) -> Shooting:
        """Shooting method at the parameter of u."""

    def load_period(self, u: Array) -> float:
        """Period [s] of forced motions at u."""
        raise NotImplementedError

    def adapt_to(self, u: Array) -> None:
        self.set_phase(self.shooting(u), self.orbit(u))

    def set_phase(self, shooting: Shooting, orbit: Orbit) -> None:
        """Set the phase condition: first states do not differ from an orbit's along its motion,
        nor as the rod turns."""
        ways = shooting.phase_directions(orbit) / self.scale
        self._ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        self._reference = orbit.x[0] / self.scale

    def pack_orbit(self, orbit: Orbit) -> list[Array]:
        """First parts of u of an orbit: its states, period and angle."""
        parts = [(orbit.x / self.scale).ravel()]
        if not self.forced:
            parts.append(np.array([np.log(orbit.period / self.first.period)]))
        if self.quotient.turns:
            parts.append(np.array([orbit.angle]))
        return parts

    def orbit(self, u: Array) -> Orbit:
        """Unpack u to an orbit."""
        x = u[: self.states].reshape(self.count, -1) * self.scale
        more = u[self.states :].tolist()
        if self.forced:
            period = self.load_period(u)
        else:
            period = self.first.period * float(np.exp(np.clip(more.pop(0), -LARGEST, LARGEST)))
        angle = more.pop(0) if self.quotient.turns else self.first.angle
        return replace(self.first, x=x, period=period, angle=angle)

    def orbit_and_linearisation(self, u: Array) -> tuple[Orbit, Linearisation]:
        """Orbit of u and its linearised closing, cached."""
        key = u.tobytes()
        if key not in self._known:
            while len(self._known) >= KEPT:
                self._known.pop(next(iter(self._known)))
            orbit = self.orbit(u)
            self._known[key] = orbit, self.shooting(u).linearise(orbit)
        return self._known[key]

    def closing_equations(self, u: Array) -> tuple[Array, Array, int]:
        """F and its Jacobian, filled in for the closing of the segments and the phase, and the
        first column of the further unknowns."""
        orbit, made = self.orbit_and_linearisation(u)
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
        """All multipliers at u, the largest first."""
        return CondensedSystem.of(self.orbit_and_linearisation(u)[1].G).multipliers

    def nontrivial(self, u: Array) -> Complex:
        """Multipliers at u without those that are 1 along the whole curve."""
        return nontrivial(self.multipliers(u), self.trivial)

    def count_unstable(self, u: Array) -> int:
        return int((np.abs(self.nontrivial(u)) > 1 + self.growth).sum())

    def sample_motion(self, u: Array, samples: int) -> tuple[Array, dict[str, Any]]:
        """Sample the motion at u over a period. Returns reduced states (samples, size), and the
        values that any motion has, by the names of variables."""
        orbit, q = self.orbit(u), self.quotient
        x = self.shooting(u).flow.segment_states(orbit.t, orbit.x[0], orbit.period, samples)
        angles = x[:, q.angles]
        if q.turns:
            angles = angles - angles.mean(axis=1, keepdims=True)
        left = self.nontrivial(u)
        return x, {
            "period": orbit.period,
            "amplitude": float(np.ptp(angles, axis=0).max()) / 2,
            "multipliers": np.stack((left.real, left.imag), -1),
            "y0": q.lift(x[0]),
        }
