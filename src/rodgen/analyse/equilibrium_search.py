"""Search for an equilibrium: along the branch of the unloaded rod, or from a hanging shape."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress

import numpy as np

from rodgen.analyse.analysis_guard import check_positive
from rodgen.analyse.equilibrium_equations import (
    DenseBalance,
    equilibrium_equations,
    square_of_growth,
)
from rodgen.analyse.load_stepping import (
    ITERATIONS,
    FoldError,
    Iterate,
    Loading,
    newton,
    step_to_equilibrium,
)
from rodgen.analyse.pencil import joint_forces
from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.analyse.support_springs import hanging_shape
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.integrate.contact_press import press_contacts
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.weights import falls_of
from rodgen.model.term import COUPLE, FORCE, Term
from rodgen.model.terms import TERMS

MOST_BENT = 1.0  # rad of an imperfection
NEAR_END = 1e-4  # rad
NEAR = 1e-3  # of the accelerations at the start
FARTHEST = 0.5  # rad of a step
SHORTER = 4.0  # times the inertia of a step that is too long
CAUTION = 2.0  # times the square of the fastest growth: as a step in time has to be short
UNBALANCED = 1e-12  # of the forces that hold a rod: rounding
MOST_TURNED = 10.0  # of the tail: a rod that turns more elsewhere is not bent by it


def find_equilibrium(
    rod: SteadyRod, p: Array, start: Unknowns | None = None, bend: float = 0.0
) -> tuple[Iterate, tuple[float, ...]]:
    """Find the equilibrium under these parameters with its joint forces, and the fractions of the
    load in between.

    start: an equilibrium under loads close to these, from which Newton's method is tried first;
    bend: angle of the tail of the rod that is loaded, before it is made straight again [rad].
    """
    near = Iterate(start) if start is not None else None
    if near is not None and newton(rod, near, Loading(p)):
        return _add_joint_forces(rod, near, p), (1.0,)
    try:
        rest, stages = _find_rest(rod, p, bend)
    except AnalysisError as error:
        try:
            rod.unknowns_at_rest(rod.unloaded_angles)
        except AnalysisError as restless:
            raise AnalysisError(f"{error}; {restless}") from None
        raise
    _check_resultant(rod, rest, p)
    return _add_joint_forces(rod, rest, p), stages


def _add_joint_forces(rod: SteadyRod, rest: Iterate, p: Array) -> Iterate:
    """Add joint forces to an equilibrium where Newton's method has not found them."""
    if not (rod.has_joint_force_unknowns or rod.is_light):
        springs = rest.springs(rod, p)
        known = p if springs is None else springs.p
        rest.at = rest.at._replace(force=joint_forces(rod, rest.at, known)[1])
    return rest


def check_imperfection(imperfection: float) -> float:
    """Check an imperfection [rad] and return it. Raises InputError."""
    allowed = f"an angle of the tail above 0 and at most {MOST_BENT:g} rad"
    return check_positive(imperfection, "imperfection", allowed, MOST_BENT)


def _find_rest(rod: SteadyRod, p: Array, bend: float) -> tuple[Iterate, tuple[float, ...]]:
    if _is_hanging(rod, p):
        return _hang_and_load(rod, p)
    try:
        return _load_from_rest_shape(rod, p, bend)
    except FoldError:
        raise
    except AnalysisError:
        start = rod.state_at_rest(rod.unknowns_at_rest(rod.unloaded_angles, strict=False))
        if (near := press_contacts(rod.model, rod.t, start, p)) is not None:
            # It may begin on the edge of what it lies on, which gives way there.
            with suppress(AnalysisError):
                lying, _ = _load_from_rest_shape(rod, near, bend)
                return step_to_equilibrium(
                    rod, lying, lambda done: Loading(near + done * (p - near))
                )
        if bend:  # it says to which side the rod goes
            raise
        acting = [term for place, term in _growing_parameters(rod) if p[place].any()]
        if not acting or any(_has_no_lowest_state(term) for term in acting):
            raise
        # Springs too soft to keep the rod near its straight shape: it hangs like a chain.
        with suppress(AnalysisError):
            return _hang(rod, p), (1.0,)
        raise


def _is_hanging(rod: SteadyRod, p: Array) -> bool:
    """Whether nothing keeps the unloaded rod straight: no clamp, or no stiffness."""
    if rod.has_feedback:
        return False
    held = rod.is_clamped or rod.has_supports
    place = rod.scene.structure.slices.get("bending_stiffness")  # else joints have their own
    return not held or (place is not None and not p[place].any())


def _has_no_lowest_state(term: Term) -> bool:
    """Whether a load has no state of least energy that a rod could hang in: it turns with the rod,
    is drag, or turns a link on and on."""
    return term.follows or term.follows_velocity or term.kind == COUPLE


def _hang_and_load(rod: SteadyRod, p: Array) -> tuple[Iterate, tuple[float, ...]]:
    """Let the rod hang from its dead loads, and follow it as the others grow."""
    growing = _load_ramp(
        p, (place for place, term in _growing_parameters(rod) if _has_no_lowest_state(term))
    )
    rest = _hang(rod, growing(0.0))
    if (growing(0.0) == p).all():
        return rest, (1.0,)
    return step_to_equilibrium(rod, rest, lambda done: Loading(growing(done)))


def _growing_parameters(rod: SteadyRod) -> list[tuple[slice, Term]]:
    """Slices of p with the parameters that grow from zero as the rod is loaded, and their loads;
    sizes that depend on the motion are not among them."""
    structure = rod.scene.structure
    terms = [TERMS[name] for name in structure.loads]
    pairs = [(one.name, term) for term in terms for one in term.scaling_parameters]
    places = structure.slices
    return [(places[name], term) for name, term in pairs if name in places]


def _load_ramp(p: Array, places: Iterable[slice]) -> Callable[[float], Array]:
    """Return p by the fraction of it that the parameters in some slices have grown to."""
    grows = np.zeros(len(p), dtype=bool)
    for place in places:
        grows[place] = True
    return lambda done: np.where(grows, done * p, p)


def _check_resultant(rod: SteadyRod, rest: Iterate, p: Array) -> None:
    """Raise AnalysisError where loads push a rod in a direction in which nothing holds it."""
    here = equilibrium_equations(rod, rest.at, p)
    if not isinstance(here, DenseBalance) or not len(here.free_directions):
        return
    scale = here.restoring_force()
    if not rod.is_light:
        pull = np.abs(joint_forces(rod, rest.at, p)[1]).max()
        scale += pull * rod.scene.mass / rod.scene.rod.links
    for way, push in zip(here.free_directions, here.net_force(), strict=True):
        if abs(push) > UNBALANCED * scale:
            x, y = way * np.sign(push)
            raise AnalysisError(
                f"no equilibrium: nothing holds the free rod along ({x:.6g}, {y:.6g}), where its "
                f"loads push it with {abs(push):.6g} N"
            )


def _load_from_rest_shape(
    rod: SteadyRod, p: Array, bend: float
) -> tuple[Iterate, tuple[float, ...]]:
    """Follow the branch that begins with the unloaded rod: straight, or bent. Moments keep its
    shape (of springs at rest none, where it is straight) while the load grows; they are taken away
    under the whole load."""
    growing = _load_ramp(p, (place for place, _ in _growing_parameters(rod)))
    unloaded = rod.unknowns_at_rest(rod.unloaded_angles, strict=False)
    rest = Iterate(_bend_rod(rod, unloaded, growing(0.0), bend))
    moments = Loading(growing(0.0)).equations(rod, rest).residual
    if not moments.any():
        return step_to_equilibrium(rod, rest, lambda done: Loading(growing(done)))
    way = "the way to a rod without the moments that first held it in shape"
    try:
        rest, stages = step_to_equilibrium(rod, rest, lambda done: Loading(growing(done), moments))
        rest, _ = step_to_equilibrium(rod, rest, lambda done: Loading(p, (1 - done) * moments), way)
    except FoldError as error:  # a fold of the rod bent by these moments, not of the rod itself
        raise AnalysisError(str(error)) from None
    return rest, stages


def _bend_rod(rod: SteadyRod, at: Unknowns, p: Array, bend: float) -> Unknowns:
    """Bend the unloaded rod by a moment that turns its tail by ``bend`` [rad], to first order;
    evenly, where it does not resist."""
    if not bend:
        return at
    here = equilibrium_equations(rod, at, p)
    with suppress(AnalysisError):
        by = here.solve(here.tail_moment)
        if by.phi[-1] and np.abs(by.phi).max() < MOST_TURNED * abs(by.phi[-1]):
            return at.add(by._replace(force=0.0 * by.force), bend / by.phi[-1])
    n = rod.scene.rod.links
    return at._replace(phi=at.phi + bend * (np.arange(rod.scene.n_fixed_links, n) + 0.5) / n)


def _hang(rod: SteadyRod, p: Array) -> Iterate:
    """Find a hanging equilibrium: from the shape without weight, along the dead loads, by Newton's
    method on the equations with inertia, M (phi - phi before) / tau^2; steps in this pseudo-time
    lead to stable equilibria alone."""
    shape = hanging_shape(rod, p, _dead_load(rod, p))
    rest = Iterate(rod.unknowns_at_rest(shape, strict=False))
    first = 0.0
    while rest.iterations < 100 * ITERATIONS:
        here = Loading(p).equations(rod, rest)
        residual = float(np.abs(here.rates).max())
        first, falls = first or residual, square_of_growth(here)
        shift = CAUTION * falls
        if residual > NEAR * first:
            shift += residual * min(1.0, residual / first)
        by = here.solve(-here.residual, shift)
        while np.abs(by.phi).max() > FARTHEST:
            shift = SHORTER * max(shift, residual)
            by = here.solve(-here.residual, shift)
        rest.correct(rod, p, by)
        rest.iterations += 1
        near = not falls and np.abs(by.phi).max() < NEAR_END
        if near and newton(rod, rest, Loading(p)):
            return rest
    raise AnalysisError(
        f"no equilibrium found: the rod did not come to rest in {rest.iterations} iterations"
    )


def _dead_load(rod: SteadyRod, p: Array) -> Array:
    """Sum of the dead loads on the straight rod (2,) [N]. Raises AnalysisError where there are
    none."""
    y = rod.state_at_rest(rod.unknowns_at_rest(rod.unloaded_angles, strict=False))
    acting = rod.model.forces(rod.t, y, p)
    dead = [x for x in acting if TERMS[x].kind == FORCE and not TERMS[x].follows]
    pull = sum((acting[name].sum(axis=0) for name in dead), np.zeros(2))
    here = MotionSlice(rod.model, p, y, np.asarray(rod.t))
    falls = falls_of(here, rod.scene.structure.terms)
    pull += sum(falls.values(), np.zeros(2)) * rod.scene.mass
    if not pull.any():
        raise AnalysisError(
            "no equilibrium found: nothing gives a rod without gravity or tip load its direction"
        )
    return pull
