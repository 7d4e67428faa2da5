"""Cycles over a number of a scene, as a continuation problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rodgen.analyse.curves.curve import CurvePoint, SpecialPoint
from rodgen.analyse.curves.special_points import locate
from rodgen.analyse.cycles.cycle_result import STABLE
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.elimination import Complex
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.orbit_problem import OrbitProblem
from rodgen.analyse.cycles.periodicity import Orbit
from rodgen.analyse.cycles.shooting import Shooting
from rodgen.analyse.cycles.symmetry import SymmetryReduction
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.system import ParameterRange

NUDGE = 1e-5  # of the range, of differences of motions by the number: errors are the square
REST = 0.05  # of the first cycle: one that is smaller is none
COMPLEX = 1e-6  # of the modulus: an imaginary part below it is rounding
PERIOD_DOUBLING, TORUS = "period doubling", "torus"


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
                here = locate(self, before, after, test_function)
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
