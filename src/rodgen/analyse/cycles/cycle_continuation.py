"""Branches of cycles: followed along one number of a scene, from a Hopf point or from a run; and
their switching, to the same period at branch points, to twice the period at period doublings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.analysis_guard import (
    CYCLE,
    check_analysis_memory,
    check_bounds,
    check_inside,
    guard_analysis,
)
from rodgen.analyse.branches.equilibria import HOPF
from rodgen.analyse.curves.continuation import (
    StepControl,
    continue_curve,
    insert_special,
    select_special,
    switch_branch,
)
from rodgen.analyse.curves.curve import (
    BRANCH,
    Curve,
    CurvePoint,
    correct,
    follow_both_ways,
    point_at,
    resume_point,
    start_point,
)
from rodgen.analyse.curves.curve_datasets import extend, make_dataset
from rodgen.analyse.curves.mesh_check import add_mesh_doubts, double_links
from rodgen.analyse.cycles.cycle_data import CycleBranch, SavedCycle, dataset, read_cycles
from rodgen.analyse.cycles.cycle_problem import PERIOD_DOUBLING, CycleFamily
from rodgen.analyse.cycles.cycle_result import Cycle
from rodgen.analyse.cycles.cycle_search import CycleSearch, check_segments
from rodgen.analyse.cycles.elimination import CondensedSystem
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.hopf import HopfPoint, first_hopf, read_hopf
from rodgen.analyse.cycles.periodicity import Orbit
from rodgen.analyse.cycles.shooting import SEGMENTS
from rodgen.analyse.cycles.symmetry import SymmetryReduction
from rodgen.arrays import Array
from rodgen.errors import InputError, check_type
from rodgen.scene import Scene
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
    point: int = -1,
    branch_point: int | None = None,
    segments: int = SEGMENTS,
    step: float = STEP,
    max_points: int = MOST,
    target: str | None = None,
    check_mesh: bool = False,
    callback: Callable[[float], None] = lambda value: None,
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
        with this cycle, both ways. A branch of `continue_equilibria`: in its Hopf point
        ``point`` (1 is the first special point).
    resume, point
        An earlier branch of the same scene and key, continued from its point of this number.
    branch_point
        Number of a special point, from 1. The branch that begins there is followed instead: the
        other branch of a branch point, or the cycles of twice the period of a period doubling.
    segments
        Number of parts into which the period is cut, as in `find_cycle`.
    step
        Length of the longest step along the branch, dimensionless.
    max_points
        Largest number of points, each way.
    target
        "c" or "numpy"; if not given, C where it can be built.
    check_mesh
        Also follow the branch of twice as many links from a Hopf point or a run, and say
        in the notes what changes by more than 1 %.
    callback
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
        given: dict[str, Any] = {"start": start, "branch_point": branch_point, "segments": segments}
        given |= {"step": step, "max_points": max_points, "target": target}
        finer = double_links(scene, key)
        found = continue_cycles(system, key, bounds, **given, callback=callback)
        return add_mesh_doubts(
            found, scene.rod.links, lambda: continue_cycles(finer, key, bounds, **given)
        )
    bounds = check_bounds(bounds)
    count = check_segments(segments)
    steps = StepControl.of(step, max_points, 10, LEAST)
    search = CycleSearch.of(system, target)
    along = ParameterRange(search.system, key, bounds)
    tracer = CycleTracer(search, along, count, steps, callback)
    if resume is not None:
        branch = tracer.resume(read_cycles(resume, scene, key, point))
        if branch_point is None:
            return make_dataset(branch.curve, lambda: extend(resume, point, dataset(branch)))
    elif isinstance(start, str) and start == HOPF:
        branch = tracer.trace_from_hopf(*first_hopf(search, along))
    elif isinstance(start, xarray.Dataset):
        branch = tracer.trace_from_hopf(*read_hopf(search, along, start, point))
    elif isinstance(start, str) and start != RUN:
        raise InputError("start", start, f"{HOPF!r}, {RUN!r}, a cycle, or a branch")
    else:
        if not isinstance(start, str):
            check_type("start", start, Cycle, see="find_cycle")
        own = (scene if isinstance(start, str) else start.scene).value_of(key)
        value = check_inside(own, key, bounds, ", to begin there")
        cycle = search.find_by_run() if isinstance(start, str) else start
        branch = tracer.trace_from_cycle(cycle, value)
    if branch_point is not None and not branch.curve.interrupted:
        branch = tracer.switch(branch, branch_point)
    return make_dataset(branch.curve, lambda: dataset(branch))


@dataclass(frozen=True)
class CycleTracer:
    """Tracer of branches of cycles along a number of a scene. segments: parts of the period;
    callback: called with every value."""

    search: CycleSearch
    along: ParameterRange
    segments: int
    steps: StepControl
    callback: Callable[[float], None]

    def trace_from_hopf(self, hopf: HopfPoint, flow: Callable[[float], Flow]) -> CycleBranch:
        """Follow the branch that begins in a Hopf point; flow: at a value."""
        orbits = []
        for amplitude in (SMALL, LARGER * SMALL):
            x, value, period = hopf.cycle_guess(amplitude)
            states = flow(value).segment_states(0.0, x, period, self.segments)
            orbits.append((Orbit(states, 0.0, period, 0.0, amplitude), value))
        problem = CycleFamily(self.search, self.along, flow(hopf.value).quotient, *orbits[0])
        guess, larger = (problem.pack(*one) for one in orbits)
        way = (larger - guess) / problem.length(larger - guess)
        found = correct(problem, guess, problem.weights * way)
        return CycleBranch(problem, self._trace(problem, point_at(problem, found, way)), hopf)

    def trace_from_cycle(self, cycle: Cycle, value: float) -> CycleBranch:
        """Follow the branch of a cycle at a value, both ways."""
        orbit = cycle.orbit
        if orbit is None:
            raise InputError("start", cycle, "a cycle of `find_cycle`")
        flow = self.search.flow(cycle.t, cycle.y0)
        x = flow.segment_states(orbit.t, orbit.x[0], orbit.period, self.segments)
        orbit = replace(orbit, x=x)
        problem = self._make_problem(flow.quotient, orbit, value)
        u = problem.pack(orbit, value)

        def follow(way: float) -> Curve:
            problem.set_phase(problem.shooting_at(value), orbit)
            return self._trace(problem, start_point(problem, u, way))

        return CycleBranch(problem, follow_both_ways(follow))

    def resume(self, cycles: list[SavedCycle]) -> CycleBranch:
        """Resume a branch from the first of these cycles, away from the second."""
        here = cycles[0]
        quotient = self.search.flow(here.t, here.y0).quotient
        orbits = []
        for one in cycles:
            flow = Flow(self.search.model, self.along.parameters(one.value), quotient)
            x = flow.segment_states(one.t, one.y0[quotient.kept], one.period, self.segments)
            orbits.append(Orbit(x, one.t, one.period, one.angle, float(np.ptp(x, axis=0).max())))
        problem = self._make_problem(quotient, orbits[0], here.value)
        values = [one.value for one in cycles]
        points = [problem.pack(*one) for one in zip(orbits, values, strict=True)]
        return CycleBranch(problem, self._trace(problem, resume_point(problem, points, "cycle")))

    def switch(self, branch: CycleBranch, number: object) -> CycleBranch:
        """Switch to the branch at a special point of another one, as its file numbers them. Raises
        InputError for a point of another kind, AnalysisError."""
        problem = branch.problem
        special = select_special(branch.special, number, (BRANCH, PERIOD_DOUBLING))
        if special.kind == BRANCH:
            curve = switch_branch(problem, special, self._bounds, self.steps, self._on_point)
            return CycleBranch(problem, curve)
        twice, u, way = _double_period(problem, special.u)
        # Both ways along it are the same cycles, half a period apart.
        curve = self._trace(twice, CurvePoint(u, way, None, 0))
        return CycleBranch(twice, insert_special(curve, 0, special._replace(u=u)))

    def _make_problem(self, quotient: SymmetryReduction, orbit: Orbit, value: float) -> CycleFamily:
        """Set up the continuation problem about an orbit at a value."""
        forced = self.search.period_at(self.along.at(value))
        turns = round(orbit.period / forced) if forced else 1
        return CycleFamily(self.search, self.along, quotient, orbit, value, turns)

    def _trace(self, problem: CycleFamily, first: CurvePoint) -> Curve:
        return continue_curve(problem, first, *self._bounds, self.steps, callback=self._on_point)

    @property
    def _bounds(self) -> tuple[float, float]:
        low, high = sorted(end / self.along.unit for end in self.along.bounds)
        return low, high

    def _on_point(self, point: CurvePoint) -> None:
        self.callback(point.value * self.along.unit)


def _double_period(problem: CycleFamily, u: Array) -> tuple[CycleFamily, Array, Array]:
    """Set up the cycles of twice the period at a period doubling. Returns the problem, u of the
    cycle gone round twice, and the tangent along which both rounds begin to differ."""
    orbit, made = problem.orbit_and_linearisation(u)
    value, q = problem.value(u), problem.quotient
    mu, vectors = CondensedSystem.of(made.G).eigenpairs
    v = vectors[:, int(np.abs(mu + 1).argmin())].real
    along = [v]
    for G in made.G[:-1]:
        along.append(G @ along[-1])
    again = q.rotate_columns(np.array(along).T, orbit.angle).T
    x = np.concatenate((orbit.x, q.rotate(orbit.x, orbit.angle)))
    both = replace(orbit, x=x, period=2 * orbit.period, angle=2 * orbit.angle)
    twice = CycleFamily(problem.search, problem.along, q, both, value, 2 * problem.turns)
    start = twice.pack(both, value)
    way = np.zeros_like(start)
    way[: x.size] = (np.concatenate((along, -again)) / twice.scale).ravel()
    return twice, start, way / twice.length(way)
