"""Pseudo-arclength continuation of a curve F(u) = 0 with its special points, and
branch switching at these (H. B. Keller,
Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977).

A step goes along the tangent t and returns to the curve in the plane normal to it, by Newton's
method on F bordered by that plane. The bordered equations are regular at folds, too.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from rodgen.analyse.analysis_guard import check_positive, check_whole_number
from rodgen.analyse.curves.curve import (
    BRANCH,
    FOLD,
    ContinuationProblem,
    Curve,
    CurvePoint,
    SpecialPoint,
    correct,
    follow_both_ways,
    point_at,
)
from rodgen.analyse.curves.journal import Step, current_journal
from rodgen.analyse.curves.special_points import find_special_points
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.progress import report_stage
from rodgen.result import Note, doubt

END_OF_RANGE = "the end of the range was reached"
QUICK = 4  # iterations after which the next step is longer
STRAIGHT, TURNED = 0.98, 0.9  # cosine between two tangents: for a longer step, at least
ASTRAY = 0.5  # of a step, by which it may be corrected at most
BROKEN = (ArithmeticError, np.linalg.LinAlgError)  # AnalysisError, and numbers beyond range
FEW = 5  # points after which a branch may have closed in itself
# Of the longest step: over so short a one changes of stability, or of the sign of a determinant,
# may have no reason that was found.
RESOLVED, PASSED = 1 / 64, 1e-4


@dataclass(frozen=True)
class StepControl:
    """First, least and longest step along a curve, and the largest number of its points."""

    first: float = 0.02
    least: float = 1e-9
    longest: float = 0.1
    max_points: int = 2000

    @classmethod
    def of(cls, step: float, max_points: int, parts: int, least: float = 1e-9) -> StepControl:
        """Check the longest step and the largest number of points that a user gives. The first step
        is the longest over `parts`. Raises InputError."""
        step = check_positive(step, "step", "a number above 0 and at most 1", 1.0)
        max_points = check_whole_number(max_points, "max_points", 2)
        return cls(first=step / parts, least=least, longest=step, max_points=max_points)


def continue_curve(
    problem: ContinuationProblem,
    start: CurvePoint,
    low: float,
    high: float,
    steps: StepControl | None = None,
    callback: Callable[[CurvePoint], None] = lambda point: None,
    until: Callable[[Curve], str] = lambda curve: "",
) -> Curve:
    """Follow a curve from a point along its tangent, while the parameter is within low and high.

    callback: called with every point; until: returns why the curve so far is complete, or nothing.
    A step is taken if the correction is short, the
    tangent turns little and the number of unstable directions changes as the special points on the
    way explain. Otherwise it is halved, so that the curve does not jump to another branch. ``end``
    says why the curve stops. What was found is kept, also on Ctrl-C.
    """
    return _Follower(problem, steps or StepControl(), low, high, callback, until).follow(start)


class _Follower:
    def __init__(
        self,
        problem: ContinuationProblem,
        steps: StepControl,
        low: float,
        high: float,
        callback: Callable[[CurvePoint], None],
        until: Callable[[Curve], str],
    ):
        self.problem, self.steps, self.low, self.high = problem, steps, low, high
        self.callback, self.until = callback, until
        self.curve, self.why, self.before = Curve(), "", 0

    def follow(self, start: CurvePoint) -> Curve:
        curve = self.curve
        curve.points.append(start)
        try:
            self._take_steps(start)
        except KeyboardInterrupt:
            curve.end, curve.interrupted = "it was interrupted", True
        except (*BROKEN, InputError) as error:
            curve.end = str(error)
        if not curve.complete:
            curve.end += f" at {self.problem.value(curve.points[-1].u):.9g}"
        return curve

    def _take_steps(self, start: CurvePoint) -> None:
        steps, curve = self.steps, self.curve
        self._visit(start)
        h, journal = min(steps.first, steps.longest), current_journal()
        if journal is not None:
            journal.begin(self.problem, start)
        while not curve.end:
            here = curve.points[-1]
            if self._is_outward(here):
                curve.end, curve.complete = END_OF_RANGE, True
                break
            step = None if journal is None else journal.next_step()
            if step is None:
                step = self._advance(here, h)
                if step is None:
                    why = self.why or "no solution"
                    curve.end = f"the step along the branch shrank to nothing ({why})"
                    break
                if journal is not None:
                    journal.add(step)
            h, self.before = step.h, step.before
            curve.special += step.special
            curve.notes += step.notes
            curve.points.append(step.point)
            report_stage(f"{len(curve.points)} points")
            self._visit(step.point)
            self._check_end(step.point, h)

    def _visit(self, point: CurvePoint) -> None:
        self.problem.adapt_to(point.u)
        self.callback(point)

    def _advance(self, here: CurvePoint, h: float) -> Step | None:
        """Take a step of length h or a shorter one; None if the least one fails."""
        while (step := self._try_step(here, h)) is None:
            h /= 2
            if h < self.steps.least:
                return None
        return step

    def _is_outward(self, here: CurvePoint) -> bool:
        away = here.tangent[-1]
        return (here.value <= self.low and away < 0) or (here.value >= self.high and away > 0)

    def _check_end(self, point: CurvePoint, h: float) -> None:
        curve, start = self.curve, self.curve.points[0]
        if point.value in (self.low, self.high):
            curve.end, curve.complete = END_OF_RANGE, True
        elif why := self.until(curve):
            curve.end, curve.complete = why, True
        elif len(curve.points) >= self.steps.max_points:
            curve.end = f"{self.steps.max_points} points were computed"
        elif len(curve.points) > FEW and self._is_closed(point, start, h):
            curve.points.append(start)
            curve.end, curve.complete = "the branch closes in itself", True

    def _is_closed(self, point: CurvePoint, start: CurvePoint, h: float) -> bool:
        """Whether the curve closes: it passes its start, near to it and in the same direction."""
        near, before = self.problem.length(point.u - start.u) < h, self.curve.points[-2]
        ahead = self._cosine(before.tangent, start.u - before.u) > 0
        return near and ahead and self._cosine(point.tangent, start.tangent) > TURNED

    def _cosine(self, a: Array, b: Array) -> float:
        return float(a @ (self.problem.weights * b))

    def _try_step(self, here: CurvePoint, h: float) -> Step | None:
        """Try a step of length h; None where it is too long."""
        problem, steps, t = self.problem, self.steps, here.tangent
        guess, row = here.u + h * t, problem.weights * t
        bound = self.high if t[-1] > 0 else self.low
        beyond = (guess[-1] - bound) * np.sign(t[-1]) > 0
        if beyond:  # the last step ends at the end of the range
            h = (bound - here.value) / t[-1]
            guess = here.u + h * t
            row = np.append(np.zeros(len(t) - 1), 1.0)
        try:
            found = correct(problem, guess, row)
            if not beyond and (found.u[-1] - bound) * (here.value - bound) < 0:  # not by its guess
                beyond = True
                guess = np.append(found.u[:-1], bound)
                found = correct(problem, guess, np.append(np.zeros(len(t) - 1), 1.0))
            if problem.length(found.u - guess) > ASTRAY * h:
                self.why = "the next point lies off its tangent"
                return None
            if beyond:
                found.u[-1] = bound
            point = point_at(problem, found, t)
        except BROKEN as error:
            self.why = str(error)
            return None
        turned = self._cosine(t, point.tangent)
        if turned < TURNED:
            self.why = "its direction jumps"
            return None
        if not point.sign:
            self.why = "the equations are singular"
            return None
        special, note, least, before = self._compare(here, point)
        if note is not None and h > least * steps.longest:
            return None
        length = h
        if found.iterations <= QUICK and turned > STRAIGHT:
            length = min(2 * h, steps.longest)
        elif turned < STRAIGHT:
            length = max(0.7 * h, steps.least)
        return Step(point, special, [] if note is None else [note], length, before)

    def _compare(
        self, a: CurvePoint, b: CurvePoint
    ) -> tuple[list[SpecialPoint], Note | None, float, int]:
        """Compare two points. Returns the special points between them, in order; a doubt, if the
        second may lie on another branch; the share of the longest step down to which that asks for
        a shorter step; and how many changes of stability are explained but not seen yet."""
        after, value = len(self.curve.points) - 1, self.problem.value(b.u)
        try:
            found = find_special_points(self.problem, a, b)
        except AnalysisError as error:
            words = f"next to {value:.9g} another branch may be met: {error}"
            return [], doubt(words, value=value), PASSED, self.before
        special = [one._replace(after=after) for one in found]
        if a.unstable is None or b.unstable is None:
            return special, None, RESOLVED, self.before
        real = sum(one.kind in (FOLD, BRANCH) for one in special)
        changed = abs(b.unstable - a.unstable)
        explained = real + 2 * (len(special) - real)
        # What lies next to a point may be seen in its sign, and in its stability a step later.
        if changed <= explained + self.before:
            return special, None, RESOLVED, max(explained - changed, 0)
        words = f"next to {value:.9g} the number of unstable directions changes from "
        words += f"{a.unstable} to {b.unstable} where no special point was found"
        note = doubt(words, value=value, before=a.unstable, after=b.unstable)
        return special, note, RESOLVED, self.before


def select_special(
    found: Sequence[SpecialPoint], number: object, kinds: Collection[str] = (BRANCH,)
) -> SpecialPoint:
    """Select a special point of these kinds by its number, from 1. Raises InputError."""
    count = len(found)
    what = f"the number of a special point of the branch, 1 to {count}"
    what = what if count else "absent: no special point was found"
    special = found[check_whole_number(number, "branch_point", 1, count, what) - 1]
    if special.kind not in kinds:
        names = ", ".join(f"{at}: {one.kind}" for at, one in enumerate(found, 1))
        raise InputError(
            "branch_point", number, f"a {' or '.join(kinds)} point (there are {names})"
        )
    return special


def switch_branch(
    problem: ContinuationProblem,
    special: SpecialPoint,
    bounds: tuple[float, float],
    steps: StepControl,
    callback: Callable[[CurvePoint], None] = lambda point: None,
) -> Curve:
    """Follow the other branch through a branch point, both ways, until it leaves the range."""
    assert special.ways is not None
    other = special.ways[1]

    def follow(way: float) -> Curve:
        start = CurvePoint(special.u, way * other, None, 0)
        return continue_curve(problem, start, *bounds, steps, callback=callback)

    curve = follow_both_ways(follow)
    (*_, at) = (number for number, point in enumerate(curve.points) if point.u is special.u)
    return insert_special(curve, at, special)


def insert_special(curve: Curve, at: int, special: SpecialPoint) -> Curve:
    """Enter in a curve the special point of its parent, which is its point number `at`."""
    # What neither grows nor decays in the branch point would be counted by its rounding.
    beside = curve.points[at - 1 : at] + curve.points[at + 1 : at + 2]
    unstable = min((one.unstable for one in beside if one.unstable is not None), default=None)
    curve.points[at] = curve.points[at]._replace(unstable=unstable)
    curve.special = sorted(
        [*curve.special, special._replace(after=max(at - 1, 0))], key=lambda one: one.after
    )
    return curve
