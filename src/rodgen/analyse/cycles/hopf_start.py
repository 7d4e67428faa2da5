"""Hopf points in which branches of cycles begin: the first along a branch of equilibria, or one of
a branch that is known."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from rodgen.analyse.branches.branch_data import FORMAT
from rodgen.analyse.branches.equilibria import HOPF, Equilibria, crossing, is_doubted
from rodgen.analyse.branches.equilibrium_problems import equilibria
from rodgen.analyse.branches.motions import Motions, motion_of
from rodgen.analyse.curves.continuation import Steps, continued
from rodgen.analyse.curves.curve import Curve, Special
from rodgen.analyse.curves.datasets import scene_of
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.hopf import Hopf, hopf_at
from rodgen.analyse.cycles.search import Search
from rodgen.analyse.rod_range import RodRange
from rodgen.analyse.steady import steady
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.errors import AnalysisError, InputError
from rodgen.scene.plain import plain
from rodgen.system import ParameterRange

if TYPE_CHECKING:
    import xarray

STEPS = Steps(first=0.005, longest=0.02)  # of the range
Found = tuple[Hopf, Callable[[float], Flow]]  # and the flow at a value


def first_hopf(search: Search, along: ParameterRange) -> Found:
    """The first Hopf point of a scene's equilibria from the first value of a range on. Raises
    AnalysisError where there is none."""
    if search.forced:
        raise AnalysisError(
            "no Hopf point: the loads repeat, and leave no equilibrium; start from a run"
        )
    return _hopf(search, along, *_first(SteadyRod.of(along.at(along.bounds[0])), along))


def recorded_hopf(search: Search, along: ParameterRange, data: xarray.Dataset, at: object) -> Found:
    """The Hopf point of a number (1 is the first special point) of a branch of equilibria along the
    same key. Raises InputError for another point or branch, AnalysisError."""
    if data.attrs.get("format") != FORMAT or data.attrs["key"] != along.key:
        raise InputError("start", data.attrs.get("key"), f"a branch along {along.key}")
    other = scene_of(data)
    if other.structure != search.given.structure:
        raise InputError("start", other.name, "a branch of this scene")
    kinds = data["special_kind"].values.tolist()
    number = plain(at, "at")
    if not (isinstance(number, int) and 1 <= number <= len(kinds)) or kinds[number - 1] != HOPF:
        names = ", ".join(f"{k}: {kind}" for k, kind in enumerate(kinds, 1)) or "none"
        raise InputError("at", at, f"the number of a Hopf point (special points are {names})")
    value, frequency = (float(data[f"special_{x}"][number - 1]) for x in ("value", "frequency"))
    before = int(data["special_after"][number - 1])
    y, force = data["y"].values[before], data["force"].values[before]
    rod = SteadyRod.of(along.at(value))
    numbers, p = RodRange(rod, along), rod.system.p
    problem: Equilibria
    if data.attrs["moving"]:
        problem = Motions(numbers, motion_of(rod, p, y))
    else:
        problem = equilibria(numbers, Equilibria.restored(rod, p, y, force))
    u = problem.at_value(problem.packed(problem.start, float(data["value"][before])), value)
    special = crossing(problem, problem.first_point(u, 1.0), 2j * np.pi * frequency)
    return _hopf(search, along, problem, special)


def _first(rod: SteadyRod, along: ParameterRange) -> tuple[Equilibria, Special]:
    """The first Hopf point of the branch that begins with the steady state of a rod. Raises
    AnalysisError where there is none, and KeyboardInterrupt."""
    state, (low, high) = steady(rod), along.bounds
    for all_modes in (False, True):
        problem = equilibria(RodRange(rod, along), state, all_modes)
        first = problem.first_point(problem.packed(state, low), float(np.sign(high - low)))
        ends = problem.scaled(min(low, high)), problem.scaled(max(low, high))
        curve = continued(problem, first, *ends, STEPS, until=_why_end).uninterrupted()
        if not is_doubted(problem, curve):
            break
    for special in curve.special:
        if special.kind == HOPF:
            return problem, special
    why = "no oscillation about the equilibrium begins to grow there"
    why = why if curve.complete else f"the branch of equilibria ends: {curve.end}"
    raise AnalysisError(f"no Hopf point from {low:.9g} to {high:.9g}: {problem.why_unknown or why}")


def _why_end(curve: Curve) -> str:
    """Why a branch need not be followed on."""
    return "a Hopf point was found" if curve.special and curve.special[-1].kind == HOPF else ""


def _hopf(
    search: Search, along: ParameterRange, problem: Equilibria, special: Special
) -> tuple[Hopf, Callable[[float], Flow]]:
    y = problem.steady(special.u).y
    quotient = search.flow(0.0, y).quotient

    def flow(value: float) -> Flow:
        return Flow(search.model, along.parameters(value), quotient)

    return hopf_at(problem, special, flow), flow
