"""Equilibria and steady motions as a curve of one varied number, and their stability."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csc_array, diags_array, hstack

from rodgen.analyse.balance import WholeBalance
from rodgen.analyse.branches.crossings import crossing, solved
from rodgen.analyse.branches.variable import Variable
from rodgen.analyse.curves.bordered import Matrix
from rodgen.analyse.curves.curve import Point, Problem, Special
from rodgen.analyse.eigen import Complex
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.pencil import Cells, sparse
from rodgen.analyse.small_motions import Growing, grown
from rodgen.analyse.steady import Steady, straight_state
from rodgen.analyse.system import System, Unknowns
from rodgen.integrate.stepper import Array

NEUTRAL = 1e-9  # of the stiffness: none
SMALL = 90  # unknowns up to which full matrices take less time than sparse ones


class Equilibria(Problem):
    """u: what is unknown of a steady state, and the varied number over its range."""

    def __init__(self, variable: Variable, start: Steady, all_modes: bool = False):
        self.variable, self.start = variable, start
        self._last: tuple[bytes, Steady] | None = None
        self.why_unknown = ""
        self.growing = self._growing(start, all_modes)

    def _growing(self, start: Steady, all_modes: bool) -> Growing | None:
        """What grows about its states, in modes of the first, where it is counted so; where that
        turns freely, in those of one that does not, if there is one."""
        values = [value for value in self.variable.ends if start.turns_freely]
        for value in values:
            p = self.variable.parameters(value)
            state, _ = straight_state(self.variable.system(value), p)
            if state is not None and not state.turns_freely:
                start = state
        try:
            return Growing(start, all_modes)
        except AnalysisError as error:  # of a bent rod that drag brakes, stability is not known
            self.why_unknown = str(error)
            return None

    def leave_stability(self, why: str) -> None:
        """Count nothing that grows from here on, for a reason."""
        self.growing, self.why_unknown = None, why

    def value(self, u: Array) -> float:
        """The varied number."""
        return float(u[-1] * self.variable.unit)

    def scaled(self, value: float) -> float:
        """A value as the last entry of u."""
        return value / self.variable.unit

    def steady(self, u: Array) -> Steady:
        """The state that u stands for."""
        key = u.tobytes()
        if self._last is None or self._last[0] != key:
            value = self.value(u)
            system = self.variable.system(value)
            self._last = key, self._state(system, self.variable.parameters(value), u)
        return self._last[1]

    @abstractmethod
    def _state(self, system: System, p: Array, u: Array) -> Steady:
        """The state under parameters."""

    @abstractmethod
    def packed(self, state: Steady, value: float) -> Array:
        """u of a state at a value."""

    def restored(self, system: System, p: Array, y: Array, force: Array) -> Steady:
        """The state of a file: its angles, position and added states in y, and joint forces."""
        base, half = system.base, system.base + system.cells
        return Steady(system, Unknowns(y[base:half], force, y[:base], y[2 * half :]), p)

    def unstable(self, u: Array) -> int | None:
        if self.growing is None:
            return None
        try:
            return self.growing.count(self.steady(u))
        except AnalysisError as error:
            self.why_unknown = self.why_unknown or str(error)
            return None

    def grown(self, u: Array) -> Complex:
        """The eigenvalues that grow [1/s], both of every conjugate pair."""
        assert self.growing is not None
        return grown(self.growing.motions(self.steady(u)))

    def crossings(self, before: Point, after: Point) -> list[Special]:
        return crossing(self, before, after)

    def crossed(self, before: Point, after: Point, s: complex) -> Special:
        """Where the motion with a rate s, 0 where it does not oscillate, begins or ceases to grow
        between two points next to each other."""
        return solved(self, after, s)


class Chain(Equilibria):
    """Of a rod whose joint 0 is held and whose loads follow no motion, in O(n): unknown are its
    angles and the forces in its joints."""

    def __init__(self, variable: Variable, start: Steady, all_modes: bool = False):
        super().__init__(variable, start, all_modes)
        scene, cells = start.system.scene, start.system.cells
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

    def _state(self, system: System, p: Array, u: Array) -> Steady:
        z = (u[:-1] * self.columns).reshape(-1, 3)
        at = system.unsettled(z[:, 0])._replace(force=z[:, 1:])
        return Steady(system, at, p)

    def at(self, u: Array) -> tuple[Array, Matrix]:
        here = self.steady(u)
        system, cells = here.system, here.cells
        by_value = np.zeros(cells.residual.size)
        for p, share in self.variable.near(self.value(u)):
            by_value += share * Cells.at(system, here.at, p).residual.ravel()
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

    def __init__(self, variable: Variable, start: Steady, all_modes: bool = False):
        super().__init__(variable, start, all_modes)
        system = start.system
        here = WholeBalance(system, system.at_rest(start.at), start.p, 0.0)
        self.basis, self.origin = self._held(here.basis), self._coordinates(start.at)
        sizes = np.ones(len(self.basis))
        sizes[: system.base] = system.scene.rod.length
        added = slice(system.base + system.cells, None)
        sizes[added] = np.maximum(1.0, np.abs(start.at.added))
        self.columns = np.abs(self.basis).T @ sizes
        angles = np.zeros(len(self.basis))
        angles[: system.base + system.cells] = 1.0 / system.cells
        self.weights = np.append(np.abs(self.basis).T @ angles, 1.0)
        slope = np.abs(self.basis.T @ here.slope @ self.basis) @ self.columns
        self.rows = 1 / np.where(slope > 0, slope, 1.0)

    def _held(self, basis: Array) -> Array:
        """Without turning the whole rod, where that has no effect under any load."""
        start, ways = self.start, np.zeros(len(basis))
        ways[start.system.base : start.system.base + start.system.cells] = 1.0
        turning = basis.T @ ways
        for value in self.variable.ends:
            system, p = self.variable.system(value), self.variable.parameters(value)
            slope = WholeBalance(system, system.at_rest(start.at), p, 0.0).slope
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

    def _state(self, system: System, p: Array, u: Array) -> Steady:
        x = self.origin + self.basis @ (self.columns * u[:-1])
        position, phi, added = np.split(x, [system.base, system.base + system.cells])
        at = Unknowns(phi, np.zeros((system.cells, 2)), position, added)
        return Steady(system, at, p)

    def at(self, u: Array) -> tuple[Array, Matrix]:
        here = self.steady(u)
        system, y = here.system, here.system.at_rest(here.at)
        balance = WholeBalance(system, y, here.p, 0.0)
        by_value = np.zeros(len(self.basis))
        for p, share in self.variable.near(self.value(u)):
            by_value += share * WholeBalance(system, y, p, 0.0).residual
        reduced = self.basis.T @ balance.slope @ self.basis
        J = self.rows[:, None] * np.column_stack((reduced * self.columns, self.basis.T @ by_value))
        return self.rows * (self.basis.T @ balance.residual), J


class Flight(Equilibria):
    """Of a free rod that nothing holds: it stays straight, and accelerates steadily."""

    def __init__(self, variable: Variable, start: Steady, all_modes: bool = False):
        super().__init__(variable, start, all_modes)
        self.weights = np.ones(1)

    def packed(self, state: Steady, value: float) -> Array:
        return np.array([self.scaled(value)])

    def _state(self, system: System, p: Array, u: Array) -> Steady:
        state, turning = straight_state(system, p)
        if state is None:
            raise AnalysisError(f"the rod begins to turn with {turning:.3g} rad/s^2")
        return state

    def at(self, u: Array) -> tuple[Array, Matrix]:
        self.steady(u)
        return np.zeros(0), np.zeros((0, 1))


def equilibria(variable: Variable, start: Steady, all_modes: bool = False) -> Equilibria:
    """The curve that a steady state lies on, as a problem of continuation."""
    system = start.system
    if system.base and not (system.anchored or system.steered):
        return Flight(variable, start, all_modes)
    if system.base or system.steered:
        return Whole(variable, start, all_modes)
    return Chain(variable, start, all_modes)
