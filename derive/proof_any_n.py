"""Derivation 2 against the closed form, for symbolic n, i and j."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import sympy
from sympy import Expr, IndexedBase, Integer, S, Sum, Symbol, expand, expand_trig

from .closed_form import Arithmetic, ClosedForm, joint_drag, link_sizes
from .comparison import ANY_N, Comparison, DisagreementError
from .general import (
    Array,
    Equations,
    divisor,
    drag_x,
    drag_y,
    joint,
    joint_moment,
    joint_vx,
    joint_vy,
    joint_x,
    joint_y,
    mass_at,
    rod_angle,
)
from .loads import TERMS
from .symbols import (
    ALPHA,
    C_EXT,
    C_INT,
    F_TIP,
    HALF,
    NU,
    PARAMETERS,
    G,
    P,
    discretisation,
    fin_factor,
    i,
    j,
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


def prove_any_n(boundary: str, inertia: str, terms: Sequence[str] = TERMS) -> Iterator[Comparison]:
    """Sizes of a link, every kind of entry of M, Q, K and the loads; raises DisagreementError."""
    yield _same("sizes", _sizes())
    derived = Equations(boundary, inertia, tuple(terms))
    closed = ClosedForm(n, m, l, k, phi, derived.hold, SYMBOLIC, inertia == "lumped")
    for name, pairs in _matrices(derived, closed).items():
        yield _same(name, pairs)
    loads = _loads(derived, closed)
    for term in terms:
        for name, pairs in loads[term].items():
            yield _same(name, pairs)
    if "external_damping" in terms:
        yield _drag_law(derived.arrays)


def _sizes() -> Pairs:
    M, L, EI = (PARAMETERS[name] for name in ("mass", "length", "bending_stiffness"))
    derived = discretisation()
    return list(zip((derived[m], derived[l], derived[k]), link_sizes(M, L, EI, n), strict=True))


def _matrices(derived: Equations, closed: ClosedForm) -> dict[str, Pairs]:
    base = derived.hold.translates
    M: Pairs = [
        (derived.mass_link, closed.M_link(i)),
        (derived.mass_link_link, closed.M_link_link(i, j, later)),
    ]
    Q: Pairs = [(derived.velocity_link_link, closed.Q_link_link(i, j, later))]
    if base:
        M.append((derived.mass_base, closed.M_base()))
        M += zip(derived.mass_base_link, closed.M_base_link(i), strict=True)
        Q += zip(derived.velocity_base_link, closed.Q_base_link(i), strict=True)
    K = _bending(derived, (derived.spring, derived.root_spring), phi, closed, closed.k, ALPHA)
    steps: Pairs = []
    by_hand = (*closed.joint_step(i), *closed.velocity_step(i, omega[i]))
    for quantity, hand in zip((joint_x, joint_y, joint_vx, joint_vy), by_hand, strict=True):
        (total,) = derived.arrays[quantity].value.atoms(Sum)
        steps.append((total.function, hand))
    return {"M": M, "Q": Q, "K": K, "joints": steps}


def _loads(derived: Equations, closed: ClosedForm) -> dict[str, dict[str, Pairs]]:
    resisting = (_Opposite(drag_x), _Opposite(drag_y))
    works = {
        "follower": ("F", derived.follower, closed.F_base(P, NU), closed.F_link(i, P, NU)),
        "tip_load": ("T", derived.tip_load, closed.T_base(F_TIP), closed.T_link(i, F_TIP)),
        "gravity": ("A", derived.gravity, closed.A_base(G), closed.A_link(i, G)),
        "external_damping": (
            "D_e",
            derived.external_damping,
            [-e for e in closed.D_e_base(resisting)],
            -closed.D_e_link(i, resisting),
        ),
    }
    loads = {}
    for term, (name, work, base, link) in works.items():
        pairs: Pairs = [(work.link, link)]
        if derived.hold.translates:
            pairs += zip(work.base, base, strict=True)
        loads[term] = {name: pairs}
    dampers = derived.damper, derived.root_damper
    D_i = _bending(derived, dampers, omega, closed, C_INT * m, S.Zero)
    loads["internal_damping"] = {"D_i": D_i}
    return loads


class _Opposite:
    """The resisting force of the closed form: minus the force of the derivation."""

    def __init__(self, base: IndexedBase):
        self._base = base

    def __getitem__(self, index: Expr) -> Expr:
        return -self._base[index]


def _bending(
    derived: Equations,
    moments: tuple[Expr, Expr],
    of: IndexedBase,
    closed: ClosedForm,
    factor: Expr,
    clamp: Expr,
) -> Pairs:
    """What the joints at its ends do to a link, against its row of K or D_i: for a link inside,
    for the first of all, and for the last. moments: of an inner joint and of the root; clamp:
    what stands before the first link."""
    pairs = []
    inner, root = moments
    for where, ends in {"inside": (1, 1), "tail": (1, 0), "start": (closed.root, 1)}.items():
        if where == "start" and derived.hold.first:
            continue
        work = _case(derived.link_moment, i, where)
        acting = {joint_moment[at]: inner.subs(s, at) for at in (i, i + 1)}
        if where == "start":
            acting[joint_moment[i]] = root.xreplace({of[0]: of[i]})
        links = (clamp if where == "start" else of[i - 1], of[i], of[i + 1])
        row = closed.bending_row(factor, *ends)
        by_hand = sum(c * at for c, at in zip(row, links, strict=True))
        pairs.append((work.xreplace(acting), -by_hand))
    return pairs


def _case(value: Expr, index: Symbol, where: str) -> Expr:
    """An expression that differs at the ends of its index, at one of the places."""
    ends = {0: where == "start", n: where == "tail", n - 1: where == "tail"}
    return value.subs({sympy.Eq(index, end): holds for end, holds in ends.items()})


def _same(name: str, pairs: Pairs) -> Comparison:
    for at, (derived, closed) in enumerate(pairs):
        if expand(_flat(derived) - _flat(closed)) != 0:
            raise DisagreementError(ANY_N, f"{name}, identity {at}", derived, closed)
    return Comparison(name, ANY_N, len(pairs))


def _flat(expression: Expr) -> Expr:
    """Angle sums expanded, sums taken apart and given one name for their index."""

    def rename(total: Sum) -> Expr:
        index, low, high = total.limits[0]
        coefficient, summand = total.function.subs(index, _q).as_coeff_Mul()
        return coefficient * Sum(summand, (_q, low, high))

    renamed = expression.replace(lambda e: isinstance(e, Sum), rename)
    return expand(expand_trig(expand(renamed)))


def _drag_law(arrays: Mapping[IndexedBase, Array]) -> Comparison:
    """The force on a joint at the start, inside and at the tail, against the thesis's angles."""
    places: dict[str, tuple[Expr, Expr, Expr]] = {
        "inside": (m, (phi[joint - 1] + phi[joint]) / 2, joint),
        "tail": (m / 2, phi[n - 1], n),
        "start": (m / 2, phi[0], Integer(0)),
    }
    if arrays[drag_x].low != 0:
        del places["start"]
    # At rest both forms have no force; in motion the divisor is the speed.
    (speed, _), _ = arrays[divisor].value.args
    entries = 0
    for where, (mass, angle, index) in places.items():
        rod = _case(arrays[rod_angle].value, joint, where)
        if expand(rod.subs(joint, index) - angle.subs(joint, index)) != 0:
            raise DisagreementError(ANY_N, f"rod angle {where}", rod, angle)
        v = joint_vx[joint], joint_vy[joint]
        by_hand = joint_drag(C_EXT, fin_factor[joint], mass, v, rod_angle[joint], sympy)
        for base, hand in zip((drag_x, drag_y), by_hand, strict=True):
            gathered = _case(arrays[mass_at].value, joint, where)
            derived = arrays[base].value.subs({mass_at[joint]: gathered, divisor[joint]: speed})
            if sympy.simplify(expand_trig(hand) + derived) != 0:
                raise DisagreementError(ANY_N, f"D_e force {where}", -derived, hand)
            entries += 1
    return Comparison("D_e force law", ANY_N, entries)
