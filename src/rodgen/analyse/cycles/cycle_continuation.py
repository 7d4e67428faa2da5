"""Branches of cycles: followed along one number of a scene, from a Hopf point or from a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.analysis_guard import guard_analysis
from rodgen.analyse.branches.equilibria import HOPF
from rodgen.analyse.curves.continuation import (
    StepControl,
    continue_curve,
    resume_point,
    start_point,
)
from rodgen.analyse.curves.curve import (
    Curve,
    CurvePoint,
    SpecialPoint,
    correct,
    follow_both_ways,
    point_at,
)
from rodgen.analyse.curves.curve_datasets import extend, make_dataset
from rodgen.analyse.curves.mesh_check import add_mesh_doubts, double_links
from rodgen.analyse.cycles.cycle_data import CycleBranch, SavedCycle, dataset, read_cycles
from rodgen.analyse.cycles.cycle_problem import CycleFamily
from rodgen.analyse.cycles.cycle_result import Cycle
from rodgen.analyse.cycles.cycle_search import CycleSearch, check_segments
from rodgen.analyse.cycles.cycle_switching import switch_cycles
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.hopf_points import Found, first_hopf, read_hopf
from rodgen.analyse.cycles.periodicity import Orbit
from rodgen.analyse.cycles.shooting import SEGMENTS, segment_states
from rodgen.analyse.memory_needs import CYCLE, check_analysis_memory
from rodgen.analyse.ranges import check_bounds
from rodgen.arrays import Array
from rodgen.errors import InputError, check_type
from rodgen.scene import Scene
from rodgen.scene.plain_tables import is_number
from rodgen.system import ParameterRange, System

if TYPE_CHECKING:
    import xarray

RUN = "run"
SMALL, LARGER = 0.03, 1.25  # rad: the first cycle beside a Hopf point, and one that is larger
STEP = 0.1  # of the mean square of the states, of the logarithm of the period, and of the range
LEAST = 1e-6
MOST = 200  # points


@guard_analysis
def continue_cycles(
    system: System | Scene,
    key: str,
    bounds: tuple[float, float],
    *,
    start: str | Cycle | xarray.Dataset = HOPF,
    resume: xarray.Dataset | None = None,
    at: int = -1,
    switch: int | None = None,
    segments: int = SEGMENTS,
    step: float = STEP,
    most: int = MOST,
    target: str | None = None,
    check_mesh: bool = False,
    watch: Callable[[float], None] = lambda value: None,
) -> xarray.Dataset:
    """Follow a branch of limit cycles, stable or not, while one number of a scene changes.

    Parameters
    ----------
    system
        The scene, or a System.
    key
        The number, named as in a study, such as loads.follower.force.
    bounds
        First and last value of the number, in SI units.
    start
        Where the branch begins. "hopf": in the first Hopf point of the equilibria. "run": with
        the cycle on which the scene settles; the branch is then followed both ways. A `Cycle`:
        with this cycle, both ways. A branch of `continue_equilibria`: in its Hopf point ``at``
        (1 is the first special point).
    resume, at
        An earlier branch of the same scene and key, which is continued from its point ``at``.
    switch
        Number of a special point, from 1. The branch that begins there is followed instead: the
        other branch of a branch point, or the cycles of twice the period of a period doubling.
    segments
        Number of parts into which the period is cut, as in `find_cycle`.
    step
        Length of the longest step along the branch, dimensionless.
    most
        Largest number of points, each way.
    target
        "c" or "numpy"; if not given, C where it can be built.
    check_mesh
        Also follow the branch of twice as many links from a Hopf point or a run, and say
        in the notes what changes by more than 1 %.
    watch
        A function that is called with every value, in SI units.

    Returns
    -------
    xarray.Dataset
        One dimension along the branch: value, period [s], amplitude (the largest deviation of an
        angle [rad]), tip (likewise, of the tail [m]), energy (its mean [J]), unstable, multipliers
        (in two columns), trivial_error, y0, and work (of every load over a period [J]); and special
        points, special_kind "hopf", "fold", "branch", "period doubling" or "torus" (a
        Neimark-Sacker point) with special_value, special_period and special_after. Its attributes
        say where it ends and why.

    Raises
    ------
    InputError
        For a key that cannot be varied, and for values that are not allowed.
    AnalysisError
        If there is no cycle or Hopf point to begin with.
    BranchInterrupted
        On Ctrl-C. It carries the points so far.

    Examples
    --------
    Beck's column flutters at 10.71 N, and its cycles grow from there:

    >>> import rodgen
    >>> scene = rodgen.Scene.example("beck_after_flutter")
    >>> branch = rodgen.continue_cycles(scene, "loads.follower.force", (8, 14))
    >>> round(float(branch.special_value[0]), 2), branch.attrs["supercritical"]
    (10.71, 1)
    """
    import xarray

    system = System.of(system)
    check_analysis_memory(CYCLE, system)
    scene = system.scene
    if check_mesh:
        if resume is not None or not isinstance(start, str):
            raise InputError("check_mesh", True, "absent beside resume, and a start that is given")
        beside = double_links(scene, key)
    bounds = check_bounds(bounds)
    count = check_segments(segments)
    steps = StepControl.of(step, most, 10, LEAST)
    search = CycleSearch.of(system, target)
    along = ParameterRange(search.system, key, bounds)
    if resume is not None:
        cycles = read_cycles(resume, scene, key, at)
        branch = _resume(search, along, cycles, count, steps, watch)
        if switch is None:
            return make_dataset(branch.curve, lambda: extend(resume, at, dataset(branch)))
    elif isinstance(start, str) and start == HOPF:
        branch = _follow_from_hopf(search, along, first_hopf(search, along), count, steps, watch)
    elif isinstance(start, xarray.Dataset):
        branch = _follow_from_hopf(
            search, along, read_hopf(search, along, start, at), count, steps, watch
        )
    elif isinstance(start, str) and start != RUN:
        raise InputError("start", start, f"{HOPF!r}, {RUN!r}, a cycle, or a branch")
    else:
        if not isinstance(start, str):
            check_type("start", start, Cycle, see="find_cycle")
        value = _start_value(scene if isinstance(start, str) else start.scene, key, bounds)
        cycle = search.find_by_run() if isinstance(start, str) else start
        branch = _follow_from_cycle(search, along, cycle, value, count, steps, watch)
    if switch is not None and not branch.curve.interrupted:
        branch = _switch(branch, switch, steps, watch)
    found = make_dataset(branch.curve, lambda: dataset(branch))
    if not check_mesh:
        return found

    def follow_finer() -> xarray.Dataset:
        given: dict[str, Any] = {"start": start, "switch": switch, "segments": segments}
        given |= {"step": step, "most": most, "target": target}
        return continue_cycles(beside, key, bounds, **given)

    return add_mesh_doubts(found, scene.rod.links, follow_finer)


def _start_value(scene: Scene, key: str, bounds: tuple[float, float]) -> float:
    """The scene's own value of a key. Raises InputError for one outside the bounds."""
    value = scene.value_of(key)
    if not (is_number(value) and min(bounds) <= value <= max(bounds)):
        raise InputError(
            key, value, f"in the range, {bounds[0]:g} to {bounds[1]:g}, to begin there"
        )
    return float(value)


def _follow_from_hopf(
    search: CycleSearch,
    along: ParameterRange,
    begin: Found,
    count: int,
    steps: StepControl,
    watch: Callable[[float], None],
) -> CycleBranch:
    hopf, flow = begin
    orbits = []
    for amplitude in (SMALL, LARGER * SMALL):
        x, value, period = hopf.cycle_guess(amplitude)
        states = segment_states(flow(value), 0.0, x, period, count)
        orbits.append((Orbit(states, 0.0, period, 0.0, amplitude), value))
    problem = CycleFamily(search, along, flow(hopf.value).quotient, *orbits[0])
    guess, larger = (problem.pack(*one) for one in orbits)
    way = (larger - guess) / problem.length(larger - guess)
    found = correct(problem, guess, problem.weights * way)
    first = point_at(problem, found, way)
    curve = _follow(problem, first, steps, watch)
    return CycleBranch(search.given, along.key, problem, curve, hopf)


def _follow_from_cycle(
    search: CycleSearch,
    along: ParameterRange,
    cycle: Cycle,
    value: float,
    count: int,
    steps: StepControl,
    watch: Callable[[float], None],
) -> CycleBranch:
    orbit = cycle.orbit
    if orbit is None:
        raise InputError("start", cycle, "a cycle of `find_cycle`")
    flow = search.flow(cycle.t, cycle.y0)
    orbit = replace(orbit, x=segment_states(flow, orbit.t, orbit.x[0], orbit.period, count))
    problem = _make_problem(search, along, cycle.y0, orbit, value)
    u = problem.pack(orbit, value)

    def follow(way: float) -> Curve:
        problem.set_phase(orbit, value)
        return _follow(problem, start_point(problem, u, way), steps, watch)

    return CycleBranch(search.given, along.key, problem, follow_both_ways(follow))


def _resume(
    search: CycleSearch,
    along: ParameterRange,
    cycles: list[SavedCycle],
    count: int,
    steps: StepControl,
    watch: Callable[[float], None],
) -> CycleBranch:
    """Resume a branch from the first of these cycles, away from the second."""
    here = cycles[0]
    quotient = search.flow(here.t, here.y0).quotient
    orbits = []
    for one in cycles:
        flow = Flow(search.model, along.parameters(one.value), quotient)
        x = segment_states(flow, one.t, one.y0[quotient.kept], one.period, count)
        orbits.append(Orbit(x, one.t, one.period, one.angle, float(np.ptp(x, axis=0).max())))
    problem = _make_problem(search, along, here.y0, orbits[0], here.value)
    values = [one.value for one in cycles]
    u, *others = (problem.pack(*one) for one in zip(orbits, values, strict=True))
    first = resume_point(problem, u, others[0] if others else None, "cycle")
    return CycleBranch(search.given, along.key, problem, _follow(problem, first, steps, watch))


def _make_problem(
    search: CycleSearch, along: ParameterRange, y0: Array, orbit: Orbit, value: float
) -> CycleFamily:
    """Set up the continuation problem about an orbit through a state, at a value."""
    forced = search.period_at(along.at(value))
    turns = round(orbit.period / forced) if forced else 1
    quotient = search.flow(orbit.t, y0).quotient
    return CycleFamily(search, along, quotient, orbit, value, turns)


def _switch(
    branch: CycleBranch, switch: object, steps: StepControl, watch: Callable[[float], None]
) -> CycleBranch:
    """Switch to the branch at a special point of another one, as its file numbers them."""
    problem, curve = branch.problem, branch.curve
    first = [SpecialPoint(HOPF, curve.points[0].u)] if branch.hopf is not None else []
    found = [*first, *curve.special]
    problem, curve = switch_cycles(
        problem, found, switch, steps, lambda p: _point_callback(p, watch)
    )
    return CycleBranch(branch.scene, branch.key, problem, curve)


def _follow(
    problem: CycleFamily, first: CurvePoint, steps: StepControl, watch: Callable[[float], None]
) -> Curve:
    low, high = sorted(end / problem.along.unit for end in problem.along.bounds)
    return continue_curve(problem, first, low, high, steps, watch=_point_callback(problem, watch))


def _point_callback(
    problem: CycleFamily, watch: Callable[[float], None]
) -> Callable[[CurvePoint], None]:
    """Callback for every point of a curve, which takes the phase for the next point from it."""

    def on_point(point: CurvePoint) -> None:
        value = problem.value(point.u)
        problem.set_phase(problem.orbit(point.u), value)
        watch(value)

    return on_point
