"""Branch switching: from a special point of a curve to the other branch."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from rodgen.analyse.analysis_guard import check_whole_number
from rodgen.analyse.curves.continuation import StepControl, continue_curve
from rodgen.analyse.curves.curve import (
    BRANCH,
    ContinuationProblem,
    Curve,
    CurvePoint,
    SpecialPoint,
    follow_both_ways,
)
from rodgen.errors import InputError


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
