"""Static equilibrium by Newton's method on the generated derivatives, with load stepping."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from rodgen.analyse.branch import ITERATIONS, Loading, Rest, follow, newton
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.guarded import guarded
from rodgen.analyse.instability import instability
from rodgen.analyse.pencil import Cells, Pencil, solve
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.plain import plain

LOADS = ("follower_force", "gravity", "tip_force_x", "tip_force_y")
NEAR_END = 1e-4  # rad
MOST_BENT = 1.0  # rad


@dataclass(frozen=True)
class Equilibrium:
    """Rest under loads that do not change.

    phi: angles of all n links [rad]; joints: (n+1, 2) [m]; tip: the tail (2,) [m]; force: in the
    joints before the moving links over the mass of a link, (cells, 2) [m/s^2]; change: the last
    correction of Newton's method [rad]; iterations: of all loads together; stages: the fractions
    of the load that were stepped through; instability: "divergence" where a small motion about it
    grows without oscillating, so that another equilibrium is to be looked for, "flutter" where one
    oscillates more and more, "" where none grows, None where that was not looked at (more than 200
    links); stable: the same as yes or no; t: the time whose loads were taken [s].
    """

    phi: Array = field(repr=False)
    joints: Array = field(repr=False)
    force: Array = field(repr=False)
    tip: Array = field(init=False)
    change: float
    iterations: int
    stages: tuple[float, ...]
    stable: bool | None = field(init=False)
    instability: str | None
    t: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "tip", self.joints[-1])
        stable = None if self.instability is None else not self.instability
        object.__setattr__(self, "stable", stable)


@guarded
def static_equilibrium(
    scene: Scene, *, t: float | None = None, imperfection: float | None = None
) -> Equilibrium:
    """The equilibrium that the rod reaches from its straight shape as its loads grow from zero.

    t: time whose loads are taken [s], by default the start of the scene's span. imperfection: the
    angle [rad], above 0 and at most 1, by which the tail of an unloaded rod is turned that is bent
    evenly; it is loaded, and then made straight again under its whole load. What is found is an
    equilibrium of the scene's own rod, beyond a buckling load the bent and stable one (that which
    turns to the left), where without imperfection it is the straight and unstable one. A pinned rod
    hangs from its pivot, imperfect or not. The tip is right to about 1e-10 of the length at a few
    hundred links. Raises SceneError for a free rod and an imperfection out of range, AnalysisError
    where no equilibrium is found; both say why.
    """
    bend = 0.0 if imperfection is None else _checked(imperfection)
    system = System.of(scene, t)
    if system.scene.hold.translates:
        allowed = "clamped, cantilever or pinned: nothing holds a free rod in place"
        raise SceneError("rod.boundary", system.scene.rod.boundary, allowed)
    rest, stages = settle(system, system.given, bend=bend)
    p = system.parameters()
    return Equilibrium(
        phi=system.all_links(rest.phi),
        joints=system.model.joints(system.at_rest(rest.phi), p),
        force=rest.force,
        change=rest.change,
        iterations=rest.iterations,
        stages=stages,
        instability=instability(system, rest, p),
        t=system.t,
    )


def _checked(imperfection: float) -> float:
    size = plain(imperfection, "imperfection")
    number = isinstance(size, int | float) and not isinstance(size, bool)
    if not (number and 0 < size <= MOST_BENT):
        allowed = f"an angle of the tail above 0 and at most {MOST_BENT:g} rad"
        raise SceneError("imperfection", imperfection, allowed)
    return float(size)


def settle(
    system: System, given: dict[str, float], start: Rest | None = None, bend: float = 0.0
) -> tuple[Rest, tuple[float, ...]]:
    """Angles and joint forces under these parameters, and the fractions of the load in between.

    start: an equilibrium under loads close to these, from which Newton's method is tried first;
    bend: angle of the tail of the rod that is loaded, before it is made straight again [rad].
    """
    if start is not None:
        near = Rest(start.phi.copy(), start.force.copy())
        if newton(system, near, Loading(system.parameters(**given))):
            return near, (1.0,)
    if not system.clamped:
        return _hang(system, given), (1.0,)
    try:
        return _load(system, given, bend)
    except AnalysisError:
        if given.get("follower_force") or not any(given.get(name) for name in LOADS):
            raise
        # Springs too soft to keep the rod near its straight shape: it hangs like a chain.
        with suppress(AnalysisError):
            return _hang(system, given), (1.0,)
        raise


def _load(system: System, given: dict[str, float], bend: float) -> tuple[Rest, tuple[float, ...]]:
    """The branch that begins with the unloaded rod: bent by moments that keep it so, and keep
    their value while the load grows; they are taken away under the whole load."""
    loads = {name: given[name] for name in LOADS if name in given}

    def p(fraction: float) -> Array:
        return system.parameters(**given | {k: fraction * value for k, value in loads.items()})

    rest = Rest(system.straight + bend * _middles(system), np.zeros((system.cells, 2)))
    moments = Loading(p(0.0)).cells(system, rest).residual
    rest, stages = follow(system, rest, lambda done: Loading(p(done), moments))
    if bend:
        way = "the way back to a rod that is straight without load"
        rest, _ = follow(system, rest, lambda done: Loading(p(1.0), (1 - done) * moments), way)
    return rest, stages


def _middles(system: System) -> Array:
    """s in the middles of the moving links."""
    n = system.scene.rod.links
    return (np.arange(system.scene.held, n) + 0.5) / n


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
        if np.abs(z[:, 0]).max() < NEAR_END and newton(system, rest, Loading(p)):
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
