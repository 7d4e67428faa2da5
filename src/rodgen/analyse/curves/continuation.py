"""Pseudo-arclength continuation of a curve F(u) = 0 with its special points (H. B. Keller,
Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977).

A step goes along the tangent t and returns to the curve in the plane normal to it, by Newton's
method on F bordered by that plane. The bordered equations are regular at folds, too.
"""

from __future__ import annotations

from collections.abc import Callable
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
    point_at,
)
from rodgen.analyse.curves.journal import Step, current_journal
from rodgen.analyse.curves.special_points import find_special_points
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.progress import report_stage
from rodgen.result import Note, doubt

QUICK = 4  # iterations after which the next step is longer
STRAIGHT, TURNED = 0.98, 0.9  # cosine between two tangents: for a longer step, at least
ASTRAY = 0.5  # of a step, by which it may be corrected at most
BROKEN = (ArithmeticError, np.linalg.LinAlgError)  # AnalysisError, and numbers beyond range
FEW = 5  # points after which a branch may have closed in itself
# Of the longest step: over so short a one changes of stability, or of the sign of a determinant,
# may have no reason that was found.
RESOLVED, PASSED = 1 / 64, 1e-4
OFF = 1e-6  # by which the point of a file may be corrected


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


def start_point(problem: ContinuationProblem, u: Array, way: float = 1.0) -> CurvePoint:
    """Correct u at its parameter to the first point of a curve, with a tangent along which the
    parameter grows (way 1) or falls (-1). Raises AnalysisError where u is near no solution."""
    last = np.append(np.zeros(len(u) - 1), 1.0)
    found = correct(problem, u, last)
    point = point_at(problem, found, last)
    if point.tangent[-1] * way < 0:
        point = point._replace(tangent=-point.tangent, sign=-point.sign)
    return point


def resume_point(
    problem: ContinuationProblem, here: Array, other: Array | None, what: str
) -> CurvePoint:
    """Correct a point read from a file, with a tangent that leads away from another one; without
    that, the parameter grows. Raises AnalysisError, which names what the point should be, if it is
    no solution."""
    way = np.append(np.zeros(len(here) - 1), 1.0) if other is None else here - other
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
            if self._end_if_outward(here):
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

    def _end_if_outward(self, here: CurvePoint) -> bool:
        """Whether the tangent leads out of the range; the curve then ends at this point."""
        if not self._is_outward(here):
            return False
        self.curve.end, self.curve.complete = "the end of the range was reached", True
        return True

    def _is_outward(self, here: CurvePoint) -> bool:
        away = here.tangent[-1]
        return (here.value <= self.low and away < 0) or (here.value >= self.high and away > 0)

    def _check_end(self, point: CurvePoint, h: float) -> None:
        curve, start = self.curve, self.curve.points[0]
        if point.value in (self.low, self.high):
            curve.end, curve.complete = "the end of the range was reached", True
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
