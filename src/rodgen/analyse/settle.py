"""The way to an equilibrium: from the unloaded rod along its branch, or by hanging."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress

import numpy as np

from rodgen.analyse.balance import WholeBalance, balance
from rodgen.analyse.pencil import forces
from rodgen.analyse.rest import ITERATIONS, FoldError, Loading, Rest, follow, newton
from rodgen.analyse.springs import hanging_shape
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.model.term import DRAG, FORCE, WEIGHT, Term
from rodgen.model.terms import TERMS
from rodgen.scene.plain import is_number, plain

MOST_BENT = 1.0  # rad of an imperfection
NEAR_END = 1e-4  # rad
NEAR = 1e-3  # of the accelerations at the start
FARTHEST = 0.5  # rad of a step
SHORTER = 4.0  # times the inertia of a step that is too long
CAUTION = 2.0  # times the square of the fastest growth: as a step in time has to be short
UNBALANCED = 1e-12  # of the forces that hold a rod: rounding
MOST_TURNED = 10.0  # of the tail: a rod that turns more elsewhere is not bent by it


def settle(
    rod: SteadyRod, p: Array, start: Unknowns | None = None, bend: float = 0.0
) -> tuple[Rest, tuple[float, ...]]:
    """The equilibrium under these parameters with its joint forces, and the fractions of the load
    in between.

    start: an equilibrium under loads close to these, from which Newton's method is tried first;
    bend: angle of the tail of the rod that is loaded, before it is made straight again [rad].
    """
    near = Rest(start) if start is not None else None
    if near is not None and newton(rod, near, Loading(p)):
        return _with_forces(rod, near, p), (1.0,)
    try:
        rest, stages = _settled(rod, p, bend)
    except AnalysisError as error:
        try:
            rod.beside(rod.straight)
        except AnalysisError as restless:
            raise AnalysisError(f"{error}; {restless}") from None
        raise
    _check_rest(rod, rest, p)
    return _with_forces(rod, rest, p), stages


def _with_forces(rod: SteadyRod, rest: Rest, p: Array) -> Rest:
    """The same with its joint forces, where Newton's method has not found them too."""
    if not rod.chain:
        springs = rest.springs(rod, p)
        known = p if springs is None else springs.p
        rest.at = rest.at._replace(force=forces(rod, rest.at, known)[1])
    return rest


def checked_imperfection(imperfection: float) -> float:
    """A bend [rad] that was asked for. Raises InputError."""
    size = plain(imperfection, "imperfection")
    if not (is_number(size) and 0 < size <= MOST_BENT):
        allowed = f"an angle of the tail above 0 and at most {MOST_BENT:g} rad"
        raise InputError("imperfection", imperfection, allowed)
    return float(size)


def start_of(rod: SteadyRod, phi: Array) -> Unknowns:
    """A rod from which an equilibrium is looked for: its added states where they stay, and as they
    are at the start where they follow what the rod will be."""
    try:
        return rod.beside(phi)
    except AnalysisError:
        return rod.unsettled(phi)


def _settled(rod: SteadyRod, p: Array, bend: float) -> tuple[Rest, tuple[float, ...]]:
    if _hangs(rod, p):
        return _hung(rod, p)
    try:
        return _load(rod, p, bend)
    except FoldError:
        raise
    except AnalysisError:
        if bend:  # which says to which side
            raise
        acting = [term for place, term in _grown(rod) if p[place].any()]
        if not acting or any(_steers(term) for term in acting):
            raise
        # Springs too soft to keep the rod near its straight shape: it hangs like a chain.
        with suppress(AnalysisError):
            return _hang(rod, p), (1.0,)
        raise


def _hangs(rod: SteadyRod, p: Array) -> bool:
    """Whether nothing keeps the unloaded rod straight: no clamp, or no stiffness."""
    if rod.steered:
        return False
    held = rod.clamped or rod.anchored
    place = rod.scene.structure.places.get("bending_stiffness")  # else joints have their own
    return not held or (place is not None and not p[place].any())


def _steers(term: Term) -> bool:
    """Whether a load turns with the rod, or is drag: no potential says where it comes to rest."""
    return term.follows or term.kind == DRAG


def _hung(rod: SteadyRod, p: Array) -> tuple[Rest, tuple[float, ...]]:
    """The rod as it hangs from its dead loads, and then as the others grow."""
    growing = _growing(p, (place for place, term in _grown(rod) if _steers(term)))
    rest = _hang(rod, growing(0.0))
    if (growing(0.0) == p).all():
        return rest, (1.0,)
    return follow(rod, rest, lambda done: Loading(growing(done)))


def _grown(rod: SteadyRod) -> list[tuple[slice, Term]]:
    """Where in p the parameters lie that grow from zero as the rod is loaded, with their loads;
    sizes that follow the motion are none."""
    structure = rod.scene.structure
    terms = [TERMS[name] for name in structure.loads]
    pairs = [(one.name, term) for term in terms for one in term.proportions]
    places = structure.places
    return [(places[name], term) for name, term in pairs if name in places]


def _growing(p: Array, places: Iterable[slice]) -> Callable[[float], Array]:
    """Parameters of which those in some places grow from zero to p, by the fraction of it."""
    grows = np.zeros(len(p), dtype=bool)
    for place in places:
        grows[place] = True
    return lambda done: np.where(grows, done * p, p)


def _check_rest(rod: SteadyRod, rest: Rest, p: Array) -> None:
    """Raise AnalysisError where loads push a rod in a direction in which nothing holds it."""
    here = balance(rod, rest.at, p)
    if not isinstance(here, WholeBalance) or not len(here.free):
        return
    pull = np.abs(forces(rod, rest.at, p)[1]).max() * rod.scene.mass / rod.scene.rod.links
    scale = here.hold() + pull
    for way, push in zip(here.free, here.push(), strict=True):
        if abs(push) > UNBALANCED * scale:
            x, y = way * np.sign(push)
            raise AnalysisError(
                f"no equilibrium: nothing holds the free rod along ({x:.6g}, {y:.6g}), where its "
                f"loads push it with {abs(push):.6g} N"
            )


def _load(rod: SteadyRod, p: Array, bend: float) -> tuple[Rest, tuple[float, ...]]:
    """The branch that begins with the unloaded rod: straight, or bent, by moments that keep it so
    (of springs at rest none, where it is straight) and their value while the load grows; they are
    taken away under the whole load."""
    growing = _growing(p, (place for place, _ in _grown(rod)))
    rest = Rest(_bent(rod, start_of(rod, rod.straight), growing(0.0), bend))
    moments = Loading(growing(0.0)).balance(rod, rest).residual
    if not moments.any():
        return follow(rod, rest, lambda done: Loading(growing(done)))
    way = "the way back to a rod that is straight without load"
    try:
        rest, stages = follow(rod, rest, lambda done: Loading(growing(done), moments))
        rest, _ = follow(rod, rest, lambda done: Loading(p, (1 - done) * moments), way)
    except FoldError as error:  # of a rod that these moments bend, not of the rod itself
        raise AnalysisError(str(error)) from None
    return rest, stages


def _bent(rod: SteadyRod, at: Unknowns, p: Array, bend: float) -> Unknowns:
    """The unloaded rod as a moment bends it that turns its tail by so much [rad], to first order;
    evenly, where it does not resist."""
    if not bend:
        return at
    here = balance(rod, at, p)
    with suppress(AnalysisError):
        by = here.solved(here.tail_moment)
        if by.phi[-1] and np.abs(by.phi).max() < MOST_TURNED * abs(by.phi[-1]):
            return at.moved(by._replace(force=0.0 * by.force), bend / by.phi[-1])
    n = rod.scene.rod.links
    return at._replace(phi=at.phi + bend * (np.arange(rod.scene.held, n) + 0.5) / n)


def _hang(rod: SteadyRod, p: Array) -> Rest:
    """A rod that hangs: from its shape without weight, along its dead loads, by Newton's method on
    the equations with inertia, M (phi - phi before) / tau^2, whose steps in a time that does not
    exist lead to stable equilibria alone."""
    rest = Rest(start_of(rod, hanging_shape(rod, p, _pull(rod, p))))
    first = 0.0
    while rest.iterations < 100 * ITERATIONS:
        here = Loading(p).balance(rod, rest)
        residual = float(np.abs(here.rates).max())
        first, falls = first or residual, here.falls()
        shift = CAUTION * falls
        if residual > NEAR * first:
            shift += residual * min(1.0, residual / first)
        by = here.solved(-here.residual, shift)
        while np.abs(by.phi).max() > FARTHEST:
            shift = SHORTER * max(shift, residual)
            by = here.solved(-here.residual, shift)
        rest.move(rod, p, by)
        rest.iterations += 1
        near = not falls and np.abs(by.phi).max() < NEAR_END
        if near and newton(rod, rest, Loading(p)):
            return rest
    raise AnalysisError(
        f"no equilibrium found: the rod did not come to rest in {rest.iterations} iterations"
    )


def _pull(rod: SteadyRod, p: Array) -> Array:
    """The dead loads of the straight rod, summed (2,) [N]. Raises AnalysisError where there are
    none."""
    y = rod.at_rest(start_of(rod, rod.straight))
    acting = rod.model.forces(rod.t, y, p)
    places, pull = rod.scene.structure.places, np.zeros(2)
    for term in map(TERMS.__getitem__, rod.scene.loads.terms):
        if term.kind == FORCE and not term.follows:
            pull += acting[term.name].sum(axis=0)
        elif term.kind == WEIGHT:
            pull[1] -= p[places[term.sizes[0].name]].item() * rod.scene.mass
    if not pull.any():
        raise AnalysisError(
            "no equilibrium found: nothing gives a rod without gravity or tip load its direction"
        )
    return pull
