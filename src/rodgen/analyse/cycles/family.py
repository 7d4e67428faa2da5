"""Cycles along a number of a scene, as the solutions of F(u) = 0 that `continuation` follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rodgen.analyse.curves.curve import Point, Special
from rodgen.analyse.curves.special_points import located
from rodgen.analyse.cycles.closing import Orbit
from rodgen.analyse.cycles.cycle import STABLE, nontrivial
from rodgen.analyse.cycles.elimination import Complex
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.orbits import Orbits
from rodgen.analyse.cycles.quotient import Quotient
from rodgen.analyse.cycles.search import Search
from rodgen.analyse.cycles.shooting import Shooting
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.system import ParameterRange

NUDGE = 1e-5  # of the range, of differences of motions by the number: errors are the square
REST = 0.05  # of the first cycle: one that is smaller is none
COMPLEX = 1e-6  # of the modulus: an imaginary part below it is rounding
PERIOD_DOUBLING, TORUS = "period doubling", "torus"


class Cycles(Orbits):
    """Cycles along a number of a scene, over its range."""

    def __init__(
        self,
        search: Search,
        along: ParameterRange,
        quotient: Quotient,
        orbit: Orbit,
        value: float,
        turns: int = 1,
    ):
        """search: whose cycles; along: which number; orbit: near the first cycle, at a
        value; turns: periods of the loads in one of it."""
        super().__init__(quotient, orbit, 1, bool(search.forced))
        self.search, self.along, self.turns = search, along, turns
        flow = Flow(search.model, along.parameters(value), quotient)
        self.method = flow.suited(orbit.t, orbit.x[0], orbit.period).method
        self.least = REST * float(np.ptp(orbit.x, axis=0).max())
        self.look_from(orbit, value)

    def look_from(self, orbit: Orbit, value: float) -> None:
        """Let the phase be that of an orbit."""
        self.look_along(self._shooting(value).directions(orbit), orbit)

    def shooting(self, u: Array) -> Shooting:
        return self._shooting(self.value(u))

    def _shooting(self, value: float) -> Shooting:
        p = self.along.parameters(value)
        return Shooting(Flow(self.search.model, p, self.quotient, self.method), self.forced)

    def value(self, u: Array) -> float:
        """The number of the scene."""
        return float(u[-1]) * self.along.unit

    def given_period(self, u: Array) -> float:
        return self.turns * self._forced(self.value(u))

    def _forced(self, value: float) -> float:
        return self.search.period_at(self.along.at(value))

    def packed(self, orbit: Orbit, value: float) -> Array:
        """u of an orbit."""
        return np.concatenate([*self.start_of(orbit), [value / self.along.unit]])

    def at(self, u: Array) -> tuple[Array, Array]:
        orbit, _ = self.known(u)
        if np.ptp(orbit.x, axis=0).max() < self.least:
            raise AnalysisError("the cycles shrink to an equilibrium, in a Hopf point")
        F, J, _ = self.closing(u)
        by_value = self._by_value(u, orbit)
        J[: self.states, -1] = np.concatenate([one / self.scale for one in by_value])
        return F, J

    def _by_value(self, u: Array, orbit: Orbit) -> list[Array]:
        """Derivatives of the ends of segments by the number over its range, by differences."""
        step, value = NUDGE, self.value(u)
        ends = []
        for sign in (1.0, -1.0):
            there = value + sign * step * self.along.unit
            shooting = self._shooting(there)
            made = orbit
            if self.forced:
                made = replace(orbit, period=self.turns * self._forced(there))
            share = made.period / self.count
            flow = shooting.flow
            found = [flow.carried(made.t + i * share, x, share) for i, x in enumerate(made.x)]
            found[-1] = self.quotient.turned(found[-1], -orbit.angle)
            ends.append(found)
        return [(up - down) / (2 * step) for up, down in zip(*ends, strict=True)]

    # Stability ----------------------------------------------------------------------------------

    @property
    def trivial(self) -> int:
        """How many multipliers are 1 all along."""
        return (not self.forced) + self.quotient.turns

    def unstable(self, u: Array) -> int:
        found = nontrivial(self.multipliers(u), self.trivial)
        return int((np.abs(found) > 1 + STABLE).sum())

    def crossings(self, before: Point, after: Point) -> list[Special]:
        """Period doublings and tori (Neimark-Sacker points) between two points."""
        made = []
        for kind, count, measure in (
            (PERIOD_DOUBLING, _flips, _to_flip),
            (TORUS, _turning, _to_torus),
        ):
            numbers = [count(self.multipliers(point.u)) for point in (before, after)]
            if numbers[0] == numbers[1]:
                continue

            def measured(point: Point, of: Callable[[Complex], float] = measure) -> float:
                return of(self.multipliers(point.u))

            try:
                here = located(self, before, after, measured)
            except AnalysisError:
                continue
            mu = self.multipliers(here.u)
            period = self.orbit(here.u).period
            turned = np.abs(np.angle(mu[np.abs(np.abs(mu) - 1).argsort()[: self.trivial + 2]]))
            frequency = float(turned.max()) / (2 * np.pi * period)
            made.append(Special(kind, here.u, frequency=frequency))
        return made


def _oscillating(mu: Complex) -> Complex:
    return mu[mu.imag > COMPLEX * np.abs(mu)]


def _real(mu: Complex) -> Array:
    return np.asarray(mu[np.abs(mu.imag) <= COMPLEX * np.abs(mu)].real)


def _flips(mu: Complex) -> int:
    return int((_real(mu) < -1).sum())


def _turning(mu: Complex) -> int:
    return int((np.abs(_oscillating(mu)) > 1).sum())


def _to_flip(mu: Complex) -> float:
    """Of the multiplier that is nearest to -1, by how much it lies inside."""
    real = _real(mu)
    real = real[real < 0]
    return float(real[np.abs(real + 1).argmin()] + 1) if len(real) else 1.0


def _to_torus(mu: Complex) -> float:
    """Of the pair that is nearest to the unit circle, by how much it lies inside."""
    size = np.abs(_oscillating(mu))
    return float(1 - size[np.abs(size - 1).argmin()]) if len(size) else 1.0
