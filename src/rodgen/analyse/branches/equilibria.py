"""Equilibria and steady motions as a curve of one varied number: their stability, and where along
it a small motion begins or ceases to grow."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from rodgen.analyse.branches.variable import Variable
from rodgen.analyse.curves.curve import BRANCH, Point, Problem, Special, corrected
from rodgen.analyse.curves.special_points import on_chord
from rodgen.analyse.eigen import Complex
from rodgen.analyse.modal import arising
from rodgen.analyse.onset import Onset, onset
from rodgen.analyse.pencil import Linear, Parts, Pencil
from rodgen.analyse.small_motions import Growing, grown
from rodgen.analyse.steady import Steady, linearised, straight_state
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

HOPF = "hopf"
SLOWEST = 1e-3  # of the rate beside it, over 2 pi: a motion that is slower there has none
PARTS = 1 / 2, 1 / 4, 3 / 4  # of what is left, of which one is tried after the other
CLOSE = 1e-5  # of the way between two points, to which a crossing is narrowed


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
            state, _ = straight_state(self.variable.rod(value), p)
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
            rod = self.variable.rod(value)
            self._last = key, self._state(rod, self.variable.parameters(value), u)
        return self._last[1]

    @abstractmethod
    def _state(self, rod: SteadyRod, p: Array, u: Array) -> Steady:
        """The state under parameters."""

    @abstractmethod
    def packed(self, state: Steady, value: float) -> Array:
        """u of a state at a value."""

    def restored(self, rod: SteadyRod, p: Array, y: Array, force: Array) -> Steady:
        """The state of a file: its angles, position and added states in y, and joint forces."""
        base, half = rod.base, rod.base + rod.cells
        return Steady(rod, Unknowns(y[base:half], force, y[:base], y[2 * half :]), p)

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
        return crossings(self, before, after)

    def crossed(self, before: Point, after: Point, s: complex) -> Special:
        """Where the motion with a rate s, 0 where it does not oscillate, begins or ceases to grow
        between two points next to each other."""
        return crossing(self, after, s)


def crossings(problem: Equilibria, a: Point, b: Point) -> list[Special]:
    """Where motions begin or cease to oscillate more and more between two points of a branch, to
    all digits; of a free rod also where they begin to diverge, which no determinant tells there."""
    free = len(a.u) == 1
    found: list[Special] = []
    low, share = a, 0.0
    while low.unstable != b.unstable and share < 1 and len(found) < 8:
        left, right, beside, upper = share, 1.0, low, b
        while right - left > CLOSE and (inner := _inner(problem, a, b, left, right)):
            middle, point = inner
            if point.unstable == low.unstable:
                left, beside = middle, point
            else:
                right, upper = middle, point
        one, two = (problem.grown(point.u) for point in (beside, upper))
        s = arising(one, two) if len(one) > len(two) else arising(two, one)
        if s.imag > 0 or free:
            special = problem.crossed(beside, upper, s)
            if special.kind != HOPF or special.frequency > SLOWEST * abs(s):
                found.append(special)
        low, share = upper, right
    return found


def _inner(
    problem: Equilibria, a: Point, b: Point, left: float, right: float
) -> tuple[float, Point] | None:
    """A share of the way between two, and the point there; None next to a branch point between
    them, where none can be told. Raises AnalysisError where none is there for another reason, as
    between points of two branches."""
    failed: AnalysisError | None = None
    for part in PARTS:
        share = left + part * (right - left)
        try:
            return share, on_chord(problem, a, b, share)
        except AnalysisError as error:
            failed = failed or error
            if a.sign * b.sign > 0:
                break
    if a.sign * b.sign < 0 or failed is None:
        return None
    raise failed


def crossing(problem: Equilibria, near: Point, s: complex) -> Special:
    """The crossing next to a point, by Newton's method on the linearised equations along the
    branch."""
    last = np.append(np.zeros(len(near.u) - 1), 1.0)
    slope = near.tangent / near.tangent[-1]

    def state(value: float) -> Array:
        guess = near.u + (problem.scaled(value) - near.u[-1]) * slope
        return corrected(problem, guess, last).u

    def at(value: float) -> Linear:
        here = problem.steady(state(value))
        linear = linearised(here)
        if not s and isinstance(linear, Pencil) and here.turns_freely:
            return Parts.without_turning(linear, here.turning)
        return linear

    kind = HOPF if s else BRANCH
    value = problem.value(near.u)
    try:
        found = onset(at, Onset(value, s), problem.variable.unit)
    except AnalysisError as error:
        return about(near, s, error)
    return Special(kind, state(found.force), frequency=found.s.imag / (2 * np.pi))


def about(near: Point, s: complex, why: AnalysisError) -> Special:
    """The crossing at a point next to it."""
    note = f"known to about {CLOSE:g} of a step only: {why}"
    return Special(HOPF if s else BRANCH, near.u, frequency=s.imag / (2 * np.pi), note=note)
