"""Equilibria and steady motions as a curve of one varied number: their stability, and where along
it a small motion begins or ceases to grow."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from rodgen.analyse.confirm import Eigenvalues, contradicts
from rodgen.analyse.curves.continuation import started
from rodgen.analyse.curves.curve import BRANCH, Curve, Point, Problem, Special, corrected
from rodgen.analyse.curves.special_points import on_chord
from rodgen.analyse.eigen import Complex
from rodgen.analyse.modal import MOST_DENSE, arising
from rodgen.analyse.onset import Onset, onset
from rodgen.analyse.pencil import Linear, Parts, Pencil
from rodgen.analyse.rod_range import RodRange
from rodgen.analyse.small_motions import Growing, grown
from rodgen.analyse.steady import Steady, linearised, straight_state
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

HOPF = "hopf"
BESIDE = 1e-6  # of the range: next to a start in which no direction is known
SLOWEST = 1e-3  # of the rate beside it, over 2 pi: a motion that is slower there has none
PARTS = 1 / 2, 1 / 4, 3 / 4  # of what is left, of which one is tried after the other
CHECKED = 5  # points of a branch of which all eigenvalues are looked at
ANOTHER = 0.05  # of a rate, by which that of a crossing differs from it at most
CLOSE = 1e-5  # of the way between two points, to which a crossing is narrowed


class Equilibria(Problem):
    """u: what is unknown of a steady state, and the varied number over its range."""

    def __init__(self, along: RodRange, start: Steady, all_modes: bool = False):
        self.along, self.start = along, start
        self._last: tuple[bytes, Steady] | None = None
        self.why_unknown = ""
        self.growing = self._growing(start, all_modes)

    def _growing(self, start: Steady, all_modes: bool) -> Growing | None:
        """What grows about its states, in modes of the first, where it is counted so; where that
        turns freely, in those of one that does not, if there is one."""
        values = [value for value in self.along.bounds if start.turns_freely]
        for value in values:
            p = self.along.parameters(value)
            state, _ = straight_state(self.along.rod(value), p)
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
        return float(u[-1] * self.along.unit)

    def scaled(self, value: float) -> float:
        """A value as the last entry of u."""
        return value / self.along.unit

    def at_value(self, guess: Array, value: float) -> Array:
        """u of the branch at a value, next to a guess. Raises AnalysisError."""
        last = np.append(np.zeros(len(guess) - 1), 1.0)
        return corrected(self, np.append(guess[:-1], self.scaled(value)), last).u

    def first_point(self, u: Array, way: float) -> Point:
        """The point of a branch at the value of u, which is close to it, from where the value grows
        (way 1) or falls (-1); beside it where the unloaded rod has no direction there. Raises
        AnalysisError."""
        try:
            return started(self, u, way)
        except AnalysisError:
            return started(self, np.append(u[:-1], u[-1] + way * BESIDE), way)

    def steady(self, u: Array) -> Steady:
        """The state that u stands for."""
        key = u.tobytes()
        if self._last is None or self._last[0] != key:
            value = self.value(u)
            rod = self.along.rod(value)
            self._last = key, self._state(rod, self.along.parameters(value), u)
        return self._last[1]

    @abstractmethod
    def _state(self, rod: SteadyRod, p: Array, u: Array) -> Steady:
        """The state under parameters."""

    @abstractmethod
    def packed(self, state: Steady, value: float) -> Array:
        """u of a state at a value."""

    @staticmethod
    def restored(rod: SteadyRod, p: Array, y: Array, force: Array) -> Steady:
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

    def linear(self, u: Array, s: complex) -> Linear:
        """The linearised equations at a point, where a motion with a rate s is looked at: of one
        that does not oscillate without what turns a free rod as a whole."""
        here = self.steady(u)
        linear = linearised(here)
        if not s and isinstance(linear, Pencil) and here.turns_freely:
            return Parts.without_turning(linear, here.turning)
        return linear


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
            special = crossing(problem, upper, s)
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
    """Where the motion with a rate s, 0 where it does not oscillate, begins or ceases to grow next
    to a point, by Newton's method on the linearised equations along the branch."""
    slope = near.tangent / near.tangent[-1]

    def state(value: float) -> Array:
        guess = near.u + (problem.scaled(value) - near.u[-1]) * slope
        return problem.at_value(guess, value)

    def at(value: float) -> Linear:
        return problem.linear(state(value), s)

    kind = HOPF if s else BRANCH
    try:
        found = onset(at, Onset(problem.value(near.u), s), problem.along.unit)
        if abs(found.s - s) > ANOTHER * abs(s):
            raise AnalysisError("Newton's method led to a motion with another frequency")
    except AnalysisError as error:
        note = f"known to about {CLOSE:g} of a step only: {error}"
        return Special(kind, near.u, frequency=s.imag / (2 * np.pi), note=note)
    return Special(kind, state(found.force), frequency=found.s.imag / (2 * np.pi))


def is_doubted(problem: Equilibria, curve: Curve) -> bool:
    """Whether all eigenvalues tell other numbers of unstable directions than those that were
    counted, in a few points and beside special ones."""
    growing = problem.growing
    if growing is None or problem.along.base.cells > MOST_DENSE:
        return False
    last = len(curve.points) - 1
    looked = {*np.linspace(0, last, CHECKED).astype(int).tolist()}
    looked |= {min(one.after + at, last) for one in curve.special for at in (0, 1)}
    for at in sorted(looked):
        point = curve.points[at]
        if point.unstable is None:
            continue
        state = problem.steady(point.u)
        found = Eigenvalues.of(linearised(state).reduced(), growing.lowest)
        if contradicts(found, growing.motions(state), growing.lowest):
            return True
    return False
