"""Equations of rest: what is unknown, what is not in balance yet, and Newton's correction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigvalsh
from scipy.sparse.linalg import splu

from rodgen.analyse.bordered import sign_of
from rodgen.analyse.modal import MOST_DENSE
from rodgen.analyse.pencil import SINGULAR, Cells, Dense, sparse
from rodgen.analyse.springs import Softened
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

NUDGE = 1e-8  # rad, of differences of the mass matrix: Newton's method corrects their error
LOOSE = 1e-12  # of the largest effect of a shift of the rod: one that has none, but for rounding


@dataclass(frozen=True)
class ChainBalance:
    """Of a rod that is held at joint 0 alone and whose loads follow no motion: joint forces are
    unknowns, so that a correction costs O(n). residual (cells, 3)."""

    cells: Cells
    bend: Array | float

    @property
    def residual(self) -> Array:
        """What is not in balance, less what is to remain."""
        return np.asarray(self.cells.residual - self.bend)

    @property
    def rates(self) -> Array:
        """What is not in balance, as accelerations [rad/s^2]."""
        return self.cells.residual

    def solved(self, right: Array, shift: float = 0.0) -> Unknowns:
        """What changes the residual by so much; shift: 1/tau^2 of a step in time with inertia
        [1/s^2]."""
        z = self.cells.solved(right, shift)
        return Unknowns(z[:, 0], z[:, 1:], np.zeros(0), np.zeros(0))

    @property
    def tail_moment(self) -> Array:
        """A residual of the last link's angle alone."""
        return np.pad([[1.0, 0.0, 0.0]], ((len(self.residual) - 1, 0), (0, 0)))

    def dense(self) -> Dense:
        """The matrices of small motions about it, without damping."""
        dense = self.cells.reduced()
        return Dense(dense.K, np.zeros_like(dense.K), dense.M)

    def falls(self) -> float:
        """Square of the fastest growth of a motion without damping [1/s^2]; 0 where none grows, and
        beyond MOST_DENSE links."""
        if len(self.residual) > MOST_DENSE:
            return 0.0
        return _fastest(self.cells.reduced())

    def signature(self) -> int:
        """How many motions are unstable without damping; beyond MOST_DENSE links the sign of the
        determinant of the stiffness, which tells odd changes alone."""
        if len(self.residual) <= MOST_DENSE:
            dense = self.cells.reduced()
            return int((np.linalg.eigvals(np.linalg.solve(dense.M, -dense.K)).real > 0).sum())
        return sign_of(splu(sparse(self.cells.statics)))


@dataclass(frozen=True)
class WholeBalance:
    """Of a rod whose joint 0 is free, that has supports, or whose loads follow the motion:
    generalised forces and the rates of added states are to vanish, by the Jacobian of the module;
    springs: of its supports, with the forces that were foretold."""

    rod: SteadyRod
    y: Array
    p: Array
    bend: Array | float
    springs: Softened | None = None

    @cached_property
    def _half(self) -> int:
        return self.rod.base + self.rod.cells

    @property
    def _foretold(self) -> Array:
        """p with which supports pull as foretold."""
        return self.p if self.springs is None else self.springs.p

    @cached_property
    def rates(self) -> Array:
        """Accelerations of joint 0 and of the angles, rates of added states, with the forces of
        supports that were foretold."""
        rates = self.rod.model.rhs(self.rod.t, self.y, self._foretold)[self._half :]
        if not np.isfinite(rates).all():
            raise AnalysisError("the equations of rest are not finite")
        return np.asarray(rates)

    @cached_property
    def _whole_mass(self) -> Array:
        return np.asarray(self.rod.model.mass_matrix(self.y, self.p))

    @cached_property
    def _carried(self) -> Array:
        """How forces on joint 0 act on all coordinates of a rod that moves as it may where nothing
        holds it (base + cells, base)."""
        moved = self._whole_mass[:, : self.rod.base] @ self.free.T
        return np.asarray(moved @ np.linalg.solve(self.free @ moved[: self.rod.base], self.free))

    @cached_property
    def _mass(self) -> Array:
        """The inertia of all other motions of such a rod."""
        whole = self._whole_mass
        return whole - self._carried @ whole[: self.rod.base] if len(self.free) else whole

    def _forced(self, rates: Array) -> Array:
        """Rows of accelerations as generalised forces."""
        half = self._half
        return np.concatenate((self._mass @ rates[:half], rates[half:]))

    @cached_property
    def residual(self) -> Array:
        """Generalised forces and rates of added states, less what is to remain."""
        forced = self._forced(self.rates)
        if self.springs is not None:
            forced[: self._half] += self.springs.force
        return np.asarray(forced - self.bend)

    @cached_property
    def _jacobian(self) -> Array:
        return np.asarray(self.rod.model.jac(self.rod.t, self.y, self._foretold)[self._half :])

    @cached_property
    def _by_place(self) -> Array:
        """Derivatives of the rates by position, angles and added states."""
        at_rest = np.r_[: self._half, 2 * self._half : len(self.y)]
        return self._jacobian[:, at_rest]

    @cached_property
    def slope(self) -> Array:
        """Derivatives of the residual by position, angles and added states."""
        slope: Array = self._forced(self._by_place)
        if self.springs is not None:
            slope[: self._half, : self._half] -= self.springs.stiffness
        # Else what follows the mass vanishes with the rates.
        return slope + self._by_mass if np.any(self.bend) else slope

    @cached_property
    def _by_mass(self) -> Array:
        """Derivatives of generalised forces, as far as the mass matrix follows the angles.

        Each of its entries follows how two links are turned from each other, or from joint 0, which
        does not turn: one difference has them all, of links that are turned by one more nudge each.
        """
        base, cells, half = self.rod.base, self.rod.cells, self._half
        turned = NUDGE * np.append(np.zeros(base), 1.0 + np.arange(cells))
        apart, y = turned[:, None] - turned, self.y.copy()
        y[:half] += turned
        change = self.rod.model.mass_matrix(y, self.p) - self._whole_mass
        by_turn = np.divide(change, apart, out=np.zeros_like(change), where=apart != 0)
        rates = self.rates[:half]
        rates = rates - np.append(self._carried.T @ rates, np.zeros(cells))
        felt = (np.diag(by_turn @ rates) - by_turn * rates)[:, base:]
        slope = np.zeros((len(self.rates), len(self.rates)))
        slope[:half, base:half] = felt - self._carried @ felt[:base]
        return slope

    @cached_property
    def free(self) -> Array:
        """Directions (k, 2) in which joint 0 moves the whole rod without any effect."""
        base = self.rod.base
        _, sizes, ways = np.linalg.svd(self._by_place[:, :base])
        return np.asarray(ways[sizes <= LOOSE * max(sizes, default=0.0)])

    @cached_property
    def basis(self) -> Array:
        """Columns of changes that have an effect."""
        base, size = self.rod.base, len(self.residual)
        if not len(self.free):
            return np.eye(size)
        ways = np.linalg.svd(self.free)[2][len(self.free) :]
        basis = np.zeros((size, size - len(self.free)))
        basis[:base, : len(ways)] = ways.T
        basis[base:, len(ways) :] = np.eye(size - base)
        return basis

    def solved(self, right: Array, shift: float = 0.0) -> Unknowns:
        """What changes the residual by so much; shift: 1/tau^2 of a step in time with inertia
        [1/s^2]."""
        slope = self.slope
        if shift:  # far from rest
            slope = slope if np.any(self.bend) else slope + self._by_mass
            slope = slope - shift * self._forced(np.eye(len(slope)))
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
        base, cells = self.rod.base, self.rod.cells
        change: Array = self.basis @ found
        position, phi, added = np.split(change, [base, base + cells])
        return Unknowns(phi, np.zeros((cells, 2)), position, added)

    @property
    def tail_moment(self) -> Array:
        """A residual of the last link's angle alone."""
        return np.asarray(np.eye(len(self.residual))[self._half - 1])

    def push(self) -> Array:
        """Force of all loads on the whole rod in the directions that are free (k,) [N]."""
        mass = self.rod.model.mass_matrix(self.y, self.p)[: self.rod.base]
        return np.asarray(self.free @ (mass @ self.rates[: self._half]))

    def hold(self) -> float:
        """How the whole rod is held against being moved by its own length [N]."""
        base = self.rod.base
        return float(np.abs(self.slope[:base, :base]).max()) * self.rod.scene.rod.length

    def dense(self) -> Dense:
        """The matrices of small motions about it; what follows rates counts only where loads follow
        the motion."""
        half, size = self._half, len(self.rates)
        inertia, by_rate = np.zeros((2, size, size))
        inertia[:half, :half] = self._mass
        if self.rod.steered:
            by_rate[:, :half] = -self._forced(self._jacobian[:, half : 2 * half])
            by_rate[half:, half:] = np.eye(size - half)
        parts = -self.slope, by_rate, inertia
        K, C, M = (self.basis.T @ part @ self.basis for part in parts)
        return Dense(K, C, M, size - half)

    def falls(self) -> float:
        """Square of the fastest growth of a motion without damping [1/s^2], as of ChainBalance."""
        if self.rod.cells > MOST_DENSE:
            return 0.0
        K, M = (-self.basis.T @ self.slope @ self.basis, self.basis.T @ self._mass @ self.basis)
        return _fastest(Dense(K, np.zeros_like(K), M))

    def signature(self) -> int:
        """How many motions are unstable without damping; with added states, and beyond MOST_DENSE
        links, the sign of the determinant, which tells odd changes alone."""
        slope = self.basis.T @ self.slope @ self.basis
        if self.rod.scene.states or self.rod.cells > MOST_DENSE:
            return int(np.linalg.slogdet(slope)[0])
        mass = self.basis.T @ self._mass @ self.basis
        return int((np.linalg.eigvals(np.linalg.solve(mass, slope)).real > 0).sum())


def _fastest(small: Dense) -> float:
    """Square of the fastest growth [1/s^2] of motions whose stiffness is as good as symmetric."""
    K = (small.K + small.K.T) / 2
    if not np.isfinite(K).all():
        return 0.0
    lowest = eigvalsh(K, (small.M + small.M.T) / 2, subset_by_index=[0, 0])[0]
    return max(0.0, -float(lowest))


Balance = ChainBalance | WholeBalance


def balance(
    rod: SteadyRod,
    at: Unknowns,
    p: Array,
    bend: Array | float = 0.0,
    springs: Softened | None = None,
) -> Balance:
    """The equations of rest of a system; bend: what is to remain of them instead of zero; springs:
    those of its supports, with the forces that were foretold."""
    if not rod.chain:
        return WholeBalance(rod, rod.at_rest(at), p, bend, springs)
    return ChainBalance(Cells.at(rod, at, p), bend)


def free_ways(rod: SteadyRod, at: Unknowns, p: Array) -> Array:
    """Directions (k, 2) in which nothing holds a free rod, nor follows its place."""
    return WholeBalance(rod, rod.at_rest(at), p, 0.0).free
