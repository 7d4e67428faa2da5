"""Equilibria and steady motions as curves over one varied number: their stability, and the points
at which a small motion begins or ceases to grow."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from rodgen.analyse.curves.curve import (
    BRANCH,
    ContinuationProblem,
    Curve,
    CurvePoint,
    SpecialPoint,
    correct,
    start_point,
)
from rodgen.analyse.curves.special_points import Chord
from rodgen.analyse.eigenvalue_check import FullSpectrum, is_contradiction
from rodgen.analyse.eigenvalues import Complex
from rodgen.analyse.modal import MOST_DENSE, growing_eigenvalue
from rodgen.analyse.onset import Onset, solve_onset
from rodgen.analyse.pencil import BlockPencil, Linear, MatrixPencil
from rodgen.analyse.scaled_load import RodRange
from rodgen.analyse.small_motions import SmallMotions, growing_eigenvalues
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.analyse.steady_state import SteadyState, pencil_about, unloaded_state
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

HOPF = "hopf"
BESIDE = 1e-6  # of the range: next to a start in which no direction is known
SLOWEST = 1e-3  # of the rate beside it, over 2 pi: a motion that is slower there has none
PARTS = 1 / 2, 1 / 4, 3 / 4  # of what is left, of which one is tried after the other
CHECKED = 5  # points of a branch of which all eigenvalues are looked at
ANOTHER = 0.05  # of a rate, by which that of a crossing differs from it at most
CLOSE = 1e-5  # of the way between two points, to which a crossing is narrowed


class Equilibria(ContinuationProblem):
    """Base of curves of steady states. u: scaled unknowns, and the varied number over its unit."""

    def __init__(self, along: RodRange, start: SteadyState, all_modes: bool = False):
        self.along, self.start = along, start
        self._last: tuple[bytes, SteadyState] | None = None
        self.why_unknown = ""
        self.growing = self._growth_counter(start, all_modes)

    def _growth_counter(self, start: SteadyState, all_modes: bool) -> SmallMotions | None:
        """Counter of growing motions, in modes of the first state; if that turns freely, of one
        that does not, at an end of the range. None where stability cannot be counted."""
        values = [value for value in self.along.numbers.bounds if start.has_free_rotation]
        for value in values:
            p = self.along.numbers.parameters(value)
            state, _ = unloaded_state(self.along.rod(value), p)
            if state is not None and not state.has_free_rotation:
                start = state
        try:
            return SmallMotions(start, all_modes)
        except AnalysisError as error:  # of a bent rod that drag brakes, stability is not known
            self.why_unknown = str(error)
            return None

    def drop_stability(self, why: str) -> None:
        """Stop counting growing motions from here on, and keep the reason."""
        self.growing, self.why_unknown = None, why

    def value(self, u: Array) -> float:
        """The varied number at u."""
        return float(u[-1] * self.along.numbers.unit)

    def scale(self, value: float) -> float:
        """Scale a value of the varied number to the last entry of u."""
        return value / self.along.numbers.unit

    def solve_at(self, guess: Array, value: float) -> Array:
        """Find u of the branch at a value, near a guess. Raises AnalysisError."""
        last = np.append(np.zeros(len(guess) - 1), 1.0)
        return correct(self, np.append(guess[:-1], self.scale(value)), last).u

    def first_point(self, u: Array, way: float) -> CurvePoint:
        """Find the first point of a branch near u, from where the value grows (way 1) or falls
        (-1); right beside u where the branch has no tangent, as of an unloaded rod. Raises
        AnalysisError."""
        try:
            return start_point(self, u, way)
        except AnalysisError:
            return start_point(self, np.append(u[:-1], u[-1] + way * BESIDE), way)

    def steady_state(self, u: Array) -> SteadyState:
        """Steady state at u; the last one is cached."""
        key = u.tobytes()
        if self._last is None or self._last[0] != key:
            value = self.value(u)
            rod = self.along.rod(value)
            self._last = key, self._make_state(rod, self.along.numbers.parameters(value), u)
        return self._last[1]

    @abstractmethod
    def _make_state(self, rod: SteadyRod, p: Array, u: Array) -> SteadyState:
        """Make the steady state at u of a rod with parameters p."""

    @abstractmethod
    def pack(self, state: SteadyState, value: float) -> Array:
        """Pack a state and a value into u."""

    @staticmethod
    def restore(rod: SteadyRod, p: Array, y: Array, force: Array) -> SteadyState:
        """Make the steady state of a saved state y (angles, position, added) and joint forces."""
        base, half = rod.n_base, rod.n_base + rod.n_moving
        return SteadyState(rod, Unknowns(y[base:half], force, y[:base], y[2 * half :]), p)

    def count_unstable(self, u: Array) -> int | None:
        if self.growing is None:
            return None
        try:
            return self.growing.count_unstable(self.steady_state(u))
        except AnalysisError as error:
            self.why_unknown = self.why_unknown or str(error)
            return None

    def growing_eigenvalues(self, u: Array) -> Complex:
        """Eigenvalues with growth [1/s] at u, both of every conjugate pair."""
        assert self.growing is not None
        return growing_eigenvalues(self.growing.motions(self.steady_state(u)))

    def crossings(self, before: CurvePoint, after: CurvePoint) -> list[SpecialPoint]:
        return find_crossings(self, before, after)

    def linearise(self, u: Array, s: complex) -> Linear:
        """Linearised equations at u for a motion with a rate s. If it does not oscillate (s = 0),
        the turning of a free rod as a whole is left out."""
        here = self.steady_state(u)
        linear = pencil_about(here)
        if not s and isinstance(linear, BlockPencil):
            return MatrixPencil.without_rotation(linear, here.free_rotation)
        return linear


def find_crossings(problem: Equilibria, a: CurvePoint, b: CurvePoint) -> list[SpecialPoint]:
    """Find where oscillations begin or cease to grow between two points of a branch, to all digits;
    of a straight free rod also where motions diverge, which no determinant shows there."""
    free = len(a.u) == 1
    found: list[SpecialPoint] = []
    low, share = a, 0.0
    while low.unstable != b.unstable and share < 1 and len(found) < 8:
        left, right, beside, upper = share, 1.0, low, b
        while right - left > CLOSE and (inner := _inner_point(problem, a, b, left, right)):
            middle, point = inner
            if point.unstable == low.unstable:
                left, beside = middle, point
            else:
                right, upper = middle, point
        one, two = (problem.growing_eigenvalues(point.u) for point in (beside, upper))
        s = growing_eigenvalue(one, two) if len(one) > len(two) else growing_eigenvalue(two, one)
        if s.imag > 0 or free:
            special = locate_crossing(problem, upper, s)
            if special.kind != HOPF or special.frequency > SLOWEST * abs(s):
                found.append(special)
        low, share = upper, right
    return found


def _inner_point(
    problem: Equilibria, a: CurvePoint, b: CurvePoint, left: float, right: float
) -> tuple[float, CurvePoint] | None:
    """Find a point between two shares of the way from a to b, and its share. None where that fails
    near a branch point between a and b. Raises AnalysisError where it fails for another reason, as
    between points of two branches."""
    failed: AnalysisError | None = None
    for part in PARTS:
        share = left + part * (right - left)
        try:
            return share, Chord(problem, a, b).point(share)
        except AnalysisError as error:
            failed = failed or error
            if a.sign * b.sign > 0:
                break
    if a.sign * b.sign < 0 or failed is None:
        return None
    raise failed


def locate_crossing(problem: Equilibria, near: CurvePoint, s: complex) -> SpecialPoint:
    """Find where the motion with a rate s (0 if it does not oscillate) begins or ceases to grow,
    near a point, by Newton's method on the linearised equations along the branch."""
    slope = near.tangent / near.tangent[-1]

    def u_at(value: float) -> Array:
        guess = near.u + (problem.scale(value) - near.u[-1]) * slope
        return problem.solve_at(guess, value)

    def equations_at(value: float) -> Linear:
        return problem.linearise(u_at(value), s)

    kind = HOPF if s else BRANCH
    try:
        found = solve_onset(
            equations_at, Onset(problem.value(near.u), s), problem.along.numbers.unit
        )
        if abs(found.s - s) > ANOTHER * abs(s):
            raise AnalysisError("Newton's method led to a motion with another frequency")
    except AnalysisError as error:
        note = f"known to about {CLOSE:g} of a step only: {error}"
        return SpecialPoint(kind, near.u, frequency=s.imag / (2 * np.pi), note=note)
    return SpecialPoint(kind, u_at(found.force), frequency=found.s.imag / (2 * np.pi))


def has_doubtful_counts(problem: Equilibria, curve: Curve) -> bool:
    """Whether all eigenvalues contradict the counted numbers of unstable directions, in a few
    points and beside the special ones."""
    growing, rod = problem.growing, problem.along.base
    if growing is None or rod.n_moving > MOST_DENSE or rod.is_light:
        return False
    last = len(curve.points) - 1
    looked = {*np.linspace(0, last, CHECKED).astype(int).tolist()}
    looked |= {min(one.after + at, last) for one in curve.special for at in (0, 1)}
    for at in sorted(looked):
        point = curve.points[at]
        if point.unstable is None:
            continue
        state = problem.steady_state(point.u)
        found = FullSpectrum.of(pencil_about(state).to_dense(), growing.lowest)
        if is_contradiction(found, growing.motions(state), growing.lowest):
            return True
    return False
