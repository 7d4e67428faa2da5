"""Curves of periodic motions: the equations of their closing, whatever the parameter is; and cycles
over a number of a scene, as a continuation problem.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from rodgen.analyse.curves.curve import ContinuationProblem, CurvePoint, SpecialPoint
from rodgen.analyse.curves.special_points import Chord
from rodgen.analyse.cycles.cycle_result import STABLE, nontrivial
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.elimination import Complex, CondensedSystem
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.periodicity import Linearisation, Orbit
from rodgen.analyse.cycles.shooting import Shooting
from rodgen.analyse.cycles.symmetry import SymmetryReduction
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.system import ParameterRange

NUDGE = 1e-5  # of the range, of differences of motions by the number: errors are the square
REST = 0.05  # of the first cycle: one that is smaller is none
COMPLEX = 1e-6  # of the modulus: an imaginary part below it is rounding
PERIOD_DOUBLING, TORUS = "period doubling", "torus"

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
        raise NotImplementedError  # asked of forced motions alone, whose problem has it

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


class CycleFamily(OrbitProblem):
    """Continuation problem of cycles over a number of a scene."""

    growth = STABLE

    def __init__(
        self,
        search: CycleSearch,
        along: ParameterRange,
        quotient: SymmetryReduction,
        orbit: Orbit,
        value: float,
        turns: int = 1,
    ):
        """search: for the cycles; along: the number and its range; orbit: near the first cycle, at
        a value; turns: periods of the loads in one of the cycle."""
        super().__init__(quotient, orbit, 1, bool(search.forced))
        self.search, self.along, self.turns = search, along, turns
        flow = Flow(search.model, along.parameters(value), quotient)
        self.method = flow.choose_method(orbit.t, orbit.x[0], orbit.period).method
        self.least = REST * float(np.ptp(orbit.x, axis=0).max())
        self.set_phase(self.shooting_at(value), orbit)

    def shooting(self, u: Array) -> Shooting:
        return self.shooting_at(self.value(u))

    def shooting_at(self, value: float) -> Shooting:
        """Shooting method at a value of the number."""
        p = self.along.parameters(value)
        return Shooting(Flow(self.search.model, p, self.quotient, self.method), self.forced)

    def value(self, u: Array) -> float:
        """The number of the scene at u."""
        return float(u[-1]) * self.along.unit

    def load_period(self, u: Array) -> float:
        return self.turns * self._load_period_at(self.value(u))

    def _load_period_at(self, value: float) -> float:
        return self.search.period_at(self.along.at(value))

    def pack(self, orbit: Orbit, value: float) -> Array:
        """Pack an orbit and a value into u."""
        return np.concatenate([*self.pack_orbit(orbit), [value / self.along.unit]])

    def evaluate(self, u: Array) -> tuple[Array, Array]:
        orbit, _ = self.orbit_and_linearisation(u)
        if np.ptp(orbit.x, axis=0).max() < self.least:
            raise AnalysisError("the cycles shrink to an equilibrium, in a Hopf point")
        F, J, _ = self.closing_equations(u)
        by_value = self._by_value(u, orbit)
        J[: self.states, -1] = np.concatenate([one / self.scale for one in by_value])
        return F, J

    def _by_value(self, u: Array, orbit: Orbit) -> list[Array]:
        """Derivatives of the ends of segments by the number over its range, by differences."""
        step, value = NUDGE, self.value(u)
        ends = []
        for sign in (1.0, -1.0):
            there = value + sign * step * self.along.unit
            shooting = self.shooting_at(there)
            made = orbit
            if self.forced:
                made = replace(orbit, period=self.turns * self._load_period_at(there))
            share = made.period / self.count
            flow = shooting.flow
            found = [flow.state_after(made.t + i * share, x, share) for i, x in enumerate(made.x)]
            found[-1] = self.quotient.rotate(found[-1], -orbit.angle)
            ends.append(found)
        return [(up - down) / (2 * step) for up, down in zip(*ends, strict=True)]

    # Stability ----------------------------------------------------------------------------------

    @property
    def trivial(self) -> int:
        return (not self.forced) + self.quotient.turns

    def crossings(self, before: CurvePoint, after: CurvePoint) -> list[SpecialPoint]:
        """Find period doublings and tori (Neimark-Sacker points) between two points."""
        made = []
        for kind, count, measure in (
            (PERIOD_DOUBLING, _count_flips, _flip_distance),
            (TORUS, _count_tori, _torus_distance),
        ):
            numbers = [count(self.multipliers(point.u)) for point in (before, after)]
            if numbers[0] == numbers[1]:
                continue

            def test_function(point: CurvePoint, of: Callable[[Complex], float] = measure) -> float:
                return of(self.multipliers(point.u))

            try:
                here = Chord(self, before, after).locate(test_function)
            except AnalysisError:
                continue
            mu = self.multipliers(here.u)
            period = self.orbit(here.u).period
            turned = np.abs(np.angle(mu[np.abs(np.abs(mu) - 1).argsort()[: self.trivial + 2]]))
            frequency = float(turned.max()) / (2 * np.pi * period)
            made.append(SpecialPoint(kind, here.u, frequency=frequency))
        return made


def _complex_multipliers(mu: Complex) -> Complex:
    return mu[mu.imag > COMPLEX * np.abs(mu)]


def _real_multipliers(mu: Complex) -> Array:
    return np.asarray(mu[np.abs(mu.imag) <= COMPLEX * np.abs(mu)].real)


def _count_flips(mu: Complex) -> int:
    return int((_real_multipliers(mu) < -1).sum())


def _count_tori(mu: Complex) -> int:
    return int((np.abs(_complex_multipliers(mu)) > 1).sum())


def _flip_distance(mu: Complex) -> float:
    """Distance from -1 of the real multiplier nearest to it, positive inside the unit circle."""
    real = _real_multipliers(mu)
    real = real[real < 0]
    return float(real[np.abs(real + 1).argmin()] + 1) if len(real) else 1.0


def _torus_distance(mu: Complex) -> float:
    """Distance from the unit circle of the pair nearest to it, positive inside."""
    size = np.abs(_complex_multipliers(mu))
    return float(1 - size[np.abs(size - 1).argmin()]) if len(size) else 1.0
