"""Branches of cycles through the special points of others: of cycles of the same period through
branch points, and of twice the period through period doublings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rodgen.analyse.curves.continuation import Steps, continued
from rodgen.analyse.curves.curve import BRANCH, Curve, Point, Special
from rodgen.analyse.curves.switching import chosen, entered, switched
from rodgen.analyse.cycles.elimination import Condensed
from rodgen.analyse.cycles.family import PERIOD_DOUBLING, Cycles
from rodgen.arrays import Array


def other_branch(
    problem: Cycles,
    found: list[Special],
    switch: object,
    steps: Steps,
    watch: Callable[[Cycles], Callable[[Point], None]],
) -> tuple[Cycles, Curve]:
    """The branch that crosses another one in the special point of a number, and its problem; watch:
    for a problem, what is called with every point. Raises InputError for a point of another kind,
    AnalysisError."""
    special = chosen(found, switch, (BRANCH, PERIOD_DOUBLING))
    low, high = sorted(end / problem.along.unit for end in problem.along.bounds)
    if special.kind == BRANCH:
        return problem, switched(problem, special, (low, high), steps, watch(problem))
    twice, u, way = _doubled(problem, special.u)
    # Both ways along it are the same cycles, half a period apart.
    curve = continued(twice, Point(u, way, None, 0, {}), low, high, steps, watch=watch(twice))
    return twice, entered(curve, 0, special._replace(u=u))


def _doubled(problem: Cycles, u: Array) -> tuple[Cycles, Array, Array]:
    """The equations of cycles of twice the period about a period doubling, where u is the cycle
    gone round twice, and the direction in which the two rounds begin to differ."""
    orbit, made = problem.known(u)
    value, q = problem.value(u), problem.quotient
    mu, vectors = Condensed.of(made.G).vectors()
    v = vectors[:, int(np.abs(mu + 1).argmin())].real
    along = [v]
    for G in made.G[:-1]:
        along.append(G @ along[-1])
    again = q.turned_columns(np.array(along).T, orbit.angle).T
    x = np.concatenate((orbit.x, q.turned(orbit.x, orbit.angle)))
    both = replace(orbit, x=x, period=2 * orbit.period, angle=2 * orbit.angle)
    twice = Cycles(problem.search, problem.along, q, both, value, 2 * problem.turns)
    start = twice.packed(both, value)
    way = np.zeros_like(start)
    way[: x.size] = (np.concatenate((along, -again)) / twice.scale).ravel()
    return twice, start, way / twice.length(way)
