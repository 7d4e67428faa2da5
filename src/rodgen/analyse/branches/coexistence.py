"""All equilibria of a scene that branches and deflation find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rodgen.analyse.bordered import Bordered
from rodgen.analyse.branches.equilibria import Equilibria
from rodgen.analyse.branches.equilibrium_problems import equilibria
from rodgen.analyse.curves.continuation import Steps, continued, started
from rodgen.analyse.curves.curve import BRANCH, NOISE, Curve
from rodgen.analyse.curves.switching import switched
from rodgen.analyse.guard import guarded
from rodgen.analyse.rod_range import RodRange
from rodgen.analyse.sizes import EQUILIBRIA, check_size
from rodgen.analyse.statics import Equilibrium, equilibrium_of, static_equilibrium
from rodgen.analyse.steady import Steady, straight_state
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import tell
from rodgen.scene import Scene
from rodgen.system import System

STEPS = Steps(first=0.01, longest=0.05, most=400)
MOST_BRANCHES = 24
MOST = 12  # found by deflation: a chain of n links hangs in 2^n ways
ITERATIONS = 30  # of Newton's method with deflation
FARTHEST = 0.5  # of u, of a correction: longer ones are shortened
APART = 1e-6  # rad of the mean square of all angles: two equilibria
BENT = (0.5, 1.5, 3.0, 5.0)  # rad of the tail of rods from which deflation begins
WAVES = (0.5, 1.5)  # half waves of their angles along the rod


@guarded
def static_equilibria(system: System | Scene, *, t: float | None = None) -> list[Equilibrium]:
    """Return the equilibria of a scene that are found, the most stable first.

    The branch of the unloaded rod is followed while its loads grow together, and from every branch
    point the other branch both ways, and so on. From what lies at the whole load, and from rods
    that are bent in one and in two waves to both sides, Newton's method is deflated: it is driven
    away from what is known (P. E. Farrell, A. Birkisson and S. W. Funke, SIAM J. Sci. Comput. 37
    (2015) A2026). There may be more.

    Parameters
    ----------
    system
        The scene, or a System.
    t
        Time whose loads are taken [s]; by default the start of the span.

    Returns
    -------
    list of Equilibrium
        Each as `static_equilibrium` has it; iterations count Newton's corrections.

    Raises
    ------
    InputError
        For a free rod that nothing holds.
    AnalysisError
        Where none is found.

    Examples
    --------
    A column at 30 EI/L^2 stands straight, or bent in one or two ways to either side:

    >>> import rodgen
    >>> scene = rodgen.Scene.example("euler_column").replace({"loads.tip.y": -30.0})
    >>> [one.stable for one in rodgen.static_equilibria(scene)]
    [True, True, False, False, False]
    """
    system = System.of(system)
    check_size(EQUILIBRIA, system)
    rod = SteadyRod.of(system, t)
    if not (rod.clamped or rod.anchored):
        first = static_equilibrium(system, t=t)  # refuses a free rod that nothing holds
        if rod.base:
            return [first]
    factor = RodRange.of_load(rod)
    p = factor.parameters(0.0)
    bare, _ = straight_state(rod, p)
    found: list[tuple[Array, int]] = []
    problem = None
    chain = rod.scene.distribution.usual_stiffness == 0
    if bare is not None and not chain:  # which without loads is held by nothing
        problem = equilibria(factor, bare)
    if bare is None or problem is None:
        rest = static_equilibrium(system, t=t)
        at = rod.unsettled(rest.phi[rod.scene.held :])._replace(force=rest.force)
        whole = Steady(rod, at, rod.system.p)
        problem = equilibria(factor, whole)
        found.append((problem.packed(whole, 1.0), 0))
    else:
        found += [(u, 0) for u in _on_branches(problem, problem.packed(bare, 0.0))]
    found += _deflated(problem, [u for u, _ in found])
    if not found:
        raise AnalysisError("no equilibrium found under the whole load")
    states = [(problem.steady(u), iterations) for u, iterations in found]
    every = [equilibrium_of(state, iterations) for state, iterations in states]
    order = {"": 0, None: 1, "flutter": 2, "divergence": 3}
    unstable = [problem.unstable(u) or 0 for u, _ in found]
    ranked = sorted(
        zip(every, unstable, strict=True), key=lambda x: (x[1], order[x[0].instability])
    )
    return [one for one, _ in ranked]


def _on_branches(problem: Equilibria, u: Array) -> list[Array]:
    """States at the whole load on the branch of the unloaded rod, and on those that leave it."""
    found: list[Array] = []
    seen: list[Array] = []
    try:
        waiting = [continued(problem, started(problem, u), 0.0, 1.0, STEPS).uninterrupted()]
    except AnalysisError:
        return found
    while waiting and len(seen) < MOST_BRANCHES:
        curve = waiting.pop(0)
        found += [one for one in _ends(curve) if _new(problem, one, found)]
        for special in curve.special:
            if (
                special.kind == BRANCH
                and special.ways is not None
                and _new(problem, special.u, seen)
            ):
                seen.append(special.u)
                curve = switched(problem, special, (0.0, 1.0), STEPS)
                waiting.append(curve.uninterrupted())
    return found


def _ends(curve: Curve) -> list[Array]:
    return [p.u for p in (curve.points[0], curve.points[-1]) if p.u[-1] == 1.0]


def _new(problem: Equilibria, u: Array, known: list[Array]) -> bool:
    return all(problem.length(u - other) > APART for other in known)


def _deflated(problem: Equilibria, known: list[Array]) -> list[tuple[Array, int]]:
    """What Newton's method finds that is driven away from all that is known."""
    known = list(known)
    found: list[tuple[Array, int]] = []
    guesses = _guesses(problem) + known
    while guesses and len(found) < MOST:
        guess = guesses.pop(0)
        while len(found) < MOST:
            tell(f"{len(known)} found")
            try:
                u, iterations = _newton(problem, guess, known)
            except AnalysisError:
                break
            if not _new(problem, u, known):
                break
            known.append(u)
            guesses.append(u)
            found.append((u, iterations))
    return found


def _guesses(problem: Equilibria) -> list[Array]:
    """Bent rods to begin with."""
    start = problem.start
    s = (np.arange(start.rod.cells) + 0.5) / start.rod.cells
    turned = start.at._replace(phi=start.phi + np.pi)
    guesses = [] if start.rod.clamped else [problem.packed(replace(start, at=turned), 1.0)]
    for waves in WAVES:
        shape = np.sin(waves * np.pi * s) if start.rod.clamped else np.cos(2 * waves * np.pi * s)
        for bend in (sign * bend for bend in BENT for sign in (1.0, -1.0)):
            at = start.at._replace(phi=start.rod.straight + bend * shape)
            guesses.append(problem.packed(replace(start, at=at), 1.0))
    return guesses


def _newton(problem: Equilibria, u: Array, known: list[Array]) -> tuple[Array, int]:
    """Newton's method on F / product of distances to what is known, at the whole load. With F's own
    correction d and the logarithm m of the factor, the deflated correction is d / (1 - m' d)."""
    row = np.append(np.zeros(len(u) - 1), 1.0)
    weights = problem.weights * (row == 0)
    before = np.inf
    for iteration in range(1, ITERATIONS + 1):
        F, J = problem.at(u)
        d = Bordered(J, row[None]).solve(np.append(-F, 1.0 - u[-1]))
        plain = float(np.abs(d).max())
        if plain <= 1e-13 or (plain < NOISE and plain >= before / 2):
            return u + d, iteration
        slope = np.zeros(len(u))
        for other in known:
            away = weights * (u - other)
            distance = float(away @ (u - other))
            if distance > 0:  # of 1 + 1 / distance^2 (squares)
                slope += -2 * away / (distance * (distance + 1))
        by = 1 - float(slope @ d)
        step = d / (by if abs(by) > 1e-3 else 1e-3)
        length = problem.length(step)
        u = u + step * min(1.0, FARTHEST / length if length else 1.0)
        before = plain
    raise AnalysisError("Newton's method does not converge")
