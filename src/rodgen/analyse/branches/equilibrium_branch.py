"""Branches of equilibria and of steady motions, followed along one number of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.branches.equilibria import Equilibria, equilibria
from rodgen.analyse.branches.small_motions import MODES, MOST_DENSE, Growing
from rodgen.analyse.branches.variable import SAME, WHOLE, Key
from rodgen.analyse.curves.continuation import Steps, continued, started
from rodgen.analyse.curves.curve import BRANCH, Curve, Point, Special, corrected, point_at
from rodgen.analyse.errors import AnalysisError, guarded
from rodgen.analyse.statics import settle
from rodgen.analyse.steady import Steady, steady
from rodgen.analyse.system import System, Unknowns
from rodgen.scene import Scene, SceneError
from rodgen.scene.keys import with_value
from rodgen.scene.plain import is_number, plain

if TYPE_CHECKING:
    import xarray

    from rodgen.analyse.branches.branch_data import Recorded

STEP = 0.02  # of the range, or rad: the longest along a branch
MOST = 2000  # points
CHECKED = 5  # points of a branch of which all modes are looked at
ASTRAY = 1e-6  # by which a state of a file may be corrected


@dataclass(frozen=True)
class Branch:
    """A curve of steady states of a scene; number: of the branch point that it leaves, or 0."""

    scene: Scene
    key: str
    problem: Equilibria
    curve: Curve
    number: int = 0

    def state(self, point: Point | Special) -> Steady:
        """The steady state at a point."""
        return self.problem.steady(point.u)


@guarded
def continue_equilibria(
    scene: Scene,
    key: str,
    ends: tuple[float, float],
    *,
    start: float | None = None,
    switch: int | None = None,
    resume: xarray.Dataset | None = None,
    at: int = -1,
    imperfection: float | None = None,
    step: float = STEP,
    most: int = MOST,
    t: float | None = None,
    watch: Callable[[float], None] = lambda value: None,
) -> xarray.Dataset:
    """The branch of equilibria, or of steady motions, on which a scene is, along one number of it.

    key: the number, named as in a study, such as loads.follower.force; ends: between which it is
    varied. The branch begins at the first end and is followed to where it leaves the range,
    through folds. start: another value in the range to begin at, from which it is followed both
    ways; switch: follow, instead of it, the other branch, both ways, from the branch point of this
    number (1 is the first); resume: a branch of the same scene and key of which point ``at`` is
    gone on from, in its direction; imperfection: begin with the bent equilibrium that
    `static_equilibrium` finds with it; step: the longest, as a share of the range and in rad of
    the mean square of all angles; most: points; t: time whose loads are taken [s]; watch: called
    with every value.

    The Dataset has one dimension along the branch: value, unstable (how many directions are
    unstable, -1 where that is not known), tip [m], phi [rad]; and special points, special_kind
    "branch", "fold" or "hopf" with special_value, special_frequency [Hz] and special_after, the
    point that each comes after. Its attributes say where it ends and why. Raises SceneError for
    what cannot be varied so, AnalysisError where nothing is found to start with.
    """
    from rodgen.analyse.branches.branch_data import dataset, recorded

    low, high = _range(key, ends)
    begin = low if start is None else _inside("start", start, ends)
    before = None if resume is None else recorded(resume, scene, key, at)
    if before is not None:
        begin = before.value
    steps = Steps.of(step, most, 4)
    problem, first = _prepared(scene, key, ends, begin, imperfection, t)
    branch = Branch(scene, key, problem, Curve())

    def seen(point: Point) -> None:
        watch(problem.value(point.u))

    def walk(problem: Equilibria) -> Curve:
        bounds = problem.scaled(min(low, high)), problem.scaled(max(low, high))
        if before is not None:
            point = _taken_up(problem, before)
            return continued(problem, point, *bounds, steps, watch=seen)
        u = problem.packed(first, begin)
        way = float(np.sign(high - low))
        made = continued(problem, started(problem, u, way), *bounds, steps, watch=seen)
        if start is None or begin in (low, high):
            return made
        back = continued(problem, started(problem, u, -way), *bounds, steps, watch=seen)
        return _joined(back, made)

    curve = walk(problem)
    if not _counted(problem, curve):  # in too few modes
        problem = equilibria(problem.variable, first, True)
        curve = walk(problem)
    if switch is not None:
        special = _chosen(curve, switch)
        bounds = problem.scaled(min(low, high)), problem.scaled(max(low, high))
        curve = switched(problem, special, bounds, steps, seen)
    branch = Branch(scene, key, problem, curve, switch or 0)
    return dataset(branch)


def switched(
    problem: Equilibria,
    special: Special,
    bounds: tuple[float, float],
    steps: Steps,
    watch: Callable[[Point], None] = lambda point: None,
) -> Curve:
    """The other branch through a branch point, from where it leaves the range to where it does so
    again."""
    assert special.ways is not None
    unstable = problem.unstable(special.u)
    ways = [Point(special.u, sign * special.ways[1], None, 0, {}) for sign in (-1.0, 1.0)]
    back, made = (
        continued(problem, way._replace(unstable=None), *bounds, steps, watch=watch) for way in ways
    )
    curve = _joined(back, made)
    at = len(back.points) - 1
    curve.points[at] = curve.points[at]._replace(unstable=unstable)
    curve.special = sorted(
        [*curve.special, special._replace(after=max(at - 1, 0))], key=lambda one: one.after
    )
    return curve


def _joined(back: Curve, on: Curve) -> Curve:
    """Two curves that begin at one point as one."""
    back = back.backwards()
    more = len(back.points) - 1
    special = [one._replace(after=one.after + more) for one in on.special]
    ends = f"{back.end}; on the other side {on.end}" if back.end != on.end else on.end
    return Curve(
        back.points[:-1] + on.points,
        back.special + special,
        ends,
        back.complete and on.complete,
        back.notes + on.notes,
    )


def _prepared(
    scene: Scene,
    key: str,
    ends: tuple[float, float],
    begin: float,
    imperfection: float | None,
    t: float | None,
) -> tuple[Equilibria, Steady]:
    """The problem, and the steady state at the value at which it begins."""
    if key in WHOLE:
        raise SceneError("vary", key, SAME)
    here = with_value(scene, key, begin)
    system = System.of(here, t)
    variable = Key(system, scene, key, ends)
    first = steady(system) if imperfection is None else _bent(system, imperfection)
    return equilibria(variable, first), first


def _bent(system: System, imperfection: float) -> Steady:
    from rodgen.analyse.pencil import forces
    from rodgen.analyse.statics import checked_imperfection

    p = system.parameters()
    rest, _ = settle(system, system.given, bend=checked_imperfection(imperfection))
    return Steady(system, rest.at._replace(force=forces(system, rest.at, p)[1]), p)


def _taken_up(problem: Equilibria, before: Recorded) -> Point:
    """The point of a file, on its branch, in its direction. Raises AnalysisError where it is no
    solution."""
    system = problem.variable.system(before.value)
    states = [
        Steady(system, Unknowns(*parts), problem.variable.parameters(before.value))
        for parts in before.states
    ]
    here, *others = [
        problem.packed(state, value)
        for state, value in zip(states, (before.value, *before.others), strict=True)
    ]
    way = (here - others[0]) if others else np.append(np.zeros(len(here) - 1), 1.0)
    way = way / problem.length(way)
    row = problem.weights * way
    try:
        found = corrected(problem, here, row)
        astray = problem.length(found.u - here)
    except AnalysisError:
        astray = np.inf
    if astray > ASTRAY:
        raise AnalysisError(
            f"point {before.number} of the file is no equilibrium of this scene"
            f" (Newton's method leads {astray:.1e} away from it)"
        )
    return point_at(problem, found, way)


def _counted(problem: Equilibria, curve: Curve) -> bool:
    """Whether all modes tell the same numbers of unstable directions as the lowest do, in a few
    points and beside special ones."""
    cells = problem.variable.base.cells
    if not MODES < cells <= MOST_DENSE:
        return True
    last = len(curve.points) - 1
    looked = {*np.linspace(0, last, CHECKED).astype(int).tolist()}
    looked |= {min(one.after + at, last) for one in curve.special for at in (0, 1)}
    for at in sorted(looked):
        point = curve.points[at]
        if point.unstable is None:
            continue
        state = problem.steady(point.u)
        if Growing(state, True).count(state) != point.unstable:
            return False
    return True


def _chosen(curve: Curve, switch: int) -> Special:
    number = plain(switch, "switch")
    count = len(curve.special)
    if not isinstance(number, int) or isinstance(number, bool) or not 1 <= number <= count:
        what = f"the number of a special point of the branch, 1 to {count}"
        raise SceneError("switch", switch, what if count else "absent: no special point was found")
    special = curve.special[number - 1]
    if special.kind != BRANCH or special.ways is None:
        names = [f"{at}: {one.kind}" for at, one in enumerate(curve.special, 1)]
        raise SceneError("switch", switch, f"a branch point (there are {', '.join(names)})")
    return special


def _range(key: str, ends: tuple[float, float]) -> tuple[float, float]:
    try:
        low, high = plain(list(ends), key)
    except (TypeError, ValueError):
        raise SceneError(f"vary.{key}", ends, "two numbers: from where to where") from None
    for value in (low, high):
        if not (is_number(value) and np.isfinite(value)):
            raise SceneError(f"vary.{key}", value, "a finite number")
    return float(low), float(high)


def _inside(name: str, value: Any, ends: tuple[float, float]) -> float:
    value = plain(value, name)
    low, high = sorted(ends)
    if not (is_number(value) and low <= value <= high):
        raise SceneError(name, value, f"a number in the range, {low:g} to {high:g}")
    return float(value)
