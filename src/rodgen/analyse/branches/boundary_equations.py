"""Equations of a boundary of stability in two numbers of a scene: where an eigenvalue of the small
motions lies on the imaginary axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import null_space

from rodgen.analyse.crossing import Border, Flutter, kind_of
from rodgen.analyse.curves.curve import Problem
from rodgen.analyse.pencil import Dense, Parts
from rodgen.analyse.steady import Steady, linearised, steady
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.system import System

TRIED = ((0.37, 1.7), (2.3, 0.4), (1.6, 2.9))
PLANE = 1e-11  # of their largest entries: what bilinear matrices may miss them by
STEP = 1e-4  # of a unit, of differences by a number where they are not
WEAK = 1e-9  # of the unit: damping that stands for the limit of none
BY_RATE = 0.1  # how much the logarithm of the frequency counts in the length along a boundary


class Plane:
    """The linearised scene over two of its numbers."""

    def __init__(self, system: System, keys: tuple[str, str], origin: Array):
        """system: with loads that do not change."""
        self.system, self.keys, self.origin = system, keys, origin
        self.base = SteadyRod.of(self._at(*origin))
        self.units = np.ones(2)
        self._near: Steady | None = None
        self._bilinear: tuple[Parts, ...] | None = None

    def _at(self, a: float, b: float) -> System:
        return self.system.at({self.keys[0]: float(a), self.keys[1]: float(b)})

    def steady(self, a: float, b: float) -> Steady:
        """The steady state at both values. Raises AnalysisError."""
        try:
            system = self._at(a, b)
        except InputError as error:
            raise AnalysisError(str(error)) from None
        if system.structure != self.base.system.structure:
            raise InputError(
                "vary", ",".join(self.keys), "numbers that leave the structure of the equations"
            )
        self._near = steady(replace(self.base, system=system), self._near)
        return self._near

    def evaluated(self, a: float, b: float) -> Parts:
        """The matrices from the linearised equations themselves."""
        dense = linearised(self.steady(a, b)).reduced()
        if self._basis is not None:
            dense = dense.on(self._basis)
        return Parts(*dense.parts)

    @cached_property
    def first(self) -> Steady:
        """The steady state at the origin."""
        return self.steady(*self.origin)

    @cached_property
    def added(self) -> int:
        """States of first order, the last rows."""
        return len(self.base.system.added)

    @cached_property
    def _basis(self) -> Array | None:
        """Motions without the turning of the whole rod, where it is free to turn."""
        linear = linearised(self.first)
        if isinstance(linear, Dense) or not self.first.turns_freely:
            return None
        dense = linear.reduced()
        return np.asarray(null_space((dense.M @ np.ones(len(dense.M)))[None]))

    def made_fast(self, units: Array) -> None:
        """Find out whether all matrices are linear in either number, from so many units away from
        the origin."""
        self.units = units
        here = self.evaluated(*self.origin)

        def at(x: float, y: float) -> Parts:
            return self.evaluated(*(self.origin + units * [x, y]))

        try:
            by_a, by_b = (at(*way).plus(here, -1.0) for way in ((1.0, 0.0), (0.0, 1.0)))
            both = at(1.0, 1.0).plus(here, -1.0).plus(by_a, -1.0).plus(by_b, -1.0)
            self._bilinear = here, by_a, by_b, both
            for x, y in TRIED:
                there, guess = at(x, y), self.at(*(self.origin + units * [x, y]))
                sizes = (np.abs(part).max() for part in there.parts)
                for part, other, size in zip(there.parts, guess.parts, sizes, strict=True):
                    if np.abs(part - other).max() > PLANE * size:
                        self._bilinear = None
                        return
        except (AnalysisError, InputError):
            self._bilinear = None

    def at(self, a: float, b: float) -> Parts:
        """The matrices at both values."""
        if self._bilinear is None:
            return self.evaluated(a, b)
        x, y = (np.array([a, b]) - self.origin) / self.units
        here, by_a, by_b, both = self._bilinear
        return here.plus(by_a, x).plus(by_b, y).plus(both, x * y)

    def slopes(self, a: float, b: float) -> tuple[Parts, Parts]:
        """Derivatives of the matrices by both, times their units."""
        if self._bilinear is not None:
            x, y = (np.array([a, b]) - self.origin) / self.units
            _, by_a, by_b, both = self._bilinear
            return by_a.plus(both, y), by_b.plus(both, x)
        made = []
        for step in STEP * self.units * np.eye(2):
            up, down = (self.at(*(np.array([a, b]) + sign * step)) for sign in (1.0, -1.0))
            made.append(up.plus(down, -1.0).times(0.5 / STEP))
        return made[0], made[1]


@dataclass(frozen=True)
class Scale:
    """A coordinate for a number: linear, or by its logarithm beyond a unit, so that little and much
    are on one curve; damping: whether it is nothing else, so that there is a limit of none."""

    unit: float
    curved: bool = True
    damping: bool = False

    def coordinate(self, value: float) -> float:
        """The coordinate of a value."""
        return float(np.arcsinh(value / self.unit) if self.curved else value / self.unit)

    def value(self, x: float) -> float:
        """The value at a coordinate."""
        return float(self.unit * (np.sinh(x) if self.curved else x))

    def slope(self, x: float) -> float:
        """How many units the value changes by the coordinate."""
        return float(np.cosh(x)) if self.curved else 1.0


class Boundary(Problem):
    """u: the logarithm of omega over that of the start, of flutter, and both coordinates.

    The equations are those of a crossing. The imaginary part of g goes with damping and is taken
    over its size: in the limit of none it says in which of the motions that are about to flutter it
    puts energy.
    """

    def __init__(self, plane: Plane, scales: tuple[Scale, Scale], omega: float, damped: bool):
        self.plane, self.scales, self.omega, self.damped = plane, scales, omega, damped
        self.weights = np.array([BY_RATE] * bool(omega) + [1.0, 1.0])
        self.kind = kind_of(bool(omega), damped)
        self._border: Border | None = None

    def packed(self, omega: float, a: float, b: float) -> Array:
        """u of a frequency [rad/s] and both values."""
        places = [one.coordinate(value) for one, value in zip(self.scales, (a, b), strict=True)]
        return np.array(([np.log(omega / self.omega)] if self.omega else []) + places)

    def values(self, u: Array) -> tuple[float, float, float]:
        """Both values, and the frequency [Hz]."""
        a, b = (one.value(x) for one, x in zip(self.scales, u[-2:], strict=True))
        return a, b, self._rate(u) / (2 * np.pi)

    def value(self, u: Array) -> float:
        return self.values(u)[1]

    def _rate(self, u: Array) -> float:
        return float(self.omega * np.exp(u[0])) if self.omega else 0.0

    def bordered(self, u: Array) -> None:
        """Take the border that belongs to a point."""
        a, b, _ = self.values(u)
        here, rate = self.plane.at(*self._damping(a, b)), self._rate(u)
        self._border = Border.of(self.kind.singular(here, rate), self._border)

    def _damping(self, a: float, b: float) -> tuple[float, float]:
        """Both values, the least damping for none, which its limit is taken of."""
        made = [
            one.unit * WEAK if one.damping and value == 0 else value
            for one, value in zip(self.scales, (a, b), strict=True)
        ]
        return made[0], made[1]

    def at(self, u: Array) -> tuple[Array, Array]:
        if self._border is None:
            self.bordered(u)
        assert self._border is not None
        rate = self._rate(u)
        a, b = self._damping(*self.values(u)[:2])
        here, slopes = self.plane.at(a, b), self.plane.slopes(a, b)
        made = self.kind.equations(here, slopes, self._border, rate)
        stretched = [one.slope(x) for one, x in zip(self.scales, u[-2:], strict=True)]
        F, J = made.residual, np.hstack((rate * made.by_omega, made.by_numbers * stretched))
        if not isinstance(self.kind, Flutter):
            return F, J
        size, by_size = self._weakness(here, slopes, u)
        F = np.array([F[0], F[1] / size])
        return F, np.array([J[0], J[1] / size - F[1] * by_size])

    def _weakness(self, here: Parts, slopes: tuple[Parts, Parts], u: Array) -> tuple[float, Array]:
        """How small damping is, and the derivative of its logarithm by u."""
        largest = np.unravel_index(np.abs(here.S1).argmax(), here.S1.shape)
        drag = float(here.S1[largest])
        size = self._rate(u) * abs(drag) / float(np.abs(here.S0).max())
        if not 0 < size < 1:
            return 1.0, np.zeros(3)
        by = [
            float(slope.S1[largest]) / drag * one.slope(x)
            for slope, one, x in zip(slopes, self.scales, u[-2:], strict=True)
        ]
        return size, np.array([1.0, *by])
