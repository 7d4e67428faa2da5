"""Curves of solutions of F(u) = 0 with one more unknown than equations: the problem, its points,
and Newton's method back to the curve."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from rodgen.analyse.bordered import BorderedMatrix, Matrix
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.result import Note

ITERATIONS = 10  # of Newton's method for one point
SETTLED = 1e-13  # a correction that is none
NOISE = 1e-9  # a correction that is rounding, if it shrinks no more
OFF = 1e-6  # by which the point of a file may be corrected
FOLD, BRANCH = "fold", "branch"


class ContinuationProblem(ABC):
    """Interface of continuation problems: F(u) = 0, u (N + 1,) of order 1, the parameter last.

    weights (N + 1,): factors of the squared entries of u in the squared length along the curve.
    """

    weights: Array

    @abstractmethod
    def evaluate(self, u: Array) -> tuple[Array, Matrix]:
        """Residual F (N,) and Jacobian (N, N + 1), dense or sparse, at u. Raises AnalysisError
        where there are none."""

    def value(self, u: Array) -> float:
        """Value of the parameter in the unit that a user knows."""
        return float(u[-1])

    def count_unstable(self, u: Array) -> int | None:
        """Number of unstable directions at u; None where it is not known."""
        return None

    def crossings(self, before: CurvePoint, after: CurvePoint) -> list[SpecialPoint]:
        """Special points beside folds and branch points, such as Hopf points, between two points
        with different numbers of unstable directions."""
        return []

    def adapt_to(self, u: Array) -> None:  # noqa: B027  # most problems have nothing to adapt
        """Adapt auxiliary equations, such as of a phase, to a point u from which the curve goes
        on."""

    def length(self, change: Array) -> float:
        """Weighted norm of a change of u."""
        return float(np.sqrt(self.weights @ (change * change)))


class CurvePoint(NamedTuple):
    """A point of a curve: u, its unit tangent, the number of unstable directions, and the sign of
    the determinant of the Jacobian bordered by the tangent."""

    u: Array
    tangent: Array
    unstable: int | None
    sign: int

    @property
    def value(self) -> float:
        """The parameter as it stands in u."""
        return float(self.u[-1])


class SpecialPoint(NamedTuple):
    """A special point u of a curve. kind: "fold", "branch", "hopf" or one of the problem's; after:
    number of the point before it; frequency: of an oscillation [Hz]; ways: both tangents (2, N + 1)
    of a branch point, first the curve's own; note: a reservation."""

    kind: str
    u: Array
    after: int = 0
    frequency: float = 0.0
    ways: Array | None = None
    note: str = ""


@dataclass
class Curve:
    """A followed curve. points: in order; special: points between them; end: why it stops;
    complete: whether nothing is left to follow; notes: where it cannot be trusted; interrupted:
    whether Ctrl-C stopped it."""

    points: list[CurvePoint] = field(default_factory=list)
    special: list[SpecialPoint] = field(default_factory=list)
    end: str = ""
    complete: bool = False
    notes: list[Note] = field(default_factory=list)
    interrupted: bool = False

    def raise_interrupt(self) -> Curve:
        """Return the curve itself. Raises KeyboardInterrupt if Ctrl-C stopped it."""
        if self.interrupted:
            raise KeyboardInterrupt
        return self

    def reverse(self) -> Curve:
        """Reverse the order of the points and the tangents."""
        last = len(self.points) - 1
        special = [one._replace(after=last - 1 - one.after) for one in reversed(self.special)]
        points = [p._replace(tangent=-p.tangent) for p in reversed(self.points)]
        return replace(self, points=points, special=special)


def follow_both_ways(follow: Callable[[float], Curve]) -> Curve:
    """Follow a curve to both sides of its start (-1.0, then 1.0) and join the two halves. If Ctrl-C
    stops the first side, the other one is not followed."""
    back = follow(-1.0).reverse()
    if back.interrupted:
        return back
    on = follow(1.0)
    more = len(back.points) - 1
    special = [one._replace(after=one.after + more) for one in on.special]
    return Curve(
        back.points[:-1] + on.points,
        back.special + special,
        f"{back.end}; on the other side {on.end}" if back.end != on.end else on.end,
        back.complete and on.complete,
        back.notes + on.notes,
        on.interrupted,
    )


class Correction(NamedTuple):
    """A point u found by Newton's method, its last Jacobian J, and the number of iterations."""

    u: Array
    J: Matrix
    iterations: int


def correct(problem: ContinuationProblem, guess: Array, row: Array) -> Correction:
    """Correct a guess to the curve in the plane row (u - guess) = 0. Raises AnalysisError."""
    u, before = guess, np.inf
    for iteration in range(1, ITERATIONS + 1):
        F, J = problem.evaluate(u)
        change = BorderedMatrix(J, row[None]).solve(np.append(-F, 0.0))
        u = u + change
        size = float(np.abs(change).max())
        if not (size < before or size < NOISE):
            break
        # What comes after a correction is its square: the next one would be rounding.
        if size <= SETTLED or (size < NOISE and size >= before / 2):
            return Correction(u, J, iteration)
        if before < 1 and size * size / before * (size / before) < SETTLED:
            return Correction(u, J, iteration)
        before = size
    raise AnalysisError("Newton's method does not converge")


def point_at(problem: ContinuationProblem, found: Correction, like: Array) -> CurvePoint:
    """Complete a corrected point by its tangent, on the side of another one (like), which borders
    the Jacobian, and by its stability."""
    factors = BorderedMatrix(found.J, (problem.weights * like)[None])
    t = factors.solve(np.append(np.zeros(len(like) - 1), 1.0))
    t, unstable = t / problem.length(t), problem.count_unstable(found.u)
    return CurvePoint(found.u, t, unstable, factors.determinant_sign)


def start_point(problem: ContinuationProblem, u: Array, way: float = 1.0) -> CurvePoint:
    """Correct u at its parameter to the first point of a curve, with a tangent along which the
    parameter grows (way 1) or falls (-1). Raises AnalysisError where u is near no solution."""
    last = np.append(np.zeros(len(u) - 1), 1.0)
    found = correct(problem, u, last)
    point = point_at(problem, found, last)
    if point.tangent[-1] * way < 0:
        point = point._replace(tangent=-point.tangent, sign=-point.sign)
    return point


def resume_point(problem: ContinuationProblem, points: list[Array], what: str) -> CurvePoint:
    """Correct the first of these points of a file, with a tangent that leads away from the second;
    without that, the parameter grows. Raises AnalysisError, which names what the point should be,
    if it is no solution."""
    here = points[0]
    way = here - points[1] if len(points) > 1 else np.append(np.zeros(len(here) - 1), 1.0)
    way = way / problem.length(way)
    try:
        found = correct(problem, here, problem.weights * way)
        astray = problem.length(found.u - here)
    except AnalysisError:
        astray = np.inf
    if astray > OFF:
        raise AnalysisError(
            f"the point of the file is no {what} of this scene"
            f" (Newton's method leads {astray:.1e} away from it)"
        )
    return point_at(problem, found, way)
