"""Other branches through the special points of a curve."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from rodgen.analyse.curves.continuation import Steps, continued
from rodgen.analyse.curves.curve import BRANCH, Curve, Point, Problem, Special, both_ways
from rodgen.errors import InputError
from rodgen.scene.plain import plain


def chosen(found: Sequence[Special], switch: object, kinds: Collection[str] = (BRANCH,)) -> Special:
    """The special point of a number, 1 is the first, of one of these kinds. Raises InputError."""
    number = plain(switch, "switch")
    count = len(found)
    if not isinstance(number, int) or isinstance(number, bool) or not 1 <= number <= count:
        what = f"the number of a special point of the branch, 1 to {count}"
        raise InputError("switch", switch, what if count else "absent: no special point was found")
    special = found[number - 1]
    if special.kind not in kinds:
        names = ", ".join(f"{at}: {one.kind}" for at, one in enumerate(found, 1))
        raise InputError("switch", switch, f"a {' or '.join(kinds)} point (there are {names})")
    return special


def switched(
    problem: Problem,
    special: Special,
    bounds: tuple[float, float],
    steps: Steps,
    watch: Callable[[Point], None] = lambda point: None,
) -> Curve:
    """The other branch through a branch point, from where it leaves the range to where it does so
    again."""
    assert special.ways is not None
    other = special.ways[1]

    def follow(way: float) -> Curve:
        start = Point(special.u, way * other, None, 0, {})
        return continued(problem, start, *bounds, steps, watch=watch)

    curve = both_ways(follow)
    (*_, at) = (number for number, point in enumerate(curve.points) if point.u is special.u)
    return entered(curve, at, special)


def entered(curve: Curve, at: int, special: Special) -> Curve:
    """A curve that goes through a special point of another one in its point of a number."""
    # What neither grows nor decays in the branch point would be counted by its rounding.
    beside = curve.points[at - 1 : at] + curve.points[at + 1 : at + 2]
    unstable = min((one.unstable for one in beside if one.unstable is not None), default=None)
    curve.points[at] = curve.points[at]._replace(unstable=unstable)
    curve.special = sorted(
        [*curve.special, special._replace(after=max(at - 1, 0))], key=lambda one: one.after
    )
    return curve
