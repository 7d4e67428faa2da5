"""Curves of solutions of F(u) = 0 with one unknown more than equations: what is continued, a point,
and Newton's method back to the curve."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from rodgen.analyse.bordered import Bordered, Matrix
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.result import Note

ITERATIONS = 10  # of Newton's method for one point
SETTLED, NOISE = (
    1e-13,
    1e-9,
)  # a correction that is none; one that is rounding if it shrinks no more
FOLD, BRANCH = "fold", "branch"


class Problem(ABC):
    """F(u) = 0 with u (N + 1,), of which the last is the parameter, all of the order of one.

    weights: (N + 1,) of the entries of u in the length along the curve, their squares times these.
    """

    weights: Array

    @abstractmethod
    def at(self, u: Array) -> tuple[Array, Matrix]:
        """F (N,) and its derivatives (N, N + 1), dense or sparse. AnalysisError where there is
        none."""

    def value(self, u: Array) -> float:
        """The parameter, as a reader knows it."""
        return float(u[-1])

    def unstable(self, u: Array) -> int | None:
        """How many directions are unstable; None where that is not looked at."""
        return None

    def measures(self, u: Array) -> Mapping[str, float]:
        """Smooth functions that are zero in special points of a kind, by its name."""
        return {}

    def crossings(self, before: Point, after: Point) -> list[Special]:
        """Special points between two points whose numbers of unstable directions differ, that no
        measure has: Hopf points."""
        return []

    def length(self, change: Array) -> float:
        """How long a change of u is."""
        return float(np.sqrt(self.weights @ (change * change)))


class Point(NamedTuple):
    """Of a curve: u, its unit tangent, how many directions are unstable, the sign of the
    determinant of the derivatives bordered by the tangent, and the measures of the problem."""

    u: Array
    tangent: Array
    unstable: int | None
    sign: int
    measures: Mapping[str, float]

    @property
    def value(self) -> float:
        """The parameter, as the problem has it."""
        return float(self.u[-1])


class Special(NamedTuple):
    """kind: "fold", "branch", "hopf" or what the problem calls it; u: where; after: the number of
    the point that it comes after; frequency [Hz], of what oscillates; ways: in a branch point both
    tangents (2, N + 1), first that of the curve itself; note: what is to be known."""

    kind: str
    u: Array
    after: int = 0
    frequency: float = 0.0
    ways: Array | None = None
    note: str = ""


@dataclass
class Curve:
    """points: in order; special: between them; end: why it stops where it does; complete: whether
    nothing is left to follow; notes: where it cannot be trusted; interrupted: whether Ctrl-C
    stopped it."""

    points: list[Point] = field(default_factory=list)
    special: list[Special] = field(default_factory=list)
    end: str = ""
    complete: bool = False
    notes: list[Note] = field(default_factory=list)
    interrupted: bool = False

    def uninterrupted(self) -> Curve:
        """The curve itself. Raises KeyboardInterrupt where Ctrl-C stopped it."""
        if self.interrupted:
            raise KeyboardInterrupt
        return self

    def backwards(self) -> Curve:
        """With its points from the last to the first."""
        last = len(self.points) - 1
        special = [one._replace(after=last - 1 - one.after) for one in reversed(self.special)]
        points = [p._replace(tangent=-p.tangent) for p in reversed(self.points)]
        return replace(self, points=points, special=special)


def both_ways(follow: Callable[[float], Curve]) -> Curve:
    """A curve to both sides of its start, from the end that is reached the way -1.0 to that of
    1.0; one that Ctrl-C stops on the first side has no other."""
    back = follow(-1.0)
    if back.interrupted:
        return back.backwards()
    return joined(back, follow(1.0))


def joined(back: Curve, on: Curve) -> Curve:
    """Two curves that begin at one point as one."""
    back = back.backwards()
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


class Corrected(NamedTuple):
    """A point of the curve, the derivatives beside it, and the iterations that it took."""

    u: Array
    J: Matrix
    iterations: int


def corrected(problem: Problem, guess: Array, row: Array) -> Corrected:
    """The point of the curve in the plane row (u - guess) = 0. Raises AnalysisError."""
    u, before = guess, np.inf
    for iteration in range(1, ITERATIONS + 1):
        F, J = problem.at(u)
        change = Bordered(J, row[None]).solve(np.append(-F, 0.0))
        u = u + change
        size = float(np.abs(change).max())
        if not (size < before or size < NOISE):
            break
        # What comes after a correction is its square: the next one would be rounding.
        if size <= SETTLED or (size < NOISE and size >= before / 2):
            return Corrected(u, J, iteration)
        if before < 1 and size * size / before * (size / before) < SETTLED:
            return Corrected(u, J, iteration)
        before = size
    raise AnalysisError("Newton's method does not converge")


def tangent_at(problem: Problem, J: Matrix, like: Array) -> tuple[Array, int]:
    """The unit tangent in the direction of another one, and the sign of the determinant of the
    derivatives that it borders."""
    factors = Bordered(J, (problem.weights * like)[None])
    t = factors.solve(np.append(np.zeros(len(like) - 1), 1.0))
    return t / problem.length(t), factors.sign


def point_at(problem: Problem, found: Corrected, like: Array) -> Point:
    """A corrected point with its tangent, in the direction of another one, and its stability."""
    t, sign = tangent_at(problem, found.J, like)
    return Point(found.u, t, problem.unstable(found.u), sign, problem.measures(found.u))
