"""Equilibrium equations of a rod: residual, Jacobian and Newton step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.analyse.bordered import determinant_sign
from rodgen.analyse.massless import regular_pencil
from rodgen.analyse.modal import MOST_DENSE
from rodgen.analyse.pencil import SINGULAR, DensePencil, ImplicitBlocks, to_sparse
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.analyse.support_springs import SoftSprings
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

LOOSE = 1e-12  # of the largest effect of a shift of the rod: one that has none, but for rounding


@dataclass(frozen=True)
class JointForceBalance:
    """Equilibrium equations with joint forces as unknowns, so that a Newton step costs O(n): of a
    rod held at joint 0 alone, whose loads do not depend on the motion. residual (n_moving, 3)."""

    blocks: ImplicitBlocks
    bend: Array | float

    @property
    def residual(self) -> Array:
        """Residual, less the prescribed one (`bend`)."""
        return np.asarray(self.blocks.residual - self.bend)

    @property
    def rates(self) -> Array:
        """Residual as accelerations [rad/s^2]."""
        return self.blocks.residual

    def solve(self, right: Array, shift: float = 0.0) -> Unknowns:
        """Solve for the change of the unknowns that changes the residual by `right`; shift: 1/tau^2
        of a time step with inertia [1/s^2]."""
        z = self.blocks.solve(right, shift)
        return Unknowns(z[:, 0], z[:, 1:], np.zeros(0), np.zeros(0))

    @property
    def tail_moment(self) -> Array:
        """Residual of one in the last link's angle alone."""
        return np.pad([[1.0, 0.0, 0.0]], ((len(self.residual) - 1, 0), (0, 0)))

    @property
    def n_moving(self) -> int:
        return len(self.residual)

    def dense_pencil(self) -> DensePencil:
        """Matrices of small undamped motions about this state."""
        dense = self.blocks.to_dense()
        return DensePencil(dense.S0, np.zeros_like(dense.S0), dense.S2)

    def determinant_sign(self) -> int:
        """Sign of the determinant of the stiffness."""
        return determinant_sign(scipy.sparse.linalg.splu(to_sparse(self.blocks.statics)))


@dataclass(frozen=True)
class DenseBalance:
    """Equilibrium equations of generalised forces and rates of added states: of a rod with free
    joint 0, with supports, or whose loads depend on the motion. springs: those of its supports,
    with predicted forces."""

    rod: SteadyRod
    y: Array
    p: Array
    bend: Array | float
    springs: SoftSprings | None = None

    @cached_property
    def n_positions(self) -> int:
        return self.rod.n_base + self.rod.n_moving

    @property
    def _predicted_parameters(self) -> Array:
        """Parameters with which the supports pull by their predicted forces."""
        return self.p if self.springs is None else self.springs.p

    @cached_property
    def _all_forces(self) -> tuple[Array, Array]:
        """Generalised forces and rates of added states, and their derivatives by the state."""
        return self.rod.balance(self.y, self._predicted_parameters)

    @cached_property
    def _forces(self) -> tuple[Array, Array]:
        """Generalised forces and their derivatives in the frame that accelerates as loads push the
        rod where nothing holds it."""
        push = self.net_force() @ self.free_directions
        if not push.any():
            return self._all_forces
        return self.rod.balance(self.y, self._predicted_parameters, push / self._full_mass[0, 0])

    @cached_property
    def rates(self) -> Array:
        """Accelerations of joint 0 and of the angles, and rates of added states, under the
        predicted forces of supports."""
        half, (force, _) = self.n_positions, self._all_forces
        return np.concatenate((np.linalg.solve(self._slow_mass, force[:half]), force[half:]))

    @cached_property
    def _full_mass(self) -> Array:
        return np.asarray(self.rod.model.mass_matrix(self.y, self.p))

    @property
    def _slow_mass(self) -> Array:
        """Mass matrix of steps in pseudo-time: of links without mass that of an even rod."""
        if not self.rod.is_light:
            return self._full_mass
        return np.asarray(self.rod.model.mass_matrix(self.y, self.rod.with_even_mass(self.p)))

    @cached_property
    def _inertial_coupling(self) -> Array:
        """Generalised forces on all coordinates, by inertia, for a force on joint 0 in the
        directions in which nothing holds it (base + n_moving, base)."""
        moved = self._full_mass[:, : self.rod.n_base] @ self.free_directions.T
        return np.asarray(
            moved
            @ np.linalg.solve(self.free_directions @ moved[: self.rod.n_base], self.free_directions)
        )

    def _without_free(self, rows: Array) -> Array:
        """Rows (base + n_moving, ...) of generalised forces without what moves joint 0 where
        nothing holds it: the rest of the rod moves along."""
        if not len(self.free_directions):
            return rows
        return np.asarray(rows - self._inertial_coupling @ rows[: self.rod.n_base])

    def _rows_without_free(self, rows: Array) -> Array:
        """Remove what moves joint 0 where nothing holds it from the rows of all equations."""
        half = self.n_positions
        return np.concatenate((self._without_free(rows[:half]), rows[half:]))

    @cached_property
    def residual(self) -> Array:
        """Generalised forces and rates of added states, less the prescribed ones (`bend`)."""
        forced = self._rows_without_free(self._forces[0])
        if self.springs is not None:
            forced[: self.n_positions] += self.springs.force
        return np.asarray(forced - self.bend)

    @cached_property
    def _slope_at_rest(self) -> Array:
        """Derivatives of the forces by position, angles and added states."""
        return self._forces[1][:, self._at_rest]

    @property
    def _at_rest(self) -> NDArray[np.intp]:
        """Indices in y of position, angles and added states."""
        every = np.arange(len(self.y))
        return np.delete(every, every[self.n_positions : 2 * self.n_positions])

    @cached_property
    def residual_jacobian(self) -> Array:
        """Derivatives of the residual by position, angles and added states."""
        slope = self._rows_without_free(self._slope_at_rest)
        if self.springs is not None:
            slope[: self.n_positions, : self.n_positions] -= self.springs.stiffness
        return slope

    @cached_property
    def free_directions(self) -> Array:
        """Directions (k, 2) in which moving the whole rod changes no force."""
        base = self.rod.n_base
        _, sizes, ways = np.linalg.svd(self._all_forces[1][:, self._at_rest[:base]])
        return np.asarray(ways[sizes <= LOOSE * max(sizes, default=0.0)])

    @cached_property
    def basis(self) -> Array:
        """Basis of all changes but the free ones of joint 0, in columns."""
        base, size = self.rod.n_base, len(self.residual)
        if not len(self.free_directions):
            return np.eye(size)
        ways = np.linalg.svd(self.free_directions)[2][len(self.free_directions) :]
        basis = np.zeros((size, size - len(self.free_directions)))
        basis[:base, : len(ways)] = ways.T
        basis[base:, len(ways) :] = np.eye(size - base)
        return basis

    def _inertia(self, mass: Array) -> Array:
        """Mass matrix without motions of joint 0 that nothing holds, and one for added states."""
        states = np.eye(len(self.residual) - self.n_positions)
        return np.asarray(scipy.linalg.block_diag(self._without_free(mass), states))

    def solve(self, right: Array, shift: float = 0.0) -> Unknowns:
        """Solve for the change of the unknowns that changes the residual by `right`; shift: 1/tau^2
        of a time step with inertia [1/s^2]."""
        slope = self.residual_jacobian
        if shift:  # far from rest
            slope = slope - shift * self._inertia(self._slow_mass)
        matrix = slope @ self.basis
        try:
            if matrix.shape[0] == matrix.shape[1]:
                found = np.linalg.solve(matrix, right)
            else:
                found = np.linalg.lstsq(matrix, right, rcond=0.0)[0]
        except np.linalg.LinAlgError:
            raise AnalysisError(SINGULAR) from None
        if not np.isfinite(found).all():
            raise AnalysisError(SINGULAR)
        base, n_moving = self.rod.n_base, self.rod.n_moving
        change: Array = self.basis @ found
        position, phi, added = np.split(change, [base, base + n_moving])
        return Unknowns(phi, np.zeros((n_moving, 2)), position, added)

    @property
    def tail_moment(self) -> Array:
        """Residual of one in the last link's angle alone."""
        return np.asarray(np.eye(len(self.residual))[self.n_positions - 1])

    def net_force(self) -> Array:
        """Resultant of all loads along the free directions (k,) [N]."""
        return np.asarray(self.free_directions @ self._all_forces[0][: self.rod.n_base])

    def restoring_force(self) -> float:
        """Largest force that holds the rod when it is moved by its own length [N]."""
        base = self.rod.n_base
        return float(np.abs(self.residual_jacobian[:base, :base]).max()) * self.rod.scene.rod.length

    @property
    def n_moving(self) -> int:
        return self.rod.n_moving

    def dense_pencil(self, damped: bool = False) -> DensePencil:
        """Matrices of small motions about this state; derivatives by rates count only where loads
        depend on the motion, or if asked (damped)."""
        half, size = self.n_positions, len(self.residual)
        inertia, by_rate = np.zeros((2, size, size))
        inertia[:half, :half] = self._inertia(self._full_mass)[:half, :half]
        if self.rod.has_feedback or damped:
            by_rate[:, :half] = -self._rows_without_free(self._forces[1][:, half : 2 * half])
            by_rate[half:, half:] = np.eye(size - half)
        parts = -self.residual_jacobian, by_rate, inertia
        K, C, M = (self.basis.T @ part @ self.basis for part in parts)
        return DensePencil(K, C, M, added=size - half)

    def determinant_sign(self) -> int:
        """Sign of the determinant of the negative stiffness."""
        return int(np.linalg.slogdet(self.basis.T @ self.residual_jacobian @ self.basis)[0])


Balance = JointForceBalance | DenseBalance


def _regular(here: Balance) -> DensePencil:
    """Matrices of small motions with a regular mass matrix."""
    made = here.dense_pencil()
    light = isinstance(here, DenseBalance) and here.rod.is_light
    return regular_pencil(made).pencil if light else made


def square_of_growth(here: Balance) -> float:
    """Square of the fastest growth of an undamped motion [1/s^2], by the symmetric part of the
    stiffness; 0 where none grows, and for more than MOST_DENSE links."""
    if here.n_moving > MOST_DENSE:
        return 0.0
    small = _regular(here)
    own = slice(small.size - small.added)
    K, M = ((part + part.T)[own, own] / 2 for part in (small.S0, small.S2))
    if not np.isfinite(K).all():
        return 0.0
    return max(0.0, -float(scipy.linalg.eigvalsh(K, M, subset_by_index=[0, 0])[0]))


def stability_signature(here: Balance) -> int:
    """Number of unstable undamped motions; with added states, and for more than MOST_DENSE links,
    the sign of the determinant of the stiffness, which reveals odd changes only."""
    if here.n_moving > MOST_DENSE or (small := _regular(here)).added:
        return here.determinant_sign()
    return int((np.linalg.eigvals(np.linalg.solve(small.S2, -small.S0)).real > 0).sum())


def equilibrium_equations(
    rod: SteadyRod,
    at: Unknowns,
    p: Array,
    bend: Array | float = 0.0,
    springs: SoftSprings | None = None,
) -> Balance:
    """Set up the equilibrium equations at a state; bend: residual that is to remain instead of
    zero; springs: those of the supports, with predicted forces."""
    if not rod.has_joint_force_unknowns:
        return DenseBalance(rod, rod.state_at_rest(at), p, bend, springs)
    return JointForceBalance(ImplicitBlocks.at(rod, at, p), bend)


def free_directions(rod: SteadyRod, at: Unknowns, p: Array) -> Array:
    """Directions (k, 2) in which nothing holds a free rod and no load depends on its place."""
    return DenseBalance(rod, rod.state_at_rest(at), p, 0.0).free_directions
