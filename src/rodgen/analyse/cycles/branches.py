"""Branches of cycles: followed along one number of a scene, from a Hopf point or from a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from rodgen.analyse.curves.continuation import Steps, continued, started
from rodgen.analyse.curves.curve import Curve, Point, corrected, point_at
from rodgen.analyse.cycles.cycle import SEGMENTS, Cycle, Search, segments_of
from rodgen.analyse.cycles.family import Cycles, Variation
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.hopf import Hopf, hopf_point
from rodgen.analyse.cycles.shooting import Orbit, cut
from rodgen.analyse.errors import AnalysisError, guarded
from rodgen.analyse.steady import steady
from rodgen.analyse.system import System
from rodgen.model.terms import TERMS
from rodgen.scene import Scene, SceneError
from rodgen.scene.errors import check_type
from rodgen.scene.keys import key_place
from rodgen.scene.plain import entry, is_number, plain
from rodgen.scene.scene import check_scene

if TYPE_CHECKING:
    import xarray

HOPF, RUN = "hopf", "run"
SMALL, LARGER = 0.03, 1.25  # rad: the first cycle beside a Hopf point, and one that is larger
STEP = 0.1  # of the mean square of the states, of the logarithm of the period, and of the range
LEAST = 1e-6
MOST = 200  # points


@dataclass(frozen=True)
class Branch:
    """A curve of cycles of a scene along a key; hopf: where it begins, unless that was a run."""

    scene: Scene
    key: str
    problem: Cycles
    curve: Curve
    hopf: Hopf | None = None


@guarded
def continue_cycles(
    scene: Scene,
    key: str,
    ends: tuple[float, float],
    *,
    start: str | Cycle = HOPF,
    segments: int = SEGMENTS,
    step: float = STEP,
    most: int = MOST,
    target: str | None = None,
    watch: Callable[[float], None] = lambda value: None,
) -> xarray.Dataset:
    """The branch of cycles of a scene along one number of it, stable or not.

    key: the number, named as in a study, such as loads.follower.force; ends: between which it is
    varied. start: "hopf", the first Hopf point from the first end on, of the equilibrium of the
    straight rod; "run", the cycle that the scene settles on at its own value, or a cycle
    that was found: from these the branch is followed both ways. segments: as `find_cycle` has them;
    step: the longest along the branch; most: points, each way; watch: called with every value.

    The Dataset has one dimension along the branch: value, period [s], amplitude (the largest
    deviation of an angle [rad]), tip (likewise, of the tail [m]), energy (its mean [J]), unstable,
    multipliers (in two columns), trivial_error, y0, and work (of every load over a period [J]);
    and special points, special_kind "hopf", "fold", "branch", "period doubling" or "torus" (a
    Neimark-Sacker point) with special_value, special_period and special_after. Its attributes say
    where it ends and why. Raises SceneError for what cannot be varied so, AnalysisError where there
    is nothing to begin with.
    """
    from rodgen.analyse.cycles.branch_data import dataset

    check_scene(scene)
    ends = _ends(key, ends)
    count = segments_of(segments)
    steps = Steps.of(step, most, 10, LEAST)
    search = Search.of(scene, target)
    variation = Variation(search, scene, key, ends)
    if isinstance(start, str) and start == HOPF:
        return dataset(_from_hopf(variation, count, steps, watch))
    if isinstance(start, str) and start != RUN:
        raise SceneError("start", start, f"{HOPF!r}, {RUN!r}, or a cycle")
    if isinstance(start, str):
        value = _own(scene, key, ends)
        cycle = search.settled(count)
    else:
        check_type("start", start, Cycle, see="find_cycle")
        value, cycle = _own(start.scene, key, ends), start
    return dataset(_both_ways(variation, cycle, value, steps, watch))


def _ends(key: str, ends: tuple[float, float]) -> tuple[float, float]:
    given = plain(list(ends), f"vary.{key}")
    if not (len(given) == 2 and all(is_number(one) and np.isfinite(one) for one in given)):
        raise SceneError(f"vary.{key}", ends, "two finite numbers")
    return float(given[0]), float(given[1])


def _own(scene: Scene, key: str, ends: tuple[float, float]) -> float:
    """The scene's own value of a key. Raises SceneError for one outside the ends."""
    table = scene.model_dump(exclude_none=True)
    value = entry(table, *key_place(table, key))
    if not (is_number(value) and min(ends) <= value <= max(ends)):
        raise SceneError(key, value, f"in the range, {ends[0]:g} to {ends[1]:g}, to begin there")
    return float(value)


def hopf_of(variation: Variation) -> tuple[Hopf, Callable[[float], Flow]]:
    """The first Hopf point of the scene's equilibrium between the ends of a variation, and the flow
    at a value. Raises AnalysisError."""
    search = variation.search
    if search.forced:
        raise AnalysisError(
            "no Hopf point: the loads repeat, and leave no equilibrium; start from a run"
        )
    low, high = variation.ends
    state = steady(System.of(variation.at(low)))
    given = state.system.given
    for term in map(TERMS.__getitem__, state.system.scene.loads.terms):
        if term.kinked and np.any(given[term.parameters[0].name]):
            raise AnalysisError(
                f"no Hopf point: {term.parameters[0].name} is not smooth at rest, and no normal "
                "form has the cycles that begin there; start from a run"
            )
    y = state.system.at_rest(state.at)
    quotient = search.flow(0.0, y).quotient
    quotient = replace(quotient, origin=y)

    def flow(value: float) -> Flow:
        return Flow(search.model, variation.parameters(value), quotient)

    return hopf_point(flow, 0.0, y[quotient.kept], low, high), flow


def _from_hopf(
    variation: Variation, count: int, steps: Steps, watch: Callable[[float], None]
) -> Branch:
    hopf, flow = hopf_of(variation)
    orbits = []
    for amplitude in (SMALL, LARGER * SMALL):
        x, value, period = hopf.beside(amplitude)
        states = cut(flow(value), 0.0, x, period, count)
        orbits.append((Orbit(states, 0.0, period, 0.0, amplitude), value))
    problem = Cycles(variation, flow(hopf.value).quotient, *orbits[0])
    guess, larger = (problem.packed(*one) for one in orbits)
    way = (larger - guess) / problem.length(larger - guess)
    found = corrected(problem, guess, problem.weights * way)
    first = point_at(problem, found, way)
    curve = _walk(problem, first, steps, watch)
    return Branch(variation.scene, variation.key, problem, curve, hopf)


def _both_ways(
    variation: Variation,
    cycle: Cycle,
    value: float,
    steps: Steps,
    watch: Callable[[float], None],
) -> Branch:
    orbit = cycle.orbit
    if orbit is None:
        raise SceneError("start", cycle, "a cycle of `find_cycle`")
    quotient = variation.search.flow(cycle.t, cycle.y0).quotient
    forced = variation.forced(value)
    turns = round(orbit.period / forced) if forced else 1
    problem = Cycles(variation, quotient, orbit, value, turns)
    u = problem.packed(orbit, value)
    curves = []
    for way in (-1.0, 1.0):
        problem.look_from(orbit, value)
        curves.append(_walk(problem, started(problem, u, way), steps, watch))
    back, on = curves
    joined = back.backwards()
    offset = len(joined.points) - 1
    special = [one._replace(after=one.after + offset) for one in on.special]
    curve = Curve(
        points=joined.points + on.points[1:],
        special=joined.special + special,
        end=f"downwards: {back.end}; upwards: {on.end}",
        complete=back.complete and on.complete,
        notes=back.notes + on.notes,
    )
    return Branch(variation.scene, variation.key, problem, curve)


def _walk(problem: Cycles, first: Point, steps: Steps, watch: Callable[[float], None]) -> Curve:
    low, high = sorted(end / problem.variation.unit for end in problem.variation.ends)

    def seen(point: Point) -> None:
        value = problem.value(point.u)
        problem.look_from(problem.orbit(point.u), value)
        watch(value)

    return continued(problem, first, low, high, steps, watch=seen)
