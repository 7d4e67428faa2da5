"""Continuation problems of equilibria: held chains, whole rods, straight flight."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csc_array, diags_array, hstack

from rodgen.analyse.bordered import Matrix
from rodgen.analyse.branches.equilibria import Equilibria
from rodgen.analyse.equilibrium_equations import DenseBalance
from rodgen.analyse.pencil import ImplicitBlocks, to_sparse
from rodgen.analyse.scaled_load import RodRange
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.analyse.steady_state import SteadyState, unloaded_state
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

NEUTRAL = 1e-9  # of the stiffness: none
SMALL = 90  # unknowns up to which full matrices take less time than sparse ones


class HeldRodEquilibria(Equilibria):
    """Equilibria of a rod that is held at joint 0 alone, without feedback or added states, in O(n).
    Unknown are its angles and the forces in its joints."""

    def __init__(self, along: RodRange, start: SteadyState, all_modes: bool = False):
        super().__init__(along, start, all_modes)
        scene, n_moving = start.rod.scene, start.rod.n_moving
        soft = scene.distribution.mean_stiffness / scene.rod.length**2 * scene.rod.links
        usual = max(
            soft / max(scene.mass, 1e-300), float(np.abs(start.joint_forces).max(initial=0.0))
        )
        self.force = usual or 1.0
        self.columns = np.tile([1.0, self.force, self.force], n_moving)
        self.weights = np.append(np.tile([1.0 / n_moving, 0.0, 0.0], n_moving), 1.0)
        sizes = abs(to_sparse(start.implicit_blocks.statics)) @ self.columns
        self.rows = 1 / np.where(sizes > 0, sizes, 1.0)
        self._left, self._right = diags_array(self.rows), diags_array(self.columns)

    def pack(self, state: SteadyState, value: float) -> Array:
        z = np.column_stack((state.phi, state.joint_forces)).ravel() / self.columns
        return np.append(z, self.scale(value))

    def _make_state(self, rod: SteadyRod, p: Array, u: Array) -> SteadyState:
        z = (u[:-1] * self.columns).reshape(-1, 3)
        at = rod.start_unknowns(z[:, 0])._replace(force=z[:, 1:])
        return SteadyState(rod, at, p)

    def evaluate(self, u: Array) -> tuple[Array, Matrix]:
        here = self.steady_state(u)
        rod, blocks = here.rod, here.implicit_blocks
        by_value = np.zeros(blocks.residual.size)
        for p, share in self.along.numbers.difference_points(self.value(u)):
            by_value += share * ImplicitBlocks.at(rod, here.at, p).residual.ravel()
        by_value *= self.rows
        F = self.rows * blocks.residual.ravel()
        J = csc_array(
            hstack([self._left @ to_sparse(blocks.statics) @ self._right, by_value[:, None]])
        )
        return F, J.toarray() if len(u) <= SMALL else J


class RodEquilibria(Equilibria):
    """Equilibria of a rod that springs hold, at a free joint 0 or beside it, or with feedback or
    added states.
    Unknown are the position of joint 0, where it counts, the angles, and added states."""

    def __init__(self, along: RodRange, start: SteadyState, all_modes: bool = False):
        super().__init__(along, start, all_modes)
        rod = start.rod
        here = DenseBalance(rod, rod.state_at_rest(start.at), start.p, 0.0)
        self.basis, self.origin = self._remove_turning(here.basis), self._coordinates(start.at)
        sizes = np.ones(len(self.basis))
        sizes[: rod.n_base] = rod.scene.rod.length
        added = slice(rod.n_base + rod.n_moving, None)
        sizes[added] = np.maximum(1.0, np.abs(start.at.added))
        self.columns = np.abs(self.basis).T @ sizes
        angles = np.zeros(len(self.basis))
        angles[: rod.n_base + rod.n_moving] = 1.0 / rod.n_moving
        self.weights = np.append(np.abs(self.basis).T @ angles, 1.0)
        slope = np.abs(self.basis.T @ here.residual_jacobian @ self.basis) @ self.columns
        self.rows = 1 / np.where(slope > 0, slope, 1.0)

    def _remove_turning(self, basis: Array) -> Array:
        """Remove the turning of the whole rod from a basis if it has no effect under any load."""
        start, ways = self.start, np.zeros(len(basis))
        ways[start.rod.n_base : start.rod.n_base + start.rod.n_moving] = 1.0
        turning = basis.T @ ways
        for value in self.along.numbers.bounds:
            rod, p = self.along.rod(value), self.along.numbers.parameters(value)
            slope = DenseBalance(rod, rod.state_at_rest(start.at), p, 0.0).residual_jacobian
            reduced = basis.T @ slope @ basis
            if np.abs(reduced @ turning).max() > NEUTRAL * np.abs(reduced).max():
                return basis
        return np.asarray(basis @ null_space(turning[None]))

    @staticmethod
    def _coordinates(at: Unknowns) -> Array:
        return np.concatenate((at.position, at.phi, at.added))

    def pack(self, state: SteadyState, value: float) -> Array:
        z = self.basis.T @ (self._coordinates(state.at) - self.origin) / self.columns
        return np.append(z, self.scale(value))

    def _make_state(self, rod: SteadyRod, p: Array, u: Array) -> SteadyState:
        x = self.origin + self.basis @ (self.columns * u[:-1])
        position, phi, added = np.split(x, [rod.n_base, rod.n_base + rod.n_moving])
        at = Unknowns(phi, np.zeros((rod.n_moving, 2)), position, added)
        return SteadyState(rod, at, p)

    def evaluate(self, u: Array) -> tuple[Array, Matrix]:
        here = self.steady_state(u)
        rod, y = here.rod, here.rod.state_at_rest(here.at)
        balance = DenseBalance(rod, y, here.p, 0.0)
        by_value = np.zeros(len(self.basis))
        for p, share in self.along.numbers.difference_points(self.value(u)):
            by_value += share * DenseBalance(rod, y, p, 0.0).residual
        reduced = self.basis.T @ balance.residual_jacobian @ self.basis
        J = self.rows[:, None] * np.column_stack((reduced * self.columns, self.basis.T @ by_value))
        return self.rows * (self.basis.T @ balance.residual), J


class StraightFlight(Equilibria):
    """Steady states of a rod that stays straight: a free one that nothing holds, accelerating, or a
    pinned one that may turn freely under all loads of the range."""

    def __init__(self, along: RodRange, start: SteadyState, all_modes: bool = False):
        super().__init__(along, start, all_modes)
        self.weights = np.ones(1)

    def pack(self, state: SteadyState, value: float) -> Array:
        return np.array([self.scale(value)])

    def _make_state(self, rod: SteadyRod, p: Array, u: Array) -> SteadyState:
        state, turning = unloaded_state(rod, p)
        if state is None:
            raise AnalysisError(f"the rod begins to turn with {turning:.3g} rad/s^2")
        return state

    def evaluate(self, u: Array) -> tuple[Array, Matrix]:
        self.steady_state(u)
        return np.zeros(0), np.zeros((0, 1))


def equilibrium_problem(along: RodRange, start: SteadyState, all_modes: bool = False) -> Equilibria:
    """Choose the continuation problem for the curve of a steady state."""
    rod = start.rod
    if rod.n_base and not (rod.has_supports or rod.has_feedback):
        return StraightFlight(along, start, all_modes)
    if rod.has_joint_force_unknowns and all(
        _turns_freely(along, start, end) for end in along.numbers.bounds
    ):
        return StraightFlight(along, start, all_modes)
    if not rod.has_joint_force_unknowns:
        return RodEquilibria(along, start, all_modes)
    return HeldRodEquilibria(along, start, all_modes)


def _turns_freely(along: RodRange, start: SteadyState, value: float) -> bool:
    """Whether the whole rod turns freely about a steady state and about the straight one at a
    value."""
    if not start.has_free_rotation:
        return False
    state, _ = unloaded_state(along.rod(value), along.numbers.parameters(value))
    return state is not None and state.has_free_rotation
