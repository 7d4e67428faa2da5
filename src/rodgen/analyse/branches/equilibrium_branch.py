"""Branches of equilibria and of steady motions, followed along one number of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.bounds import bounds_of
from rodgen.analyse.branches.branch_data import Branch, Recorded, dataset, recorded
from rodgen.analyse.branches.equilibria import Equilibria, is_doubted
from rodgen.analyse.branches.equilibrium_problems import equilibria
from rodgen.analyse.branches.motions import Motions, begun, motion_of
from rodgen.analyse.curves.continuation import Steps, continued, taken_up
from rodgen.analyse.curves.curve import (
    Curve,
    Point,
    Special,
    both_ways,
    corrected,
    point_at,
)
from rodgen.analyse.curves.datasets import extended, kept
from rodgen.analyse.curves.special_points import branch_point
from rodgen.analyse.curves.switching import chosen, switched
from rodgen.analyse.curves.twice import compared, twice
from rodgen.analyse.guard import guarded
from rodgen.analyse.rod_range import RodRange
from rodgen.analyse.settle import checked_imperfection, settle
from rodgen.analyse.sizes import BRANCH, check_size
from rodgen.analyse.steady import Steady, steady
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.scene.plain import is_number, plain
from rodgen.system import ParameterRange, System, start_at

if TYPE_CHECKING:
    import xarray

STEP = 0.02  # of the range, or rad: the longest along a branch
MOST = 2000  # points
DOUBTED = "what was counted is not what the eigenvalues of the linearised equations say"


@guarded
def continue_equilibria(
    system: System | Scene,
    key: str,
    bounds: tuple[float, float],
    *,
    start: float | None = None,
    switch: int | None = None,
    resume: xarray.Dataset | None = None,
    at: int = -1,
    imperfection: float | None = None,
    motion: str | None = None,
    step: float = STEP,
    most: int = MOST,
    t: float | None = None,
    check_mesh: bool = False,
    watch: Callable[[float], None] = lambda value: None,
) -> xarray.Dataset:
    """Follow a branch of equilibria, or of steady motions, while one number of a scene changes.

    The branch begins at the first value. It is followed through folds until it leaves the range.

    Parameters
    ----------
    system
        The scene, or a System.
    key
        The number, named as in a study, such as loads.follower.force.
    bounds
        First and last value of the number, in SI units.
    start
        A value within the range, in SI units. The branch begins there and is followed both ways.
    switch
        Number of a branch point, from 1. The other branch through it is followed, both ways.
    resume, at
        An earlier branch of the same scene and key, which is continued from its point ``at``.
    imperfection
        Begin with the bent equilibrium that `static_equilibrium` finds with this imperfection
        [rad].
    motion
        Follow steady motions of a rod that nothing holds in place: bent or straight, accelerated,
        dragged, turning. "initial" begins with the motion near the scene's initial state, "run"
        with the motion to which a run over the span leads.
    step
        Length of the longest step: a share of the range (dimensionless), and the root mean square
        of all angles [rad].
    most
        Largest number of points.
    t
        Time whose loads are taken [s].
    check_mesh
        Also compute the same with twice as many links, and say in the notes what changes by more
        than 1 %.
    watch
        A function that is called with every value, in SI units.

    Returns
    -------
    xarray.Dataset
        One dimension along the branch: value, unstable (how many directions are unstable, -1 where
        that is not known), tip [m], phi [rad], of steady motions turning [rad/s]; and special
        points, special_kind "branch", "fold" or "hopf" with special_value, special_frequency [Hz]
        and special_after, the point that each comes after. Its attributes say where it ends and
        why.

    Raises
    ------
    InputError
        For a key that cannot be varied, and for values that are not allowed.
    AnalysisError
        If there is no state to start with.
    BranchInterrupted
        On Ctrl-C. It carries the points so far.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("euler_column")
    >>> branch = rodgen.continue_equilibria(scene, "loads.tip.y", (0, -30))
    >>> branch.special_kind.values.tolist(), branch.special_value.values.round(2).tolist()
    (['branch', 'branch'], [-2.47, -22.18])
    """
    system = System.of(system)
    check_size(BRANCH, system, whole=motion is not None)
    scene = system.scene
    if check_mesh:
        if resume is not None:
            raise InputError("check_mesh", True, "absent beside resume")
        beside = twice(scene, key)
    low, high = bounds = bounds_of(bounds)
    begin = low if start is None else _inside("start", start, bounds)
    before = None if resume is None else recorded(resume, scene, key, at)
    if before is not None:
        begin = before.values[0]
    steps = Steps.of(step, most, 4)
    problem = _prepared(system, key, bounds, begin, imperfection, motion, before, t)
    first = problem.start
    branch = Branch(scene, key, problem, Curve())

    def seen(point: Point) -> None:
        watch(problem.value(point.u))

    def walk(problem: Equilibria) -> Curve:
        scaled = problem.scaled(min(low, high)), problem.scaled(max(low, high))
        if before is not None:
            point = _taken_up(problem, before)
            return continued(problem, point, *scaled, steps, watch=seen)
        u = problem.packed(first, begin)
        onward = float(np.sign(high - low))

        def follow(way: float) -> Curve:
            return continued(
                problem, problem.first_point(u, way * onward), *scaled, steps, watch=seen
            )

        return follow(1.0) if start is None or begin in (low, high) else both_ways(follow)

    curve = walk(problem)
    if not curve.interrupted and is_doubted(problem, curve):  # in too few modes
        problem = equilibria(problem.along, first, True)
        curve = walk(problem)
        if not curve.interrupted and is_doubted(problem, curve):
            problem.leave_stability(DOUBTED)
            curve = walk(problem)
    if switch is not None and not curve.interrupted:
        problem, special = _entered(problem, curve, chosen(curve.special, switch))
        scaled = problem.scaled(min(low, high)), problem.scaled(max(low, high))
        curve = switched(problem, special, scaled, steps, seen)
        branch = replace(branch, number=switch)

    def whole() -> xarray.Dataset:
        found = dataset(replace(branch, problem=problem, curve=curve))
        return found if resume is None else extended(resume, at, found)

    found = kept(curve, whole)
    if not check_mesh:
        return found

    def follow_twice() -> xarray.Dataset:
        given: dict[str, Any] = {"start": start, "switch": switch, "imperfection": imperfection}
        given |= {"motion": motion, "step": step, "most": most, "t": t}
        return continue_equilibria(beside, key, bounds, **given)

    return compared(found, scene.rod.links, follow_twice)


def _prepared(
    system: System,
    key: str,
    bounds: tuple[float, float],
    begin: float,
    imperfection: float | None,
    motion: str | None,
    before: Recorded | None,
    t: float | None,
) -> Equilibria:
    """The problem, about the steady state at the value at which it begins."""
    start = start_at(system, key, begin)
    values = ParameterRange(start.steady(t), key, bounds)
    rod = SteadyRod.of(values.system)
    along = RodRange(rod, values)
    if before is not None and before.moving:
        return Motions(along, motion_of(rod, rod.system.p, before.states[0][0]))
    if motion is not None:
        return begun(start, rod, along, motion, begin)
    first = steady(rod) if imperfection is None else _bent(rod, imperfection)
    return equilibria(along, first)


def _entered(problem: Equilibria, curve: Curve, special: Special) -> tuple[Equilibria, Special]:
    """The branch point with both ways out of it, and the problem that has them: where straight
    flight begins to diverge, that of the steady motions of a bent rod."""
    if special.ways is not None:
        return problem, special
    beside = [curve.points[special.after + k].u for k in (0, 1)]
    states = [problem.steady(u) for u in beside]
    motions = Motions(problem.along, motion_of(states[0].rod, states[0].p, states[0].y))
    row = np.append(np.zeros(len(motions.columns)), 1.0)
    points = []
    for u, state in zip(beside, states, strict=True):
        packed = motions.packed(state, problem.value(u))
        points.append(point_at(motions, corrected(motions, packed, row), row))
    return motions, branch_point(motions, *points)._replace(after=special.after)


def _bent(rod: SteadyRod, imperfection: float) -> Steady:
    p = rod.system.p
    rest, _ = settle(rod, p, bend=checked_imperfection(imperfection))
    return Steady(rod, rest.at, p)


def _taken_up(problem: Equilibria, before: Recorded) -> Point:
    """The point of a file, on its branch, in its direction. Raises AnalysisError where it is no
    solution."""
    rod = problem.along.rod(before.values[0])
    p = problem.along.parameters(before.values[0])
    here, *others = (
        problem.packed(problem.restored(rod, p, y, force), value)
        for (y, force), value in zip(before.states, before.values, strict=True)
    )
    return taken_up(problem, here, others[0] if others else None, "equilibrium")


def _inside(name: str, value: Any, bounds: tuple[float, float]) -> float:
    value = plain(value, name)
    low, high = sorted(bounds)
    if not (is_number(value) and low <= value <= high):
        raise InputError(name, value, f"a number in the range, {low:g} to {high:g}")
    return float(value)
