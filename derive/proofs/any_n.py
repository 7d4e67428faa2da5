"""Derivation 2 compared with the closed form, for symbolic n, i and j."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import sympy
from sympy import Add, Expr, IndexedBase, Integer, S, Sum, Symbol, expand, expand_trig, symbols

from ..closed_form import Arithmetic, ClosedForm, link_masses, link_sizes
from ..comparison import ANY_N, Comparison, DisagreementError
from ..general import GeneralEquations
from ..generic_chain import AtSprings
from ..link_properties import joint_stiffness, link_length, rest_angle
from ..loads import TERMS
from ..loads.contact import Contact
from ..loads.joint_drag import JointDrag, JointMotion, divisor, length_at, mass_at, rod_angle
from ..loads.joint_law import JointLaw
from ..loads.kinds import JointMoment, Load
from ..loads.point_force import PointLoad
from ..symbols import (
    HALF,
    PARAMETERS,
    discretisation,
    i,
    j,
    joint,
    joint_moment,
    joint_vx,
    joint_vy,
    joint_x,
    joint_y,
    k,
    l,
    later,
    m,
    n,
    omega,
    phi,
    s,
)

Pairs = list[tuple[Expr, Expr]]
_q = Symbol("q", integer=True)

SYMBOLIC = Arithmetic(
    sympy.cos, sympy.sin, HALF, lambda term, low, high: Sum(term(_q), (_q, low, high))
)


def prove_any_n(
    boundary: str, inertia: str, terms: Sequence[str] = TERMS, nonuniform: Sequence[str] = ()
) -> Iterator[Comparison]:
    """Compare link sizes, all kinds of entries of M, Q, K, and loads; raises DisagreementError."""
    yield _compare("sizes", _sizes())
    derived = GeneralEquations(boundary, inertia, tuple(terms), tuple(nonuniform))
    differing = joint_stiffness if "stiffness" in nonuniform else None
    lumped = inertia == "lumped"
    links = link_masses(nonuniform, PARAMETERS.__getitem__, lumped, HALF)
    sizes = (n, m, l, k, phi, derived.boundary_condition, SYMBOLIC, lumped, differing, links)
    rest = rest_angle if "rest" in nonuniform else None
    lengths = link_length if derived.rod.has_link_lengths else None
    closed = ClosedForm(*sizes, rest, lengths)
    for name, pairs in _matrices(derived, closed).items():
        yield _compare(name, pairs)
    for load in derived.loads.values():
        yield _compare(load.letter, _load_pairs(derived, closed, load))
        if isinstance(load, JointDrag) and not isinstance(load, Contact):
            yield _compare_drag_law(derived, closed, load)


def _sizes() -> Pairs:
    M, L, EI = (PARAMETERS[name] for name in ("mass", "length", "bending_stiffness"))
    derived = discretisation()
    return list(zip((derived[m], derived[l], derived[k]), link_sizes(M, L, EI, n), strict=True))


def _matrices(derived: GeneralEquations, closed: ClosedForm) -> dict[str, Pairs]:
    base = derived.boundary_condition.translates
    # Entries of links i < j, where they differ.
    pair = i, j, j if derived.rod.has_link_masses else later
    M: Pairs = [
        (derived.mass_link, closed.M_link(i)),
        (derived.mass_link_link, closed.M_link_link(*pair)),
    ]
    Q: Pairs = [(derived.velocity_link_link, closed.Q_link_link(*pair))]
    if base:
        M.append((derived.mass_base, closed.M_base()))
        M += zip(derived.mass_base_link, closed.M_base_link(i), strict=True)
        Q += zip(derived.velocity_base_link, closed.Q_base_link(i), strict=True)
    K = _bending_pairs(
        *(derived, derived.springs, phi, closed),
        *(closed.spring_stiffness, derived.base_motion.clamp_angle, closed.rest_moment),
    )
    steps: Pairs = []
    by_hand = (*closed.joint_step(i), *closed.velocity_step(i, omega[i]))
    for quantity, hand in zip((joint_x, joint_y, joint_vx, joint_vy), by_hand, strict=True):
        (total,) = derived.arrays[quantity].value.atoms(Sum)
        steps.append((total.function, hand))
    return {"M": M, "Q": Q, "K": K, "joints": steps}


def _load_pairs(derived: GeneralEquations, closed: ClosedForm, load: Load) -> Pairs:
    """Pairs of generalised forces of a load; of one at a point inside, on the link of its point and
    on those next to it."""
    if isinstance(load, JointMoment):
        factor = partial(load.coefficient_by_hand, closed, _identity)
        turning = derived.base_motion.angle[1]
        return _bending_pairs(derived, load.moments(derived), omega, closed, factor, turning)
    if isinstance(load, JointLaw):
        return _joint_law_pairs(derived, closed, load)
    work = load.generalised_forces(derived)
    assert work is not None
    links = [i]
    if isinstance(load, PointLoad) and load.is_of_one_link:
        near, first = (load.point.link + d for d in (-1, 0, 1)), derived.boundary_condition.first
        links = [link for link in near if not (link.is_Integer and link < first)]
    pairs = [(work.link.subs(i, at), load.link_by_hand(closed, at, _identity)) for at in links]
    if derived.boundary_condition.translates:
        pairs += zip(work.base, load.base_by_hand(closed, _identity), strict=True)
    return pairs


def _identity(of: Expr) -> Expr:
    """Return the symbol: it stands for the number of a load here."""
    return of


def _bending_pairs(
    derived: GeneralEquations,
    moments: AtSprings,
    of: IndexedBase,
    closed: ClosedForm,
    factor: Callable[[Any, int], Any],
    clamp: Expr,
    rest: Callable[[Any, int], Any] = lambda at, size: 0,
) -> Pairs:
    """Pairs of the moment of the joints at its ends on a link and its row of K or D_i: for a link
    inside, for the first of all, and for the last. factor: coefficient of a joint of a size in the
    closed form; clamp: angle or rate before the first link and behind the last; rest: moment of a
    joint of a size where it is not bent."""
    pairs = []
    inner, root, tail = moments
    places = {"inside": (1, 1), "tail": (1, closed.tail_size), "start": (closed.root_size, 1)}
    for where, ends in places.items():
        if where == "start" and derived.boundary_condition.first:
            continue
        work = _value_at(derived.link_moment, i, where)
        acting = {joint_moment[at]: inner.subs(s, at) for at in (i, i + 1)}
        if where == "start":
            acting[joint_moment[i]] = root.xreplace({of[0]: of[i]})
        if where == "tail":
            acting[joint_moment[i + 1]] = tail.subs(n, i + 1)
        before = clamp if where == "start" else of[i - 1]
        links = (before, of[i], clamp if where == "tail" else of[i + 1])
        first = Integer(0) if where == "start" else i
        row = closed.bending_row(factor(first, ends[0]), factor(i + 1, ends[1]))
        by_hand = sum(c * at for c, at in zip(row, links, strict=True))
        by_hand -= rest(first, ends[0]) - rest(i + 1, ends[1])
        pairs.append((work.xreplace(acting), -by_hand))
    return pairs


def _joint_law_pairs(derived: GeneralEquations, closed: ClosedForm, load: JointLaw) -> Pairs:
    """Pairs of the moment of the joints at its ends on a link and that by hand, at the places of
    `_bending_pairs`."""
    inner, root, tail = load.moments(derived)
    places = {"inside": (1, 1), "tail": (1, closed.tail_size), "start": (closed.root_size, 1)}
    pairs = []
    for where, sizes in places.items():
        if where == "start" and derived.boundary_condition.first:
            continue
        acting = {joint_moment[at]: inner.subs(s, at) for at in (i, i + 1)}
        if where == "start":
            acting[joint_moment[i]] = inner.subs(s, i) if root != 0 else S.Zero
        if where == "tail":
            acting[joint_moment[i + 1]] = tail.subs(n, i + 1)
        work = _value_at(derived.link_moment, i, where).xreplace(acting)
        pairs.append((work, load.ends_by_hand(i, sizes, _identity)))
    return pairs


def _value_at(value: Expr, index: Symbol, where: str) -> Expr:
    """Value at one of the places of an expression that differs at the ends of its index."""
    ends = {0: where == "start", n: where == "tail", n - 1: where == "tail"}
    return value.subs({sympy.Eq(index, end): holds for end, holds in ends.items()})


def _compare(name: str, pairs: Pairs) -> Comparison:
    for at, (derived, closed) in enumerate(pairs):
        if expand(_normal_form(derived) - _normal_form(closed)) != 0:
            raise DisagreementError(ANY_N, f"{name}, identity {at}", derived, closed)
    return Comparison(name, ANY_N, len(pairs))


def _normal_form(expression: Expr) -> Expr:
    """Expand angle sums, split sums into their terms, and give these one name for their index."""

    def rename(total: Sum) -> Expr:
        index, low, high = total.limits[0]
        summand = expand(expand_trig(total.function.subs(index, _q)))
        parts = (e.as_independent(_q, as_Add=False) for e in Add.make_args(summand))
        return Add(*(outside * Sum(inside, (_q, low, high)) for outside, inside in parts))

    renamed = expression.replace(lambda e: isinstance(e, Sum), rename)
    return expand(expand_trig(expand(renamed)))


def _compare_drag_law(derived: GeneralEquations, closed: ClosedForm, load: JointDrag) -> Comparison:
    """Compare the force on a joint at the start, inside and at the tail with the law by hand."""
    arrays = derived.arrays
    ends = [closed.length(joint - 1), closed.length(joint)]
    inside = (ends[0] * phi[joint - 1] + ends[1] * phi[joint]) / (ends[0] + ends[1])
    places: dict[str, tuple[Expr, Expr, Expr, Expr]] = {
        "inside": (S.One, sum(ends) / 2, inside, joint),
        "tail": (S.Half, closed.length(n - 1) / 2, phi[n - 1], n),
        "start": (S.Half, closed.length(Integer(0)) / 2, phi[0], Integer(0)),
    }
    if derived.boundary_condition.first_joint:
        del places["start"]
    # At rest both forms have no force; in motion the divisor is the speed.
    (speed, _), _ = arrays[divisor].value.args
    factors = tuple(base[joint] for base in load.per_joint)
    # By the velocity against the medium, which SymPy can take an angle of.
    against = symbols("vx_against vy_against", real=True)
    joints = joint_vx[joint], joint_vy[joint]
    vx, vy = (a + wind for a, wind in zip(against, load.wind, strict=True))
    moving = dict(zip(joints, (vx, vy), strict=True))
    speed = speed.subs(moving)
    entries = 0
    for where, (share, length, angle, index) in places.items():
        rod = _value_at(arrays[rod_angle].value, joint, where)
        if sympy.simplify(rod.subs(joint, index) - angle.subs(joint, index)) != 0:
            raise DisagreementError(ANY_N, f"rod angle {where}", rod, angle)
        place = joint_x[joint], joint_y[joint], length
        motion = JointMotion(vx, vy, speed, rod_angle[joint], share * m, factors, *place)
        by_hand = load.force_by_hand(motion, _identity, sympy)
        bases = mass_at, length_at
        gathered = {base[joint]: _value_at(arrays[base].value, joint, where) for base in bases}
        for base, hand in zip(load.bases, by_hand, strict=True):
            force = arrays[base].value.subs(gathered | {divisor[joint]: speed} | moving)
            off = expand(expand_trig(hand) - force)
            if off != 0 and sympy.simplify(off) != 0:
                raise DisagreementError(ANY_N, f"{load.letter} force {where}", force, hand)
            entries += 1
    return Comparison(f"{load.letter} force law", ANY_N, entries)
