"""Branch switching of cycles: to the same period at branch points, to twice the period at period
doublings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rodgen.analyse.curves.branch_switching import insert_special, select_special, switch_branch
from rodgen.analyse.curves.continuation import StepControl, continue_curve
from rodgen.analyse.curves.curve import BRANCH, Curve, CurvePoint, SpecialPoint
from rodgen.analyse.cycles.cycle_problem import PERIOD_DOUBLING, CycleFamily
from rodgen.analyse.cycles.elimination import CondensedSystem
from rodgen.arrays import Array


def switch_cycles(
    problem: CycleFamily,
    found: list[SpecialPoint],
    switch: object,
    steps: StepControl,
    watch: Callable[[CurvePoint], None],
) -> tuple[CycleFamily, Curve]:
    """Switch to the branch through a special point, by its number; returns the problem and the
    curve. watch: called with every point. Raises InputError for a point of another kind,
    AnalysisError."""
    special = select_special(found, switch, (BRANCH, PERIOD_DOUBLING))
    low, high = sorted(end / problem.along.unit for end in problem.along.bounds)
    if special.kind == BRANCH:
        return problem, switch_branch(problem, special, (low, high), steps, watch)
    twice, u, way = _double_period(problem, special.u)
    # Both ways along it are the same cycles, half a period apart.
    curve = continue_curve(twice, CurvePoint(u, way, None, 0), low, high, steps, watch=watch)
    return twice, insert_special(curve, 0, special._replace(u=u))


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
