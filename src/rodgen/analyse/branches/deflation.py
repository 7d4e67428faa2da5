"""Search for all equilibria of a scene, by branches and by deflation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rodgen.analyse.analysis_guard import EQUILIBRIA, check_analysis_memory, guard_analysis
from rodgen.analyse.bordered import BorderedMatrix
from rodgen.analyse.branches.equilibria import Equilibria
from rodgen.analyse.branches.equilibrium_problems import equilibrium_problem
from rodgen.analyse.curves.continuation import StepControl, continue_curve, switch_branch
from rodgen.analyse.curves.curve import BRANCH, NOISE, start_point
from rodgen.analyse.scaled_load import RodRange
from rodgen.analyse.statics import Equilibrium, equilibrium_of, static_equilibrium
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import SteadyState, unloaded_state
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import report_stage
from rodgen.scene import Scene
from rodgen.system import System

STEPS = StepControl(first=0.01, longest=0.05, max_points=400)
MOST_BRANCHES = 24
MOST = 12  # found by deflation: a chain of n links hangs in 2^n ways
ITERATIONS = 30  # of Newton's method with deflation
FARTHEST = 0.5  # of u, of a correction: longer ones are shortened
APART = 1e-6  # rad of the mean square of all angles: two equilibria
BENT = (0.5, 1.5, 3.0, 5.0)  # rad of the tail of rods from which deflation begins
WAVES = (0.5, 1.5)  # half waves of their angles along the rod


@guard_analysis
def static_equilibria(system: System | Scene, *, t: float | None = None) -> list[Equilibrium]:
    """Return the equilibria of a scene that the search finds, the most stable first.

    The branch of the unloaded rod is followed while its loads grow together, then the other branch
    through each of its branch points, both ways, and so on. From the equilibria found at the whole
    load, and from rods bent in one and in two waves to both sides, Newton's method is deflated: it
    keeps away from known solutions (P. E. Farrell, A. Birkisson and S. W. Funke, SIAM J. Sci.
    Comput. 37 (2015) A2026). There may be more.

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
    check_analysis_memory(EQUILIBRIA, system)
    rod = SteadyRod.of(system, t)
    if not (rod.is_clamped or rod.has_supports):
        first = static_equilibrium(system, t=t)  # refuses a free rod that nothing holds
        if rod.n_base:
            return [first]
    factor = RodRange.of_load(rod)
    p = factor.numbers.parameters(0.0)
    bare, _ = unloaded_state(rod, p)
    found: list[tuple[Array, int]] = []
    problem = None
    chain = rod.scene.distribution.mean_stiffness == 0
    if bare is not None and not chain:  # which without loads is held by nothing
        problem = equilibrium_problem(factor, bare)
    if bare is None or problem is None:
        rest = static_equilibrium(system, t=t)
        at = rod.start_unknowns(rest.phi[rod.scene.n_fixed_links :])._replace(force=rest.force)
        whole = SteadyState(rod, at, rod.system.p)
        problem = equilibrium_problem(factor, whole)
        found.append((problem.pack(whole, 1.0), 0))
    else:
        found += [(u, 0) for u in _follow_branches(problem, problem.pack(bare, 0.0))]
    found += _deflate(problem, [u for u, _ in found])
    if not found:
        raise AnalysisError("no equilibrium found under the whole load")
    states = [(problem.steady_state(u), iterations) for u, iterations in found]
    every = [equilibrium_of(state, iterations) for state, iterations in states]
    order = {"": 0, None: 1, "flutter": 2, "divergence": 3}
    unstable = [problem.count_unstable(u) or 0 for u, _ in found]
    ranked = sorted(
        zip(every, unstable, strict=True), key=lambda x: (x[1], order[x[0].instability])
    )
    return [one for one, _ in ranked]


def _follow_branches(problem: Equilibria, u: Array) -> list[Array]:
    """Find the equilibria at the whole load on the unloaded rod's branch and its side branches."""
    found: list[Array] = []
    seen: list[Array] = []
    try:
        waiting = [
            continue_curve(problem, start_point(problem, u), 0.0, 1.0, STEPS).raise_interrupt()
        ]
    except AnalysisError:
        return found
    while waiting and len(seen) < MOST_BRANCHES:
        curve = waiting.pop(0)
        ends = [p.u for p in (curve.points[0], curve.points[-1]) if p.u[-1] == 1.0]
        found += [one for one in ends if _is_new(problem, one, found)]
        for special in curve.special:
            if (
                special.kind == BRANCH
                and special.ways is not None
                and _is_new(problem, special.u, seen)
            ):
                seen.append(special.u)
                curve = switch_branch(problem, special, (0.0, 1.0), STEPS)
                waiting.append(curve.raise_interrupt())
    return found


def _is_new(problem: Equilibria, u: Array, known: list[Array]) -> bool:
    return all(problem.length(u - other) > APART for other in known)


def _deflate(problem: Equilibria, known: list[Array]) -> list[tuple[Array, int]]:
    """Find equilibria by Newton's method with deflation of the known ones."""
    known = list(known)
    found: list[tuple[Array, int]] = []
    guesses = _initial_guesses(problem) + known
    while guesses and len(found) < MOST:
        guess = guesses.pop(0)
        while len(found) < MOST:
            report_stage(f"{len(known)} found")
            try:
                u, iterations = _newton(problem, guess, known)
            except AnalysisError:
                break
            if not _is_new(problem, u, known):
                break
            known.append(u)
            guesses.append(u)
            found.append((u, iterations))
    return found


def _initial_guesses(problem: Equilibria) -> list[Array]:
    """Initial guesses: bent rods."""
    start = problem.start
    s = (np.arange(start.rod.n_moving) + 0.5) / start.rod.n_moving
    turned = start.at._replace(phi=start.phi + np.pi)
    guesses = [] if start.rod.is_clamped else [problem.pack(replace(start, at=turned), 1.0)]
    for waves in WAVES:
        shape = np.sin(waves * np.pi * s) if start.rod.is_clamped else np.cos(2 * waves * np.pi * s)
        for bend in (sign * bend for bend in BENT for sign in (1.0, -1.0)):
            at = start.at._replace(phi=start.rod.unloaded_angles + bend * shape)
            guesses.append(problem.pack(replace(start, at=at), 1.0))
    return guesses


def _newton(problem: Equilibria, u: Array, known: list[Array]) -> tuple[Array, int]:
    """Newton's method for F times 1 + 1 / distance^2 to every known solution, at the whole load.
    With F's own correction d and the logarithm m of the factor, a correction is d / (1 - m' d)."""
    row = np.append(np.zeros(len(u) - 1), 1.0)
    weights = problem.weights * (row == 0)
    before = np.inf
    for iteration in range(1, ITERATIONS + 1):
        F, J = problem.evaluate(u)
        d = BorderedMatrix(J, row[None]).solve(np.append(-F, 1.0 - u[-1]))
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
