"""Where along a branch a small motion begins or ceases to grow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rodgen.analyse.curves.curve import BRANCH, Point, Special, corrected
from rodgen.analyse.curves.special_points import on_chord
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.modal import arising
from rodgen.analyse.onset import Onset, onset
from rodgen.analyse.pencil import Linear, Parts, Pencil
from rodgen.analyse.steady import linearised
from rodgen.integrate.stepper import Array

if TYPE_CHECKING:
    from rodgen.analyse.branches.equilibria import Equilibria

HOPF = "hopf"
SLOWEST = 1e-3  # of the rate beside it, over 2 pi: a motion that is slower there has none
PARTS = 1 / 2, 1 / 4, 3 / 4  # of what is left, of which one is tried after the other
CLOSE = 1e-5  # of the way between two points, to which a crossing is narrowed


def crossing(problem: Equilibria, a: Point, b: Point) -> list[Special]:
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


def solved(problem: Equilibria, near: Point, s: complex) -> Special:
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
