"""Cycles along a number of a scene, as the solutions of F(u) = 0 that `continuation` follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rodgen.analyse.curves.curve import Point, Problem, Special
from rodgen.analyse.curves.special_points import located
from rodgen.analyse.cycles.cycle import STABLE, Search, nontrivial
from rodgen.analyse.cycles.drive import load_period
from rodgen.analyse.cycles.elimination import Complex, Condensed
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.quotient import Quotient
from rodgen.analyse.cycles.shooting import Linearised, Orbit, Shooting
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.system import frozen
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.keys import with_value
from rodgen.scene.plain import is_number, plain

NUDGE = 1e-5  # of the range, of differences of motions by the number: errors are the square
REST = 0.05  # of the first cycle: one that is smaller is none
KEPT = 8  # linearised orbits
COMPLEX = 1e-6  # of the modulus: an imaginary part below it is rounding
PERIOD_DOUBLING, TORUS = "period doubling", "torus"


@dataclass
class Variation:
    """A number of a scene between two ends, and the flow and the period of loads at its values.

    Raises SceneError for a key that the scene does not have, that is no number, or that changes the
    equations themselves.
    """

    search: Search
    scene: Scene
    key: str
    ends: tuple[float, float]

    def __post_init__(self) -> None:
        for value in self.ends:
            if not (is_number(plain(value, self.key)) and np.isfinite(value)):
                raise SceneError(f"vary.{self.key}", value, "a finite number")
        if self.ends[0] == self.ends[1]:
            raise SceneError(f"vary.{self.key}", self.ends[1], "another value than the first")
        whole = self.key in ("rod.links", "integrate.max_steps")
        made = [] if whole else [self.at(value) for value in self.ends]
        same = [one.structure.hash == self.search.scene.structure.hash for one in made]
        if not same or not all(same):
            allowed = "a number that leaves the structure of the equations as it is"
            raise SceneError("vary", self.key, allowed)
        first, last = (self.parameters(value) for value in self.ends)
        if np.array_equal(first, last):
            raise SceneError("vary", self.key, "a number that the equations depend on")

    @property
    def unit(self) -> float:
        """How far the ends are apart."""
        return abs(self.ends[1] - self.ends[0])

    def at(self, value: float) -> Scene:
        """The scene at a value, its loads as the search takes them. Raises SceneError."""
        scene = with_value(self.scene, self.key, float(value))
        return scene if self.search.forced else frozen(scene, scene.integrate.span[1])

    def parameters(self, value: float) -> Array:
        """p of the module. Raises AnalysisError where the scene refuses a value."""
        try:
            p: Array = self.search.model.parameters(**self.at(value).parameters)
        except SceneError as error:
            raise AnalysisError(str(error)) from None
        return p

    def forced(self, value: float) -> float:
        """The period of the loads [s], 0 where they do not change."""
        if not self.search.forced:
            return 0.0
        return load_period(self.at(value), self.search.model, self.parameters(value))


class Cycles(Problem):
    """u: states at the starts of segments, the rates over the first frequency; the logarithm of the
    period over the first, where the loads do not give it; the angle by which the rod turns [rad],
    where that is unknown; the number over its range."""

    def __init__(
        self,
        variation: Variation,
        quotient: Quotient,
        orbit: Orbit,
        value: float,
        turns: int = 1,
    ):
        """orbit: near the first cycle, at a value; turns: periods of the loads in one of it."""
        self.variation, self.quotient, self.first, self.turns = variation, quotient, orbit, turns
        self.count, size = orbit.x.shape
        rate = 2 * np.pi / orbit.period
        self.scale = np.where(np.arange(size) < quotient.positions, 1.0, rate)
        self.forced = bool(variation.search.forced)
        more = (not self.forced) + quotient.turns
        share = 1 / (self.count * size)
        self.weights = np.append(np.full(self.count * size, share), np.ones(more + 1))
        self.least = REST * float(np.ptp(orbit.x, axis=0).max())
        self._known: dict[bytes, tuple[Orbit, Linearised]] = {}
        self.look_from(orbit, value)

    def look_from(self, orbit: Orbit, value: float) -> None:
        """Let the phase be that of an orbit: first states differ from its own across the motion."""
        ways = self.shooting(value).directions(orbit) / self.scale
        self._ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        self._reference = orbit.x[0] / self.scale

    def shooting(self, value: float) -> Shooting:
        """The equations of a value."""
        search, p = self.variation.search, self.variation.parameters(value)
        return Shooting(Flow(search.model, p, self.quotient), self.forced)

    def value(self, u: Array) -> float:
        """The number of the scene."""
        return float(u[-1]) * self.variation.unit

    def packed(self, orbit: Orbit, value: float) -> Array:
        """u of an orbit."""
        parts = [(orbit.x / self.scale).ravel()]
        if not self.forced:
            parts.append(np.array([np.log(orbit.period / self.first.period)]))
        if self.quotient.turns:
            parts.append(np.array([orbit.angle]))
        return np.concatenate([*parts, [value / self.variation.unit]])

    def orbit(self, u: Array) -> Orbit:
        """The orbit of u."""
        states = self.count * len(self.scale)
        x = u[:states].reshape(self.count, -1) * self.scale
        more = u[states:-1].tolist()
        if self.forced:
            period = self.turns * self.variation.forced(self.value(u))
        else:
            period = self.first.period * float(np.exp(np.clip(more.pop(0), -50, 50)))
        angle = more.pop(0) if self.quotient.turns else self.first.angle
        return replace(self.first, x=x, period=period, angle=angle)

    def known(self, u: Array) -> tuple[Orbit, Linearised]:
        """The orbit of u and its segments' derivatives, kept for a while."""
        key = u.tobytes()
        if key not in self._known:
            while len(self._known) >= KEPT:
                self._known.pop(next(iter(self._known)))
            orbit = self.orbit(u)
            self._known[key] = orbit, self.shooting(self.value(u)).linearised(orbit)
        return self._known[key]

    def at(self, u: Array) -> tuple[Array, Array]:
        orbit, made = self.known(u)
        if np.ptp(orbit.x, axis=0).max() < self.least:
            raise AnalysisError("the cycles shrink to an equilibrium, in a Hopf point")
        by_value = self._by_value(u, orbit)
        states = self.count * len(self.scale)
        J, F = np.zeros((len(u) - 1, len(u))), np.zeros(len(u) - 1)
        columns = [one.copy() for one in made.B]
        if not self.forced:
            columns = [np.column_stack((one[:, 0] * orbit.period, one[:, 1:])) for one in columns]
        J[:states, :states], F[:states] = closing(made, self.scale)
        J[:states, states:-1] = np.vstack([one / self.scale[:, None] for one in columns])
        J[:states, -1] = np.concatenate([one / self.scale for one in by_value])
        for k, way in enumerate(self._ways):
            J[states + k, : len(way)] = way
            F[states + k] = way @ (orbit.x[0] / self.scale - self._reference)
        return F, J

    def _by_value(self, u: Array, orbit: Orbit) -> list[Array]:
        """Derivatives of the ends of segments by the number over its range, by differences."""
        step, value = NUDGE, self.value(u)
        ends = []
        for sign in (1.0, -1.0):
            there = value + sign * step * self.variation.unit
            shooting = self.shooting(there)
            made = orbit
            if self.forced:
                made = replace(orbit, period=self.turns * self.variation.forced(there))
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

    def multipliers(self, u: Array) -> Complex:
        """All of them, the largest first."""
        _, made = self.known(u)
        return Condensed.of(made.G).multipliers()

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


def closing(made: Linearised, scale: Array) -> tuple[Array, Array]:
    """Derivatives (m size, m size) by the states of the ends of segments less the states where the
    next begin, and these differences (m size,), all over a scale (size,)."""
    m, size = len(made.G), len(scale)
    J, F = np.zeros((m * size, m * size)), np.zeros(m * size)
    for i, (G, r) in enumerate(zip(made.G, made.r, strict=True)):
        rows, after = slice(i * size, (i + 1) * size), (i + 1) % m
        J[rows, i * size : (i + 1) * size] += G * scale / scale[:, None]
        J[rows, after * size : (after + 1) * size] -= np.eye(size)
        F[rows] = -r / scale
    return J, F


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
