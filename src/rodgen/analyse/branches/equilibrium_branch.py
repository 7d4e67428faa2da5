"""Branches of equilibria and of steady motions, followed along one number of a scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.analysis_guard import (
    BRANCH,
    check_analysis_memory,
    check_bounds,
    check_inside,
    guard_analysis,
)
from rodgen.analyse.branches.equilibria import Equilibria, has_doubtful_counts
from rodgen.analyse.branches.equilibrium_data import SavedPoint, dataset, read_point
from rodgen.analyse.branches.equilibrium_problems import equilibrium_problem
from rodgen.analyse.branches.steady_motions import SteadyMotions, motion_from_state, motion_problem
from rodgen.analyse.curves.continuation import (
    StepControl,
    continue_curve,
    select_special,
    switch_branch,
)
from rodgen.analyse.curves.curve import (
    Curve,
    CurvePoint,
    SpecialPoint,
    correct,
    follow_both_ways,
    point_at,
    resume_point,
)
from rodgen.analyse.curves.curve_datasets import extend, make_dataset
from rodgen.analyse.curves.mesh_check import add_mesh_doubts, double_links
from rodgen.analyse.curves.special_points import locate_branch_point
from rodgen.analyse.equilibrium_search import check_imperfection, find_equilibrium
from rodgen.analyse.scaled_load import RodRange
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import SteadyState, find_steady_state
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.system import ParameterRange, System, system_at_start

if TYPE_CHECKING:
    import xarray

STEP = 0.02  # of the range, or rad: the longest along a branch
MOST = 2000  # points
DOUBTED = "what was counted is not what the eigenvalues of the linearised equations say"


@guard_analysis
def continue_equilibria(
    system: System | Scene,
    key: str,
    bounds: tuple[float, float],
    *,
    start: float | None = None,
    branch_point: int | None = None,
    resume: xarray.Dataset | None = None,
    point: int = -1,
    imperfection: float | None = None,
    motion: str | None = None,
    step: float = STEP,
    max_points: int = MOST,
    t: float | None = None,
    check_mesh: bool = False,
    callback: Callable[[float], None] = lambda value: None,
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
    branch_point
        Number of a branch point, from 1. The other branch through it is followed, both ways.
    resume, point
        An earlier branch of the same scene and key, continued from its point of this number.
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
    max_points
        Largest number of points.
    t
        Time whose loads are taken [s].
    check_mesh
        Also follow the branch of twice as many links, and say in the notes what changes by more
        than 1 %.
    callback
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
    check_analysis_memory(BRANCH, system, whole=motion is not None)
    scene = system.scene
    if check_mesh:
        if resume is not None:
            raise InputError("check_mesh", True, "absent beside resume")
        given: dict[str, Any] = {
            "start": start,
            "branch_point": branch_point,
            "imperfection": imperfection,
        }
        given |= {"motion": motion, "step": step, "max_points": max_points, "t": t}
        finer = double_links(scene, key)
        found = continue_equilibria(system, key, bounds, **given, callback=callback)
        return add_mesh_doubts(
            found, scene.rod.links, lambda: continue_equilibria(finer, key, bounds, **given)
        )
    low, high = bounds = check_bounds(bounds)
    begin = low if start is None else check_inside(start, "start", bounds)
    before = None if resume is None else read_point(resume, scene, key, point)
    if before is not None:
        begin = before.values[0]
    steps = StepControl.of(step, max_points, 4)
    problem = _make_problem(system, key, bounds, begin, imperfection, motion, before, t)
    first = problem.start

    def on_point(at: CurvePoint) -> None:
        callback(problem.value(at.u))

    def follow_branch(problem: Equilibria) -> Curve:
        scaled = problem.scale(min(low, high)), problem.scale(max(low, high))
        if before is not None:
            saved = _resume_point(problem, before)
            return continue_curve(problem, saved, *scaled, steps, callback=on_point)
        u = problem.pack(first, begin)
        onward = float(np.sign(high - low))

        def follow(way: float) -> Curve:
            return continue_curve(
                problem, problem.first_point(u, way * onward), *scaled, steps, callback=on_point
            )

        return follow(1.0) if start is None or begin in (low, high) else follow_both_ways(follow)

    curve = follow_branch(problem)
    if not curve.interrupted and has_doubtful_counts(problem, curve):  # in too few modes
        problem = equilibrium_problem(problem.along, first, True)
        curve = follow_branch(problem)
        if not curve.interrupted and has_doubtful_counts(problem, curve):
            problem.drop_stability(DOUBTED)
            curve = follow_branch(problem)
    entered = 0
    if branch_point is not None and not curve.interrupted:
        entered = branch_point
        problem, special = _prepare_switch(
            problem, curve, select_special(curve.special, branch_point)
        )
        scaled = problem.scale(min(low, high)), problem.scale(max(low, high))
        curve = switch_branch(problem, special, scaled, steps, on_point)

    def whole_dataset() -> xarray.Dataset:
        found = dataset(scene, key, problem, curve, entered)
        return found if resume is None else extend(resume, point, found)

    return make_dataset(curve, whole_dataset)


def _make_problem(
    system: System,
    key: str,
    bounds: tuple[float, float],
    begin: float,
    imperfection: float | None,
    motion: str | None,
    before: SavedPoint | None,
    t: float | None,
) -> Equilibria:
    """Set up the continuation problem about the steady state at the first value."""
    start = system_at_start(system, key, begin)
    values = ParameterRange(start.steady(t), key, bounds)
    rod = SteadyRod.of(values.system)
    along = RodRange(rod, values)
    if before is not None and before.moving:
        return SteadyMotions(along, motion_from_state(rod, rod.system.p, before.states[0][0]))
    if motion is not None:
        return motion_problem(start, rod, along, motion, begin)
    first = find_steady_state(rod) if imperfection is None else _bent_equilibrium(rod, imperfection)
    return equilibrium_problem(along, first)


def _prepare_switch(
    problem: Equilibria, curve: Curve, special: SpecialPoint
) -> tuple[Equilibria, SpecialPoint]:
    """Branch point with both tangents, and the problem that has them: where straight flight begins
    to diverge, that of the steady motions of a bent rod."""
    if special.ways is not None:
        return problem, special
    beside = [curve.points[special.after + k].u for k in (0, 1)]
    states = [problem.steady_state(u) for u in beside]
    motions = SteadyMotions(
        problem.along, motion_from_state(states[0].rod, states[0].p, states[0].y)
    )
    row = np.append(np.zeros(len(motions.columns)), 1.0)
    points = []
    for u, state in zip(beside, states, strict=True):
        packed = motions.pack(state, problem.value(u))
        points.append(point_at(motions, correct(motions, packed, row), row))
    return motions, locate_branch_point(motions, *points)._replace(after=special.after)


def _bent_equilibrium(rod: SteadyRod, imperfection: float) -> SteadyState:
    p = rod.system.p
    rest, _ = find_equilibrium(rod, p, bend=check_imperfection(imperfection))
    return SteadyState(rod, rest.at, p)


def _resume_point(problem: Equilibria, before: SavedPoint) -> CurvePoint:
    """Correct a saved point to its branch, with a tangent away from its neighbour. Raises
    AnalysisError if it is no solution."""
    rod = problem.along.rod(before.values[0])
    p = problem.along.numbers.parameters(before.values[0])
    points = [
        problem.pack(problem.restore(rod, p, y, force), value)
        for (y, force), value in zip(before.states, before.values, strict=True)
    ]
    return resume_point(problem, points, "equilibrium")
