"""Equations of a stability boundary in two numbers of a scene: an eigenvalue of the small motions
lies on the imaginary axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import null_space

from rodgen.analyse.attack_motions import attack_pencil
from rodgen.analyse.crossing import Border, Flutter, crossing_kind
from rodgen.analyse.curves.curve import ContinuationProblem
from rodgen.analyse.pencil import DensePencil, MatrixPencil
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import SteadyState, find_steady_state, pencil_about
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.system import System

TRIED = ((0.37, 1.7), (2.3, 0.4), (1.6, 2.9))
PLANE = 1e-11  # of their largest entries: what bilinear matrices may miss them by
STEP = 1e-4  # of a unit, of differences by a number where they are not
WEAK = 1e-9  # of the unit: damping that stands for the limit of none
BY_RATE = 0.1  # how much the logarithm of the frequency counts in the length along a boundary


class ParameterPlane:
    """Matrices of the linearised scene as functions of two of its numbers, a and b."""

    def __init__(self, system: System, keys: tuple[str, str], origin: Array):
        """system: with loads that do not depend on time; origin: a and b."""
        self.system, self.keys, self.origin = system, keys, origin
        self.base = SteadyRod.of(self._system(*origin))
        self.units = np.ones(2)
        self._near: SteadyState | None = None
        self._bilinear: tuple[MatrixPencil, ...] | None = None

    def _system(self, a: float, b: float) -> System:
        return self.system.at({self.keys[0]: float(a), self.keys[1]: float(b)})

    def steady_state(self, a: float, b: float) -> SteadyState:
        """Find the steady state at both values. Raises AnalysisError."""
        try:
            system = self._system(a, b)
        except InputError as error:
            raise AnalysisError(str(error)) from None
        if system.structure != self.base.system.structure:
            raise InputError(
                "vary", ",".join(self.keys), "numbers that leave the structure of the equations"
            )
        self._near = find_steady_state(replace(self.base, system=system), self._near)
        return self._near

    def evaluate(self, a: float, b: float) -> MatrixPencil:
        """Linearise the scene at both values, without interpolation."""
        state = self.steady_state(a, b)
        dense = pencil_about(state).to_dense()
        if self._basis is not None:
            dense = dense.project(self._basis)
        if self._by_attack:
            dense = attack_pencil(dense, state.airspeed)
        return MatrixPencil(*dense.parts)

    @cached_property
    def origin_state(self) -> SteadyState:
        """The steady state at the origin."""
        return self.steady_state(*self.origin)

    @cached_property
    def n_added_states(self) -> int:
        """Number of states with equations of first order, which are the last rows."""
        return self.base.n_added_states + 2 * self._by_attack

    @cached_property
    def _by_attack(self) -> bool:
        """Whether the rod in flight may turn together with its path."""
        return self.origin_state.turns_with_path

    @cached_property
    def _basis(self) -> Array | None:
        """Basis of the motions without the turning of the whole rod, if it can turn freely."""
        linear = pencil_about(self.origin_state)
        if isinstance(linear, DensePencil) or not self.origin_state.has_free_rotation:
            return None
        dense = linear.to_dense()
        return np.asarray(null_space((dense.S2 @ np.ones(dense.size))[None]))

    def interpolate_if_bilinear(self, units: Array) -> None:
        """Interpolate the matrices from now on if they are bilinear in a and b. units: distances
        from the origin at which this is tried."""
        self.units = units
        here = self.evaluate(*self.origin)

        def evaluate_at(x: float, y: float) -> MatrixPencil:
            return self.evaluate(*(self.origin + units * [x, y]))

        try:
            by_a, by_b = (evaluate_at(*way).add(here, -1.0) for way in ((1.0, 0.0), (0.0, 1.0)))
            both = evaluate_at(1.0, 1.0).add(here, -1.0).add(by_a, -1.0).add(by_b, -1.0)
            self._bilinear = here, by_a, by_b, both
            for x, y in TRIED:
                there, guess = evaluate_at(x, y), self.matrices(*(self.origin + units * [x, y]))
                sizes = (np.abs(part).max() for part in there.parts)
                for part, other, size in zip(there.parts, guess.parts, sizes, strict=True):
                    if np.abs(part - other).max() > PLANE * size:
                        self._bilinear = None
                        return
        except (AnalysisError, InputError):
            self._bilinear = None

    def matrices(self, a: float, b: float) -> MatrixPencil:
        """Matrices at both values."""
        if self._bilinear is None:
            return self.evaluate(a, b)
        x, y = (np.array([a, b]) - self.origin) / self.units
        here, by_a, by_b, both = self._bilinear
        return here.add(by_a, x).add(by_b, y).add(both, x * y)

    def slopes(self, a: float, b: float) -> tuple[MatrixPencil, MatrixPencil]:
        """Derivatives of the matrices by a and by b, times their units."""
        if self._bilinear is not None:
            x, y = (np.array([a, b]) - self.origin) / self.units
            _, by_a, by_b, both = self._bilinear
            return by_a.add(both, y), by_b.add(both, x)
        made = []
        for step in STEP * self.units * np.eye(2):
            up, down = (self.matrices(*(np.array([a, b]) + sign * step)) for sign in (1.0, -1.0))
            made.append(up.add(down, -1.0).multiply(0.5 / STEP))
        return made[0], made[1]


@dataclass(frozen=True)
class Scale:
    """Coordinate of a number: linear, or (curved) its arcsinh, logarithmic beyond a unit; damping:
    whether it scales damping alone, so that the boundary has a limit of vanishing damping."""

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
        """Derivative of the value by the coordinate, in units."""
        return float(np.cosh(x)) if self.curved else 1.0


class BoundaryProblem(ContinuationProblem):
    """Continuation problem of a stability boundary, with the equations of a crossing.

    u: of flutter log(omega / omega of the start), then both coordinates. The imaginary part of g is
    proportional to damping and is divided by the size of that: in the limit of vanishing damping it
    tells into which of the motions that are about to flutter damping puts energy.
    """

    def __init__(
        self, plane: ParameterPlane, scales: tuple[Scale, Scale], omega: float, damped: bool
    ):
        self.plane, self.scales, self.omega, self.damped = plane, scales, omega, damped
        self.weights = np.array([BY_RATE] * bool(omega) + [1.0, 1.0])
        self.kind = crossing_kind(bool(omega), damped)
        self._border: Border | None = None

    def pack(self, omega: float, a: float, b: float) -> Array:
        """Pack a frequency [rad/s] and both values into u."""
        places = [one.coordinate(value) for one, value in zip(self.scales, (a, b), strict=True)]
        return np.array(([np.log(omega / self.omega)] if self.omega else []) + places)

    def values(self, u: Array) -> tuple[float, float, float]:
        """Both values, and the frequency [Hz], at u."""
        a, b = (one.value(x) for one, x in zip(self.scales, u[-2:], strict=True))
        return a, b, self._angular_frequency(u) / (2 * np.pi)

    def value(self, u: Array) -> float:
        return self.values(u)[1]

    def _angular_frequency(self, u: Array) -> float:
        return float(self.omega * np.exp(u[0])) if self.omega else 0.0

    def adapt_to(self, u: Array) -> None:
        a, b, _ = self.values(u)
        here, rate = self.plane.matrices(*self._with_weak_damping(a, b)), self._angular_frequency(u)
        self._border = Border.of(self.kind.singular_matrix(here, rate), self._border)

    def _with_weak_damping(self, a: float, b: float) -> tuple[float, float]:
        """Both values, with no damping replaced by a very weak one, as its limit."""
        made = [
            one.unit * WEAK if one.damping and value == 0 else value
            for one, value in zip(self.scales, (a, b), strict=True)
        ]
        return made[0], made[1]

    def evaluate(self, u: Array) -> tuple[Array, Array]:
        if self._border is None:
            self.adapt_to(u)
        assert self._border is not None
        rate = self._angular_frequency(u)
        a, b = self._with_weak_damping(*self.values(u)[:2])
        here, slopes = self.plane.matrices(a, b), self.plane.slopes(a, b)
        made = self.kind.equations(here, slopes, self._border, rate)
        stretched = [one.slope(x) for one, x in zip(self.scales, u[-2:], strict=True)]
        F, J = made.residual, np.hstack((rate * made.by_omega, made.by_numbers * stretched))
        if not isinstance(self.kind, Flutter):
            return F, J
        size, by_size = self._relative_damping(here, slopes, u)
        F = np.array([F[0], F[1] / size])
        return F, np.array([J[0], J[1] / size - F[1] * by_size])

    def _relative_damping(
        self, here: MatrixPencil, slopes: tuple[MatrixPencil, MatrixPencil], u: Array
    ) -> tuple[float, Array]:
        """Relative size of the damping, and the derivative of its logarithm by u (3,)."""
        largest = np.unravel_index(np.abs(here.S1).argmax(), here.S1.shape)
        drag = float(here.S1[largest])
        size = self._angular_frequency(u) * abs(drag) / float(np.abs(here.S0).max())
        if not 0 < size < 1:
            return 1.0, np.zeros(3)
        by = [
            float(slope.S1[largest]) / drag * one.slope(x)
            for slope, one, x in zip(slopes, self.scales, u[-2:], strict=True)
        ]
        return size, np.array([1.0, *by])
