"""The proofs: derivations 1 and 2 against the closed form, entry by entry, exactly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import sympy
from sympy import Expr, Integer, Piecewise, Sum, Symbol, expand, expand_trig

from . import angles
from .calculus import TIME
from .chain import BOUNDARIES
from .closed_form import ClosedForm, joint_drag, joint_velocity
from .explicit import ExplicitDerivation
from .general import Array, Equations, drag_x, drag_y, joint, joint_vx, joint_vy, mass_at, rod_angle
from .loads import TERMS
from .symbols import (
    C_EXT,
    C_INT,
    HALF,
    NU,
    G,
    P,
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

EXPLICIT = "explicit n"
ANY_N = "any n"
POINTS = "rational points"


class DisagreementError(ArithmeticError):
    """Two derivations differ in an entry."""

    def __init__(self, how: str, entry: str, derived: object, closed: object):
        self.how, self.entry, self.derived, self.closed = how, entry, derived, closed
        super().__init__(f"{entry} ({how}): derived {derived}, closed form {closed}")


@dataclass(frozen=True)
class Comparison:
    """What was compared: the symbol of the matrix or load, how, and how many entries."""

    name: str
    how: str
    entries: int


TERM_SYMBOLS = {
    "follower": "F",
    "gravity": "A",
    "internal_damping": "D_i",
    "external_damping": "D_e",
}


def prove_explicit(
    n_links: int, boundary: str, inertia: str, terms: Sequence[str] = TERMS
) -> Iterator[Comparison]:
    """Derivation 1 at n links against the closed form; raises DisagreementError."""
    derived = ExplicitDerivation(n_links, boundary, inertia)
    poly, calculus = derived.calculus.poly, derived.calculus
    hold = BOUNDARIES[boundary]
    known = [angles.Angle(poly(sympy.cos(a)), poly(sympy.sin(a))) for a in derived.angles]
    nu = angles.Angle(poly(sympy.cos(NU)), poly(sympy.sin(NU)))
    closed = ClosedForm(
        n_links,
        poly(m),
        poly(l),
        poly(k),
        known,
        angles.cos,
        angles.sin,
        poly(HALF),
        lambda term, low, high: sum((term(q) for q in range(low, high + 1)), start=calculus.zero),
        hold.translates,
        hold.first,
    )
    forces = {derived.first_joint + at: force for at, force in enumerate(derived.drag)}
    D_x = {q: poly(force[0]) for q, force in forces.items()}
    D_y = {q: poly(force[1]) for q, force in forces.items()}

    def matrix(name: str, one: Sequence[Any], two: Sequence[Any]) -> Comparison:
        one, two = ([row if isinstance(row, list) else [row] for row in x] for x in (one, two))
        if [len(row) for row in one] != [len(row) for row in two]:
            raise DisagreementError(EXPLICIT, f"shape of {name}", len(one), len(two))
        for r, (a_row, b_row) in enumerate(zip(one, two, strict=True)):
            for c, (a, b) in enumerate(zip(a_row, b_row, strict=True)):
                if calculus.normal(a - b):
                    derived_entry, closed_entry = calculus.expr(a), calculus.expr(b)
                    raise DisagreementError(
                        EXPLICIT, f"{name}[{r},{c}]", derived_entry, closed_entry
                    )
        return Comparison(name, EXPLICIT, sum(map(len, one)))

    yield matrix("M", derived.mass_matrix, closed.M())
    for r, rest in enumerate(derived.remainder):
        for factor, coefficient in rest.items():
            raise DisagreementError(EXPLICIT, f"row {r}, {factor}", calculus.expr(coefficient), 0)
    yield matrix("Q", derived.velocity_matrix, closed.Q())
    yield matrix("K", derived.stiffness_matrix, closed.K())
    if "follower" in terms:
        yield matrix("F", derived.follower, closed.F(poly(P), nu))
    if "gravity" in terms:
        yield matrix("A", derived.gravity, closed.A(poly(G)))
    if "internal_damping" in terms:
        yield matrix("D_i", derived.internal_damping, closed.D_i(poly(C_INT)))
    if "external_damping" in terms:
        yield matrix("D_e", derived.external_damping, closed.D_e((D_x, D_y)))
        rates = [poly(a.diff(TIME)) for a in derived.angles]
        base = [poly(q.diff(TIME)) for q in derived.base] or [calculus.zero] * 2
        joints = range(derived.first_joint, n_links + 1)
        velocities = [[derived.rate(c) for c in derived.joint(q)] for q in joints]
        by_hand = [
            list(joint_velocity(q, poly(l), known, rates, (base[0], base[1]), angles))
            for q in joints
        ]
        yield matrix("v of the joints", velocities, by_hand)
        yield _drag_law(EXPLICIT, Equations(boundary, inertia, ("external_damping",)).arrays)


def prove_any_n(boundary: str, inertia: str, terms: Sequence[str] = TERMS) -> Iterator[Comparison]:
    """Derivation 2 against the closed form, for symbolic n, i and j; raises DisagreementError."""
    derived = Equations(boundary, inertia, tuple(terms))
    hold = BOUNDARIES[boundary]
    dummy = Symbol("q", integer=True)
    closed = ClosedForm(
        n,
        m,
        l,
        k,
        phi,
        sympy.cos,
        sympy.sin,
        HALF,
        lambda term, low, high: Sum(term(dummy), (dummy, low, high)),
        hold.translates,
        hold.first,
    )

    def same(name: str, *pairs: tuple[Expr, Expr]) -> Comparison:
        for at, (one, two) in enumerate(pairs):
            if _difference(one, two) != 0:
                raise DisagreementError(ANY_N, f"{name}, identity {at}", one, two)
        return Comparison(name, ANY_N, len(pairs))

    def base(one: Sequence[Expr], two: Sequence[Expr]) -> list[tuple[Expr, Expr]]:
        return list(zip(one, two, strict=True)) if hold.translates else []

    yield same(
        "M",
        *base([derived.mass_base], [closed.M_base()]),
        *base(derived.mass_base_link, closed.M_base_link(i)),
        (derived.mass_link, closed.M_link(i)),
        (derived.mass_link_link, closed.M_link_link(i, j, later)),
    )
    yield same(
        "Q",
        *base(derived.velocity_base_link, closed.Q_base_link(i)),
        (derived.velocity_link_link, closed.Q_link_link(i, j, later)),
    )
    yield same("K", *_second_difference(derived.spring, phi, k))
    if "follower" in terms:
        yield same(
            "F",
            *base(derived.follower.base, closed.F_base(P, NU)),
            (derived.follower.link, closed.F_link(i, P, NU)),
        )
    if "gravity" in terms:
        yield same(
            "A",
            *base(derived.gravity.base, closed.A_base(G)),
            (derived.gravity.link, closed.A_link(i, G)),
        )
    if "internal_damping" in terms:
        yield same("D_i", *_second_difference(derived.damper, omega, C_INT * m))
    if "external_damping" in terms:
        resisting = (_Opposite(drag_x), _Opposite(drag_y))
        work = derived.external_damping
        yield same(
            "D_e",
            *base(work.base, [-e for e in closed.D_e_base(resisting)]),
            (work.link, -closed.D_e_link(i, resisting)),
        )
        yield _drag_law(ANY_N, derived.arrays)


class _Opposite:
    """The resisting force of the closed form: minus the force of the derivation."""

    def __init__(self, base: sympy.IndexedBase):
        self.base = base

    def __getitem__(self, index: Expr) -> Expr:
        return -self.base[index]


def _second_difference(
    moments: Any, of: sympy.IndexedBase, factor: Expr
) -> list[tuple[Expr, Expr]]:
    """Moments on a link from the joints at its ends, against rows of K or D_i."""
    start, end = moments.after.subs(s, i), moments.before.subs(s, i + 1)
    return [
        (start + end, -factor * (2 * of[i] - of[i - 1] - of[i + 1])),
        (end, -factor * (of[i] - of[i + 1])),
        (start, -factor * (of[i] - of[i - 1])),
    ]


def _difference(one: Expr, two: Expr) -> Expr:
    """Zero if the two are equal: angle sums expanded, sums taken apart, terms collected."""

    def flat(e: Expr) -> Expr:
        return expand(expand_trig(expand(_renamed(e))))

    return expand(flat(one) - flat(two))


def _renamed(expression: Expr) -> Expr:
    """Sums with one name for their index, and constant factors in front."""
    q = Symbol("q", integer=True)

    def rename(total: Sum) -> Expr:
        index, low, high = total.limits[0]
        coefficient, summand = total.function.subs(index, q).as_coeff_Mul()
        return coefficient * Sum(summand, (q, low, high))

    return expression.replace(lambda e: isinstance(e, Sum), rename)


def _drag_law(how: str, arrays: dict[Any, Array]) -> Comparison:
    """The force law at the start, inside and at the tail, against the thesis's angles."""
    hold_start = arrays[drag_x].low == 0
    positions: dict[str, tuple[Expr, Expr, Expr]] = {
        "inside": (m, (phi[joint - 1] + phi[joint]) / 2, joint),
        "tail": (m / 2, phi[n - 1], n),
    }
    if hold_start:
        positions["start"] = (m / 2, phi[0], Integer(0))
    entries = 0
    for where, (mass, angle, index) in positions.items():
        rod = _at(arrays[rod_angle].value, where)
        if expand(rod.subs(joint, index) - angle.subs(joint, index)) != 0:
            raise DisagreementError(how, f"rod angle {where}", rod, angle)
        v = joint_vx[joint], joint_vy[joint]
        by_hand = joint_drag(C_EXT, fin_factor[joint], mass, v, rod_angle[joint], sympy)
        for base, hand in zip((drag_x, drag_y), by_hand, strict=True):
            derived = _at(arrays[base].value.subs(mass_at[joint], arrays[mass_at].value), where)
            if sympy.simplify(expand_trig(hand) + derived) != 0:
                raise DisagreementError(how, f"D_e force {where}", -derived, hand)
            entries += 1
    return Comparison("D_e force law", how, entries)


def _at(value: Expr, where: str) -> Expr:
    """One case of an expression that differs at the ends of the rod; the joint in motion."""
    conditions = {
        sympy.Eq(joint, 0): where == "start",
        sympy.Eq(joint, n): where == "tail",
    }
    chosen = value.subs(conditions)
    return chosen.replace(lambda e: isinstance(e, Piecewise), lambda e: e.args[0].expr).doit()
