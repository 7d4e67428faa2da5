"""Static equilibrium by Newton's method on the generated derivatives, with load stepping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.guarded import guarded
from rodgen.analyse.pencil import Cells, Pencil, solve, sparse
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError

LOADS = ("follower_force", "gravity", "tip_force_x", "tip_force_y")
ITERATIONS = 40  # of Newton's method for one load
FARTHEST = 0.2  # rad of a correction that is taken, else the step of load is halved
NEAR_END = 1e-4  # rad
SMALL = 1e-4  # of the load: what changes its stability over it does so on this branch
LEAST = 1e-6  # of the load, the smallest step
NOISE = 1e-9  # rad: a correction below it that no longer shrinks is rounding
MOST_DENSE = 200  # links up to which all eigenvalues are looked at for stability
UNSTABLE = 1e-6  # of the largest squared rate of the lowest modes


@dataclass(frozen=True)
class Equilibrium:
    """Rest under loads that do not change.

    phi: angles of all n links [rad]; joints: (n+1, 2) [m]; tip: the tail (2,) [m]; force: in the
    joints before the moving links over the mass of a link, (cells, 2) [m/s^2]; change: the last
    correction of Newton's method [rad]; iterations: of all loads together; stages: the fractions
    of the load that were stepped through; stable: whether small motions about it do not grow, None
    where that was not looked at (more than 200 links); t: the time whose loads were taken [s].
    """

    phi: Array = field(repr=False)
    joints: Array = field(repr=False)
    force: Array = field(repr=False)
    tip: Array = field(init=False)
    change: float
    iterations: int
    stages: tuple[float, ...]
    stable: bool | None
    t: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "tip", self.joints[-1])


@dataclass
class Rest:
    """Angles (cells,) and joint forces (cells, 2) on their way to an equilibrium."""

    phi: Array
    force: Array
    iterations: int = 0
    change: float = np.inf


@guarded
def static_equilibrium(scene: Scene, *, t: float | None = None) -> Equilibrium:
    """The equilibrium that the rod reaches from its straight shape as its loads grow from zero.

    t: time whose loads are taken [s], by default the start of the scene's span. A pinned rod hangs
    from its pivot. The tip is right to about 1e-10 of the length at a few hundred links. Raises
    SceneError for a free rod, AnalysisError where no equilibrium is found; both say why.
    """
    system = System.of(scene, t)
    if system.scene.hold.translates:
        allowed = "clamped, cantilever or pinned: nothing holds a free rod in place"
        raise SceneError("rod.boundary", system.scene.rod.boundary, allowed)
    rest, stages = settle(system, system.given)
    p = system.parameters()
    joints = system.model.joints(system.at_rest(rest.phi), p)
    phi = system.all_links(rest.phi)
    stable = _stable(system, rest, p)
    return Equilibrium(
        phi, joints, rest.force, rest.change, rest.iterations, stages, stable, system.t
    )


def settle(
    system: System, given: dict[str, float], start: Rest | None = None
) -> tuple[Rest, tuple[float, ...]]:
    """Angles and joint forces under these parameters, and the fractions of the load in between.

    start: an equilibrium under loads close to these, from which Newton's method is tried first.
    """
    if start is not None:
        near = Rest(start.phi.copy(), start.force.copy())
        if _newton(system, near, system.parameters(**given), FARTHEST):
            return near, (1.0,)
    if not system.clamped:
        return _hang(system, given), (1.0,)
    loads = {name: given[name] for name in LOADS if name in given}

    def at(fraction: float) -> Array:
        return system.parameters(**given | {k: fraction * value for k, value in loads.items()})

    try:
        return _follow(system, Rest(system.straight, np.zeros((system.cells, 2))), at)
    except AnalysisError:
        if given.get("follower_force") or not any(loads.values()):
            raise
        # Springs too soft to keep the rod near its straight shape: it hangs like a chain.
        return _hang(system, given), (1.0,)


def _follow(
    system: System, rest: Rest, at: Callable[[float], Array]
) -> tuple[Rest, tuple[float, ...]]:
    """Load stepping along the branch that begins unloaded.

    A step is taken where Newton's method converges without a large correction from the tangent,
    and where no motion has become unstable or stable on the way: else it is halved, so that no
    other branch is jumped to. A change that remains over the smallest step is one of this branch.
    """
    done, step = 0.0, 1.0
    stages: list[float] = []
    signature = _signature(system, rest, at(0.0))
    slope = None
    while done < 1:
        fraction = min(done + step, 1.0)
        trial = Rest(rest.phi.copy(), rest.force.copy(), rest.iterations)
        if slope is not None:
            trial.phi = trial.phi + (fraction - done) * slope[0]
            trial.force = trial.force + (fraction - done) * slope[1]
        taken = _newton(system, trial, at(fraction), FARTHEST)
        found = _signature(system, trial, at(fraction)) if taken else signature
        if taken and (found == signature or step < SMALL):
            change = fraction - done
            slope = ((trial.phi - rest.phi) / change, (trial.force - rest.force) / change)
            rest, done, signature = trial, fraction, found
            stages.append(fraction)
            step *= 2
        else:
            rest.iterations = trial.iterations
            step /= 2
        if step < LEAST:
            raise AnalysisError(
                f"no equilibrium found beyond {done:.6g} of the load: Newton's method failed from "
                f"there for every step of load down to {LEAST:g} of it ({rest.iterations} "
                "iterations)"
            )
    return rest, tuple(stages)


def _newton(system: System, rest: Rest, p: Array, farthest: float) -> bool:
    """Iterate in place, with corrections of at most ``farthest`` that shrink; whether it
    converged."""
    before = np.inf
    for _ in range(ITERATIONS):
        cells = Cells.at(system, rest.phi, rest.force, p)
        try:
            z = solve(cells.statics, -cells.residual.ravel()).reshape(-1, 3)
        except AnalysisError:
            return False
        change = float(np.abs(z[:, 0]).max())
        rest.iterations += 1
        settled = change <= 4 * np.finfo(float).eps or (change < NOISE and change >= before / 2)
        if not (settled or change < min(farthest, before)):
            return False
        rest.phi = rest.phi + z[:, 0]
        rest.force = rest.force + z[:, 1:]
        rest.change = change
        if settled:
            return True
        before = change
    return False


def _signature(system: System, rest: Rest, p: Array) -> int:
    """How many motions are unstable without damping; beyond MOST_DENSE links the sign of the
    determinant of the stiffness, which tells odd changes alone."""
    cells = Cells.at(system, rest.phi, rest.force, p)
    if system.cells <= MOST_DENSE:
        dense = Pencil.of(cells).reduced()
        return int((np.linalg.eigvals(np.linalg.solve(dense.M, -dense.K)).real > 0).sum())
    factors = splu(sparse(cells.statics))
    signs = np.sign(factors.U.diagonal()).prod()
    return int(signs * _parity(factors.perm_r) * _parity(factors.perm_c))


def _parity(order: NDArray[Any]) -> int:
    """1 for an even permutation, -1 for an odd one."""
    left, cycles = np.ones(len(order), dtype=bool), 0
    for first in range(len(order)):
        cycles += bool(left[first])
        at = first
        while left[at]:
            left[at] = False
            at = int(order[at])
    return 1 if (len(order) - cycles) % 2 == 0 else -1


def _hang(system: System, given: dict[str, float]) -> Rest:
    """A pinned rod: from the straight rod along its dead loads, by Newton's method on the
    equations with inertia, M (phi - phi before) / tau^2, whose steps in a time that does not exist
    lead to stable equilibria alone."""
    p = system.parameters(**given)
    rest = Rest(_along(system, given), np.zeros((system.cells, 2)))
    first = 0.0
    while rest.iterations < 100 * ITERATIONS:
        cells = Cells.at(system, rest.phi, rest.force, p)
        residual = float(np.abs(cells.residual).max())
        first = first or residual
        shift = residual**2 / first if first else 0.0  # 1/tau^2: Newton's own step near the end
        blocks = cells.statics + shift * Pencil.of(cells).S2
        z = solve(blocks, -cells.residual.ravel()).reshape(-1, 3)
        rest.phi, rest.force = rest.phi + z[:, 0], rest.force + z[:, 1:]
        rest.iterations += 1
        if np.abs(z[:, 0]).max() < NEAR_END and _newton(system, rest, p, FARTHEST):
            return rest
    raise AnalysisError(
        f"no equilibrium found: the pinned rod did not come to rest in {rest.iterations} iterations"
    )


def _along(system: System, given: dict[str, float]) -> Array:
    """Angles of the straight rod along its dead loads."""
    pull = np.array([given.get("tip_force_x", 0.0), given.get("tip_force_y", 0.0)])
    pull[1] -= given.get("gravity", 0.0) * given["mass"]
    if not pull.any():
        raise AnalysisError(
            "no equilibrium found: nothing gives a pinned rod without gravity or tip load its "
            "direction"
        )
    return np.full(system.cells, np.arctan2(pull[1], pull[0]))


def _stable(system: System, rest: Rest, p: Array) -> bool | None:
    """Whether no small motion grows, by all eigenvalues without damping."""
    if system.cells > MOST_DENSE:
        return None
    dense = Pencil.of(Cells.at(system, rest.phi, rest.force, p)).reduced()
    squares = np.linalg.eigvals(np.linalg.solve(dense.M, -dense.K))
    scale = np.sort(np.abs(squares))[min(4, len(squares) - 1)]
    rates = np.sqrt(squares.astype(complex))
    return bool(np.abs(rates.real).max() <= np.sqrt(UNSTABLE * scale))
