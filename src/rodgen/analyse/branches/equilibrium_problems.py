"""Curves of equilibria as problems of continuation: chains, whole rods, straight flight."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csc_array, diags_array, hstack

from rodgen.analyse.balance import WholeBalance
from rodgen.analyse.bordered import Matrix
from rodgen.analyse.branches.equilibria import Equilibria
from rodgen.analyse.pencil import Cells, sparse
from rodgen.analyse.rod_range import RodRange
from rodgen.analyse.steady import Steady, straight_state
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

NEUTRAL = 1e-9  # of the stiffness: none
SMALL = 90  # unknowns up to which full matrices take less time than sparse ones


class Chain(Equilibria):
    """Of a rod whose joint 0 is held and whose loads follow no motion, in O(n): unknown are its
    angles and the forces in its joints."""

    def __init__(self, along: RodRange, start: Steady, all_modes: bool = False):
        super().__init__(along, start, all_modes)
        scene, cells = start.rod.scene, start.rod.cells
        soft = scene.distribution.usual_stiffness / scene.rod.length**2 * scene.rod.links
        usual = max(soft / max(scene.mass, 1e-300), float(np.abs(start.force).max(initial=0.0)))
        self.force = usual or 1.0
        self.columns = np.tile([1.0, self.force, self.force], cells)
        self.weights = np.append(np.tile([1.0 / cells, 0.0, 0.0], cells), 1.0)
        sizes = abs(sparse(start.cells.statics)) @ self.columns
        self.rows = 1 / np.where(sizes > 0, sizes, 1.0)
        self._left, self._right = diags_array(self.rows), diags_array(self.columns)

    def packed(self, state: Steady, value: float) -> Array:
        z = np.column_stack((state.phi, state.force)).ravel() / self.columns
        return np.append(z, self.scaled(value))

    def _state(self, rod: SteadyRod, p: Array, u: Array) -> Steady:
        z = (u[:-1] * self.columns).reshape(-1, 3)
        at = rod.unsettled(z[:, 0])._replace(force=z[:, 1:])
        return Steady(rod, at, p)

    def at(self, u: Array) -> tuple[Array, Matrix]:
        here = self.steady(u)
        rod, cells = here.rod, here.cells
        by_value = np.zeros(cells.residual.size)
        for p, share in self.along.near(self.value(u)):
            by_value += share * Cells.at(rod, here.at, p).residual.ravel()
        by_value *= self.rows
        F = self.rows * cells.residual.ravel()
        if cells.ways is not None:
            whole = cells.whole(cells.statics, cells.by_position)
            return F, np.column_stack((self.rows[:, None] * whole * self.columns, by_value))
        J = csc_array(hstack([self._left @ sparse(cells.statics) @ self._right, by_value[:, None]]))
        return F, J.toarray() if len(u) <= SMALL else J


class Whole(Equilibria):
    """Of a rod whose joint 0 is free and held by springs, or whose loads follow the motion:
    unknown are the position of joint 0, where it counts, the angles, and added states."""

    def __init__(self, along: RodRange, start: Steady, all_modes: bool = False):
        super().__init__(along, start, all_modes)
        rod = start.rod
        here = WholeBalance(rod, rod.at_rest(start.at), start.p, 0.0)
        self.basis, self.origin = self._held(here.basis), self._coordinates(start.at)
        sizes = np.ones(len(self.basis))
        sizes[: rod.base] = rod.scene.rod.length
        added = slice(rod.base + rod.cells, None)
        sizes[added] = np.maximum(1.0, np.abs(start.at.added))
        self.columns = np.abs(self.basis).T @ sizes
        angles = np.zeros(len(self.basis))
        angles[: rod.base + rod.cells] = 1.0 / rod.cells
        self.weights = np.append(np.abs(self.basis).T @ angles, 1.0)
        slope = np.abs(self.basis.T @ here.slope @ self.basis) @ self.columns
        self.rows = 1 / np.where(slope > 0, slope, 1.0)

    def _held(self, basis: Array) -> Array:
        """Without turning the whole rod, where that has no effect under any load."""
        start, ways = self.start, np.zeros(len(basis))
        ways[start.rod.base : start.rod.base + start.rod.cells] = 1.0
        turning = basis.T @ ways
        for value in self.along.bounds:
            rod, p = self.along.rod(value), self.along.parameters(value)
            slope = WholeBalance(rod, rod.at_rest(start.at), p, 0.0).slope
            reduced = basis.T @ slope @ basis
            if np.abs(reduced @ turning).max() > NEUTRAL * np.abs(reduced).max():
                return basis
        return np.asarray(basis @ null_space(turning[None]))

    @staticmethod
    def _coordinates(at: Unknowns) -> Array:
        return np.concatenate((at.position, at.phi, at.added))

    def packed(self, state: Steady, value: float) -> Array:
        z = self.basis.T @ (self._coordinates(state.at) - self.origin) / self.columns
        return np.append(z, self.scaled(value))

    def _state(self, rod: SteadyRod, p: Array, u: Array) -> Steady:
        x = self.origin + self.basis @ (self.columns * u[:-1])
        position, phi, added = np.split(x, [rod.base, rod.base + rod.cells])
        at = Unknowns(phi, np.zeros((rod.cells, 2)), position, added)
        return Steady(rod, at, p)

    def at(self, u: Array) -> tuple[Array, Matrix]:
        here = self.steady(u)
        rod, y = here.rod, here.rod.at_rest(here.at)
        balance = WholeBalance(rod, y, here.p, 0.0)
        by_value = np.zeros(len(self.basis))
        for p, share in self.along.near(self.value(u)):
            by_value += share * WholeBalance(rod, y, p, 0.0).residual
        reduced = self.basis.T @ balance.slope @ self.basis
        J = self.rows[:, None] * np.column_stack((reduced * self.columns, self.basis.T @ by_value))
        return self.rows * (self.basis.T @ balance.residual), J


class Flight(Equilibria):
    """Of a rod that stays straight: a free one that nothing holds accelerates steadily, a pinned
    one may turn freely under all loads of the range."""

    def __init__(self, along: RodRange, start: Steady, all_modes: bool = False):
        super().__init__(along, start, all_modes)
        self.weights = np.ones(1)

    def packed(self, state: Steady, value: float) -> Array:
        return np.array([self.scaled(value)])

    def _state(self, rod: SteadyRod, p: Array, u: Array) -> Steady:
        state, turning = straight_state(rod, p)
        if state is None:
            raise AnalysisError(f"the rod begins to turn with {turning:.3g} rad/s^2")
        return state

    def at(self, u: Array) -> tuple[Array, Matrix]:
        self.steady(u)
        return np.zeros(0), np.zeros((0, 1))


def equilibria(along: RodRange, start: Steady, all_modes: bool = False) -> Equilibria:
    """The curve that a steady state lies on, as a problem of continuation."""
    rod = start.rod
    if rod.base and not (rod.anchored or rod.steered):
        return Flight(along, start, all_modes)
    if rod.chain and all(_turns_freely(along, start, end) for end in along.bounds):
        return Flight(along, start, all_modes)
    if rod.base or rod.steered:
        return Whole(along, start, all_modes)
    return Chain(along, start, all_modes)


def _turns_freely(along: RodRange, start: Steady, value: float) -> bool:
    """Whether the whole rod turns freely about a steady state and about the straight one at a
    value."""
    if not start.turns_freely:
        return False
    state, _ = straight_state(along.rod(value), along.parameters(value))
    return state is not None and state.turns_freely
