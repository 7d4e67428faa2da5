"""Pseudo-arclength continuation of a curve F(u) = 0 with its special points (H. B. Keller,
Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977).

A step goes along the tangent t and comes back to the curve in the plane across it, by Newton's
method on F bordered by that plane, which is regular in folds too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rodgen.analyse.curves.curve import (
    BRANCH,
    FOLD,
    Curve,
    Point,
    Problem,
    Special,
    corrected,
    point_at,
)
from rodgen.analyse.curves.journal import Step, current
from rodgen.analyse.curves.special_points import between
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.progress import tell
from rodgen.result import Note, doubt
from rodgen.scene.plain import is_number, plain

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
class Steps:
    """first, least and longest step along the curve; most points."""

    first: float = 0.02
    least: float = 1e-9
    longest: float = 0.1
    most: int = 2000

    @classmethod
    def of(cls, step: float, most: int, parts: int, least: float = 1e-9) -> Steps:
        """The longest step and most points that were asked for; parts: of the longest, the first.
        Raises InputError."""
        step, most = plain(step, "step"), plain(most, "most")
        if not (is_number(step) and 0 < step <= 1):
            raise InputError("step", step, "a number above 0 and at most 1")
        if not isinstance(most, int) or isinstance(most, bool) or most < 2:
            raise InputError("most", most, "a whole number of at least 2")
        return cls(first=step / parts, least=least, longest=step, most=most)


def started(problem: Problem, u: Array, way: float = 1.0) -> Point:
    """The point at the parameter of u, which is close to it, with its tangent so that the
    parameter grows (way 1) or falls (-1). Raises AnalysisError where u is next to no solution."""
    last = np.append(np.zeros(len(u) - 1), 1.0)
    found = corrected(problem, u, last)
    point = point_at(problem, found, last)
    if point.tangent[-1] * way < 0:
        point = point._replace(tangent=-point.tangent, sign=-point.sign)
    return point


def taken_up(problem: Problem, here: Array, other: Array | None, what: str) -> Point:
    """A point of a file, which is next to the curve, and its direction away from another one; the
    parameter grows from one that was alone. Raises AnalysisError, which says what it is to be,
    where it is no solution."""
    way = np.append(np.zeros(len(here) - 1), 1.0) if other is None else here - other
    way = way / problem.length(way)
    try:
        found = corrected(problem, here, problem.weights * way)
        astray = problem.length(found.u - here)
    except AnalysisError:
        astray = np.inf
    if astray > OFF:
        raise AnalysisError(
            f"the point of the file is no {what} of this scene"
            f" (Newton's method leads {astray:.1e} away from it)"
        )
    return point_at(problem, found, way)


def continued(
    problem: Problem,
    start: Point,
    low: float,
    high: float,
    steps: Steps | None = None,
    first: float | None = None,
    watch: Callable[[Point], None] = lambda point: None,
    until: Callable[[Curve], str] = lambda curve: "",
) -> Curve:
    """The curve from a point on along its tangent, while its parameter is within low and high.

    first: the first step, if not that of steps; watch: called with every point; until: says why
    the curve so far need not be followed on, or nothing. A step is taken
    where the correction is short, the tangent turns little and the number of unstable directions
    changes as the special points found on the way tell, else it is halved, so that no other branch
    is jumped to. What was found so far is kept where it ends, by Ctrl-C too; why is told by
    ``end``.
    """
    return _Walk(problem, steps or Steps(), low, high, watch, until).from_(start, first)


class _Walk:
    def __init__(
        self,
        problem: Problem,
        steps: Steps,
        low: float,
        high: float,
        watch: Callable[[Point], None],
        until: Callable[[Curve], str],
    ):
        self.problem, self.steps, self.low, self.high = problem, steps, low, high
        self.watch, self.until = watch, until
        self.curve, self.why, self.before = Curve(), "", 0

    def from_(self, start: Point, first: float | None) -> Curve:
        curve = self.curve
        curve.points.append(start)
        try:
            self._walked(start, first)
        except KeyboardInterrupt:
            curve.end, curve.interrupted = "it was interrupted", True
        except (*BROKEN, InputError) as error:
            curve.end = str(error)
        if not curve.complete:
            curve.end += f" at {self.problem.value(curve.points[-1].u):.9g}"
        return curve

    def _walked(self, start: Point, first: float | None) -> None:
        steps, curve = self.steps, self.curve
        self.watch(start)
        h, journal = min(first or steps.first, steps.longest), current()
        if journal is not None:
            journal.begin(self.problem, start)
        while not curve.end:
            here = curve.points[-1]
            if self._leaves(here):
                break
            step = None if journal is None else journal.next()
            if step is None:
                step = self._advanced(here, h)
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
            tell(f"{len(curve.points)} points")
            self.watch(step.point)
            self._finish(step.point, h)

    def _advanced(self, here: Point, h: float) -> Step | None:
        """A step from a point on, of this length or a shorter one; None where none is taken."""
        while (step := self._step(here, h)) is None:
            h /= 2
            if h < self.steps.least:
                return None
        return step

    def _leaves(self, here: Point) -> bool:
        """Whether the curve ends at the start, as its tangent leads out of the range."""
        if not self._outward(here):
            return False
        self.curve.end, self.curve.complete = "the end of the range was reached", True
        return True

    def _outward(self, here: Point) -> bool:
        away = here.tangent[-1]
        return (here.value <= self.low and away < 0) or (here.value >= self.high and away > 0)

    def _finish(self, point: Point, h: float) -> None:
        curve, start = self.curve, self.curve.points[0]
        if point.value in (self.low, self.high):
            curve.end, curve.complete = "the end of the range was reached", True
        elif why := self.until(curve):
            curve.end, curve.complete = why, True
        elif len(curve.points) >= self.steps.most:
            curve.end = f"{self.steps.most} points were computed"
        elif len(curve.points) > FEW and self._returns(point, start, h):
            curve.points.append(start)
            curve.end, curve.complete = "the branch closes in itself", True

    def _returns(self, point: Point, start: Point, h: float) -> bool:
        """Whether a point lies beside the start, which was ahead until then, and goes its way."""
        near, before = self.problem.length(point.u - start.u) < h, self.curve.points[-2]
        ahead = self._cosine(before.tangent, start.u - before.u) > 0
        return near and ahead and self._cosine(point.tangent, start.tangent) > TURNED

    def _cosine(self, a: Array, b: Array) -> float:
        return float(a @ (self.problem.weights * b))

    def _step(self, here: Point, h: float) -> Step | None:
        """The next point, and what lies on the way; None where the step is too long."""
        problem, steps, t = self.problem, self.steps, here.tangent
        guess, row = here.u + h * t, problem.weights * t
        bound = self.high if t[-1] > 0 else self.low
        beyond = (guess[-1] - bound) * np.sign(t[-1]) > 0
        if beyond:  # the last step ends at the end of the range
            h = (bound - here.value) / t[-1]
            guess = here.u + h * t
            row = np.append(np.zeros(len(t) - 1), 1.0)
        try:
            found = corrected(problem, guess, row)
            if not beyond and (found.u[-1] - bound) * (here.value - bound) < 0:  # not by its guess
                beyond = True
                guess = np.append(found.u[:-1], bound)
                found = corrected(problem, guess, np.append(np.zeros(len(t) - 1), 1.0))
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
        special, note, least, before = self._between(here, point)
        if note is not None and h > least * steps.longest:
            return None
        length = h
        if found.iterations <= QUICK and turned > STRAIGHT:
            length = min(2 * h, steps.longest)
        elif turned < STRAIGHT:
            length = max(0.7 * h, steps.least)
        return Step(point, special, [] if note is None else [note], length, before)

    def _between(self, a: Point, b: Point) -> tuple[list[Special], Note | None, float, int]:
        """Special points between two points, in order, why the second may be of another branch,
        down to which share of the longest step that is a reason for a shorter one, and how many
        wait for the change of stability that they explain."""
        after, value = len(self.curve.points) - 1, self.problem.value(b.u)
        try:
            found = between(self.problem, a, b)
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
