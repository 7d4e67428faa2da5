"""Steady motions of rods that nothing holds in place: accelerated, turning, dragged, bent or not.

In a frame that moves and turns with the rod such a motion is an equilibrium: all angles turn at one
rate, and the velocity of joint 0 turns with them, or, where no load follows it, is whatever its
steady acceleration makes of it. Unknown are the angles, the velocity where a load follows it, and
the rate of turning where all directions are alike.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import root

from rodgen.analyse.branches.equilibria import Equilibria
from rodgen.analyse.eigenvalue_check import FullSpectrum
from rodgen.analyse.eigenvalues import Complex
from rodgen.analyse.pencil import Linear, MatrixPencil
from rodgen.analyse.scaled_load import RodRange
from rodgen.analyse.small_motions import SmallMotions
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import SteadyState, has_drag
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.simulate import simulate
from rodgen.system import System

AHEAD = np.array([[0.0, -1.0], [1.0, 0.0]])  # turns a vector by a right angle
TRIED = 0.7  # rad by which the whole rod is turned, to see whether directions are alike
ALIKE = 1e-9  # of the accelerations: a difference that is rounding
FOUND = 1e-3  # of what acts: what remains where a steady motion may be near
INITIAL, RUN = "initial", "run"


@dataclass(frozen=True)
class SteadyMotion(SteadyState):
    """A steady motion. velocity: of joint 0 (2,) [m/s], empty for a held rod; spin: rate at which
    all links turn [rad/s]."""

    velocity: Array
    spin: float

    @property
    def y(self) -> Array:
        """The state (states,)."""
        y = self.rod.state_at_rest(self.at)
        base, half = self.rod.n_base, self.rod.n_base + self.rod.n_moving
        y[half : half + base] = self.velocity
        y[half + base : 2 * half] = self.spin
        return y


class _Balance(NamedTuple):
    """Accelerations in the moving frame, of joint 0 and of the angles, and their derivatives by the
    angles, the velocity of joint 0, the rates of the angles, and their common rate."""

    rates: Array
    by_angle: Array
    by_velocity: Array
    by_rate: Array
    by_turning: Array

    @classmethod
    def of(cls, state: SteadyMotion) -> _Balance:
        rod, y, p = state.rod, state.y, state.p
        base, half = rod.n_base, rod.n_base + rod.n_moving
        rates = rod.accelerations(y, p)
        J = rod.model.jac(rod.t, y, p)[half : 2 * half]
        if not (np.isfinite(rates).all() and np.isfinite(J).all()):
            raise AnalysisError("the equations of steady motion are not finite")
        by_velocity, by_rate = J[:, half : half + base].copy(), J[:, half + base : 2 * half]
        by_turning = by_rate.sum(axis=1)
        if base:  # the velocity turns with the frame
            rates = rates.copy()
            rates[:base] -= state.spin * AHEAD @ state.velocity
            by_velocity[:base] -= state.spin * AHEAD
            by_turning[:base] -= AHEAD @ state.velocity
        return cls(rates, J[:, base:half], by_velocity, by_rate, by_turning)

    def angle_rows(self, base: int) -> _Balance:
        """Leave out the rows of joint 0, which accelerates freely."""
        return _Balance(*(part[base:] for part in self))


class SteadyMotions(Equilibria):
    """Curves of steady motions. u: angles [rad], scaled velocity of joint 0 if loads follow it,
    scaled rate of turning if all directions are alike, and the varied number over its unit."""

    def __init__(self, along: RodRange, start: SteadyMotion):
        super().__init__(along, start)
        rod = start.rod
        if rod.has_supports or rod.has_feedback:
            what = "absent: springs hold the rod, or its loads follow its motion"
            raise InputError("motion", rod.scene.name, what)
        self.base, self.n_moving = rod.n_base, rod.n_moving
        self.moves = bool(self.base) and has_drag(rod)
        self.turns = _is_rotation_invariant(start)
        usual = rod.scene.distribution.mean_stiffness / rod.scene.rod.length**3
        rate = np.sqrt(usual / rod.scene.mass)
        speed = float(np.linalg.norm(start.velocity)) or rod.scene.rod.length * rate
        self.columns = np.concatenate(
            (
                np.ones(self.n_moving),
                np.full(self.base * self.moves, speed),
                np.full(int(self.turns), abs(start.spin) or rate),
            )
        )
        angles = np.arange(len(self.columns)) < self.n_moving
        self.weights = np.append(np.where(angles, 1.0 / self.n_moving, 0.0), 1.0)
        self.mean = float(start.phi.mean())
        slope = np.abs(self._jacobian(self._balance(start))) @ self.columns
        self.rows = 1 / np.where(slope > 0, slope, 1.0)

    def _growth_counter(self, start: SteadyState, all_modes: bool) -> SmallMotions | None:
        return None

    # A point -------------------------------------------------------------------------------------

    def pack(self, state: SteadyState, value: float) -> Array:
        parts = [state.phi]
        if isinstance(state, SteadyMotion):
            parts += [state.velocity] * self.moves + [np.array([state.spin])] * self.turns
        z = np.concatenate(parts)
        z = np.append(z, np.zeros(len(self.columns) - len(z)))
        return np.append(z / self.columns, self.scale(value))

    @staticmethod
    def restore(rod: SteadyRod, p: Array, y: Array, force: Array) -> SteadyMotion:
        return motion_from_state(rod, p, y)

    def _make_state(self, rod: SteadyRod, p: Array, u: Array) -> SteadyMotion:
        z = u[:-1] * self.columns
        phi, velocity, turning = np.split(
            z, [self.n_moving, self.n_moving + self.base * self.moves]
        )
        if not self.moves:
            velocity = np.zeros(self.base)
        rate = float(turning[0]) if self.turns else 0.0
        return SteadyMotion(rod, rod.start_unknowns(phi), p, velocity, rate)

    def _motion(self, u: Array) -> SteadyMotion:
        state = self.steady_state(u)
        assert isinstance(state, SteadyMotion)
        return state

    def _balance(self, state: SteadyMotion) -> _Balance:
        made = _Balance.of(state)
        return made if self.moves else made.angle_rows(self.base)

    def _jacobian(self, made: _Balance) -> Array:
        """Derivatives of the accelerations, and of the mean angle, by the unknowns."""
        parts = [made.by_angle]
        parts += [made.by_velocity] * self.moves + [made.by_turning[:, None]] * self.turns
        slope = np.column_stack(parts)
        if self.turns:
            slope = np.vstack((slope, np.arange(slope.shape[1]) < self.n_moving))
        return np.asarray(slope)

    def evaluate(self, u: Array) -> tuple[Array, Array]:
        here = self._motion(u)
        made = self._balance(here)
        F = made.rates
        by_value = np.zeros(len(F))
        for p, share in self.along.numbers.difference_points(self.value(u)):
            beside = self._balance(SteadyMotion(here.rod, here.at, p, here.velocity, here.spin))
            by_value += share * beside.rates
        if self.turns:  # of all that are turned against each other, one
            F = np.append(F, (here.phi - self.mean).sum())
            by_value = np.append(by_value, 0.0)
        J = self.rows[:, None] * np.column_stack((self._jacobian(made) * self.columns, by_value))
        return self.rows * F, J

    def solve_near(self, guess: SteadyMotion, value: float) -> Array:
        """Find u of a steady motion at a value, near a guess, by MINPACK's least squares. Raises
        AnalysisError."""
        u = self.pack(guess, value)

        def residual_and_jacobian(z: Array) -> tuple[Array, Array]:
            F, J = self.evaluate(np.append(z, u[-1]))
            return F, J[:, :-1]

        found = root(
            residual_and_jacobian,
            u[:-1],
            jac=True,
            method="lm",
            options={"xtol": 1e-14, "ftol": 1e-14},
        )
        left = float(np.abs(found.fun).max())
        if not left < FOUND:
            raise AnalysisError(f"no steady motion is near: {left:.1e} of what acts remains")
        return np.append(found.x, u[-1])

    # Stability -----------------------------------------------------------------------------------

    def _matrix(self, u: Array) -> Array:
        """Matrix of small motions in the moving frame. Where directions are alike, the zero
        eigenvalue of turning the whole rod is replaced by a decay as fast as its largest entry."""
        state = self._motion(u)
        if state.has_kink and state.is_straight:
            raise AnalysisError("external damping has no linear part along the straight rod")
        made, size = self._balance(state), self.n_moving
        moves = self.base * self.moves
        joint, links = slice(size, size + moves), slice(size + moves, 2 * size + moves)
        A = np.zeros((2 * size + moves, 2 * size + moves))
        A[:size, links] = np.eye(size)
        parts = (made.by_angle, made.by_velocity[:, :moves], made.by_rate)
        for columns, part in zip((slice(size), joint, links), parts, strict=True):
            A[size:, columns] = part
        if self.turns:
            carried = AHEAD @ state.velocity if moves else np.zeros(0)
            turned = np.concatenate((np.ones(size), carried, np.zeros(size)))
            A -= np.abs(A).max() / (turned @ turned) * np.outer(turned, turned)
        return A

    def count_unstable(self, u: Array) -> int | None:
        try:
            return int(FullSpectrum.of_matrix(self._matrix(u)).n_growing)
        except AnalysisError as error:
            self.why_unknown = self.why_unknown or str(error)
            return None

    def growing_eigenvalues(self, u: Array) -> Complex:
        found = FullSpectrum.of_matrix(self._matrix(u))
        return found.s[found.growth > 0]

    def linearise(self, u: Array, s: complex) -> Linear:
        A, size = self._matrix(u), self.n_moving
        if self.moves:
            return MatrixPencil(A, -np.eye(len(A)), np.zeros_like(A))
        # Of second order, in which frequencies that meet without damping are seen to.
        K, C = -A[size:, :size], -A[size:, size:]
        if self.turns and not s:
            K = K + np.abs(K).max() / size
        return MatrixPencil(K, C, np.eye(size))


def motion_from_state(rod: SteadyRod, p: Array, y: Array) -> SteadyMotion:
    """Make the steady motion next to a state (states,)."""
    base, half = rod.n_base, rod.n_base + rod.n_moving
    rates = y[half + base : 2 * half]
    at = rod.start_unknowns(y[base:half])
    return SteadyMotion(rod, at, p, y[half : half + base], float(rates.mean()))


def _is_rotation_invariant(state: SteadyMotion) -> bool:
    """Whether all directions are alike: the accelerations turn with the rod as a whole."""
    rod, c, s = state.rod, np.cos(TRIED), np.sin(TRIED)
    if rod.is_clamped:
        return False
    turned = SteadyMotion(
        rod,
        state.at._replace(phi=state.phi + TRIED),
        state.p,
        np.array([[c, -s], [s, c]]) @ state.velocity if rod.n_base else state.velocity,
        state.spin,
    )
    made = [_Balance.of(one) for one in (state, turned)]
    angles = [one.angle_rows(rod.n_base).rates for one in made]
    here = made[0]
    sizes = np.abs(here.by_angle).max() + np.abs(here.by_turning * state.spin).max()
    least = ALIKE * sizes
    same = bool(np.abs(angles[1] - angles[0]).max() <= least)
    if not (same and rod.n_base and has_drag(rod)):
        return same
    before, after = (one.rates[:2] for one in made)
    return bool(np.abs(after - np.array([[c, -s], [s, c]]) @ before).max() <= least)


def motion_problem(
    system: System, rod: SteadyRod, along: RodRange, where: str, value: float
) -> SteadyMotions:
    """Set up the problem about the steady motion near a system's initial state ("initial"), or to
    which its run over the span leads ("run"). Raises InputError, AnalysisError."""
    ways: dict[str, Callable[[], Array]] = {
        INITIAL: lambda: system.y0,
        RUN: lambda: simulate(system).y[-1],
    }
    if where not in ways:
        raise InputError("motion", where, " or ".join(map(repr, ways)))
    guess = motion_from_state(rod, rod.system.p, ways[where]())
    problem = SteadyMotions(along, guess)
    return SteadyMotions(along, problem._motion(problem.solve_near(guess, value)))
