"""Hopf points where branches of cycles begin: the first along the equilibria, or one of a saved
branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from rodgen.analyse.branches.equilibria import (
    HOPF,
    Equilibria,
    has_doubtful_counts,
    locate_crossing,
)
from rodgen.analyse.branches.equilibrium_data import FORMAT
from rodgen.analyse.branches.equilibrium_problems import equilibrium_problem
from rodgen.analyse.branches.steady_motions import SteadyMotions, motion_from_state
from rodgen.analyse.curves.continuation import StepControl, continue_curve
from rodgen.analyse.curves.curve import Curve, SpecialPoint
from rodgen.analyse.curves.curve_datasets import scene_of
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.hopf import HopfPoint, hopf_point
from rodgen.analyse.ranges import check_whole_number
from rodgen.analyse.rod_range import RodRange
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import find_steady_state
from rodgen.errors import AnalysisError, InputError
from rodgen.system import ParameterRange

if TYPE_CHECKING:
    import xarray

STEPS = StepControl(first=0.005, longest=0.02)  # of the range
Found = tuple[HopfPoint, Callable[[float], Flow]]  # and the flow at a value


def first_hopf(search: CycleSearch, along: ParameterRange) -> Found:
    """Find the first Hopf point of a scene's equilibria from the first value of a range on. Raises
    AnalysisError where there is none."""
    if search.forced:
        raise AnalysisError(
            "no Hopf point: the loads repeat, and leave no equilibrium; start from a run"
        )
    return _hopf_and_flow(
        search, along, *_find_first(SteadyRod.of(along.at(along.bounds[0])), along)
    )


def read_hopf(
    search: CycleSearch, along: ParameterRange, data: xarray.Dataset, at: object
) -> Found:
    """Find the Hopf point of a saved branch of equilibria along the same key, by its number (1 is
    the first special point). Raises InputError for another point or branch, AnalysisError."""
    if data.attrs.get("format") != FORMAT.name or data.attrs["key"] != along.key:
        raise InputError("start", data.attrs.get("key"), f"a branch along {along.key}")
    other = scene_of(data)
    if other.structure != search.given.structure:
        raise InputError("start", other.name, "a branch of this scene")
    kinds = data["special_kind"].values.tolist()
    names = ", ".join(f"{k}: {kind}" for k, kind in enumerate(kinds, 1)) or "none"
    allowed = f"the number of a Hopf point (special points are {names})"
    number = check_whole_number(at, "at", 1, len(kinds), allowed)
    if kinds[number - 1] != HOPF:
        raise InputError("at", at, allowed)
    value, frequency = (float(data[f"special_{x}"][number - 1]) for x in ("value", "frequency"))
    before = int(data["special_after"][number - 1])
    y, force = data["y"].values[before], data["force"].values[before]
    rod = SteadyRod.of(along.at(value))
    numbers, p = RodRange(rod, along), rod.system.p
    problem: Equilibria
    if data.attrs["moving"]:
        problem = SteadyMotions(numbers, motion_from_state(rod, p, y))
    else:
        problem = equilibrium_problem(numbers, Equilibria.restore(rod, p, y, force))
    u = problem.solve_at(problem.pack(problem.start, float(data["value"][before])), value)
    special = locate_crossing(problem, problem.first_point(u, 1.0), 2j * np.pi * frequency)
    return _hopf_and_flow(search, along, problem, special)


def _find_first(rod: SteadyRod, along: ParameterRange) -> tuple[Equilibria, SpecialPoint]:
    """Find the first Hopf point of the branch that begins with the steady state of a rod. Raises
    AnalysisError where there is none, and KeyboardInterrupt."""
    state, (low, high) = find_steady_state(rod), along.bounds
    for all_modes in (False, True):
        problem = equilibrium_problem(RodRange(rod, along), state, all_modes)
        first = problem.first_point(problem.pack(state, low), float(np.sign(high - low)))
        ends = problem.scale(min(low, high)), problem.scale(max(low, high))
        curve = continue_curve(problem, first, *ends, STEPS, until=_stop_reason).raise_interrupt()
        if not has_doubtful_counts(problem, curve):
            break
    for special in curve.special:
        if special.kind == HOPF:
            return problem, special
    why = "no oscillation about the equilibrium begins to grow there"
    why = why if curve.complete else f"the branch of equilibria ends: {curve.end}"
    raise AnalysisError(f"no Hopf point from {low:.9g} to {high:.9g}: {problem.why_unknown or why}")


def _stop_reason(curve: Curve) -> str:
    """Reason to stop following a branch, if it has come to a Hopf point."""
    return "a Hopf point was found" if curve.special and curve.special[-1].kind == HOPF else ""


def _hopf_and_flow(
    search: CycleSearch, along: ParameterRange, problem: Equilibria, special: SpecialPoint
) -> tuple[HopfPoint, Callable[[float], Flow]]:
    y = problem.steady_state(special.u).y
    quotient = search.flow(0.0, y).quotient

    def flow_at(value: float) -> Flow:
        return Flow(search.model, along.parameters(value), quotient)

    return hopf_point(problem, special, flow_at), flow_at
