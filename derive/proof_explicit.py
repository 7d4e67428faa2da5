"""Derivation 1 at n links against the closed form, and derivation 2's sums against its chain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import sympy
from sympy import IndexedBase, Sum
from sympy.polys.rings import PolyElement

from . import angles
from .calculus import TIME
from .chain import BOUNDARIES
from .closed_form import Arithmetic, ClosedForm
from .comparison import EXPLICIT, Comparison, DisagreementError
from .explicit import ExplicitDerivation
from .general import Equations, joint, joint_vx, joint_vy, joint_x, joint_y
from .loads import TERMS
from .symbols import C_INT, F_TIP, HALF, NU, G, P, i, k, l, m, n, omega, phi


def prove_explicit(
    links: int, boundary: str, inertia: str, terms: Sequence[str] = TERMS
) -> Iterator[Comparison]:
    """Every entry of M, Q, K and the loads at n links; raises DisagreementError."""
    derived = ExplicitDerivation(links, boundary, inertia)
    poly = derived.calculus.poly
    closed = _closed_form(derived)
    compare = _Compare(derived)
    yield compare("M", derived.mass_matrix, closed.M())
    for row, rest in enumerate(derived.remainder):
        for factor, coefficient in rest.items():
            left = derived.calculus.expr(coefficient)
            raise DisagreementError(EXPLICIT, f"row {row}, {factor}", left, 0)
    yield compare("Q", derived.velocity_matrix, closed.Q())
    yield compare("K", derived.stiffness_matrix, closed.K())
    yield _chain(derived, Equations(boundary, inertia, ()))
    if "follower" in terms:
        nu = angles.Angle(poly(sympy.cos(NU)), poly(sympy.sin(NU)))
        yield compare("F", _column(derived.follower), _column(closed.F(poly(P), nu)))
    if "tip_load" in terms:
        force = (poly(F_TIP[0]), poly(F_TIP[1]))
        yield compare("T", _column(derived.tip_load), _column(closed.T(force)))
    if "gravity" in terms:
        yield compare("A", _column(derived.gravity), _column(closed.A(poly(G))))
    if "internal_damping" in terms:
        yield compare("D_i", derived.internal_damping, closed.D_i(poly(C_INT)))
    if "external_damping" in terms:
        forces = {derived.first_joint + at: force for at, force in enumerate(derived.drag)}
        D_x, D_y = ({q: poly(force[at]) for q, force in forces.items()} for at in (0, 1))
        yield compare("D_e", _column(derived.external_damping), _column(closed.D_e((D_x, D_y))))


def _closed_form(derived: ExplicitDerivation) -> ClosedForm:
    """The closed form in the polynomials of a derivation."""
    calculus, poly = derived.calculus, derived.calculus.poly
    known = [angles.Angle(poly(sympy.cos(a)), poly(sympy.sin(a))) for a in derived.angles]

    def total(term: Any, low: int, high: int) -> PolyElement:
        return sum((term(q) for q in range(low, high + 1)), start=calculus.zero)

    polynomials = Arithmetic(angles.cos, angles.sin, poly(HALF), total)
    hold = BOUNDARIES[derived.boundary]
    sizes = (poly(m), poly(l), poly(k))
    lumped = derived.inertia == "lumped"
    return ClosedForm(derived.n, *sizes, known, hold, polynomials, lumped)


def _column(entries: Sequence[Any]) -> list[list[Any]]:
    return [[entry] for entry in entries]


class _Compare:
    """Compares matrices of polynomials, entry by entry."""

    def __init__(self, derived: ExplicitDerivation):
        self._calculus = derived.calculus

    def __call__(self, name: str, one: list[list[Any]], two: list[list[Any]]) -> Comparison:
        if [len(row) for row in one] != [len(row) for row in two]:
            raise DisagreementError(EXPLICIT, f"shape of {name}", len(one), len(two))
        for r, (derived_row, closed_row) in enumerate(zip(one, two, strict=True)):
            for c, (derived, closed) in enumerate(zip(derived_row, closed_row, strict=True)):
                if self._calculus.normal(derived - closed):
                    shown = self._calculus.expr(derived), self._calculus.expr(closed)
                    raise DisagreementError(EXPLICIT, f"{name}[{r},{c}]", *shown)
        return Comparison(name, EXPLICIT, sum(map(len, one)))


def _chain(derived: ExplicitDerivation, general: Equations) -> Comparison:
    """Positions and velocities of the joints: the running sums of derivation 2, term by term,
    against the differences between neighbouring joints of derivation 1."""
    joints = [derived.joint(q) for q in range(derived.n + 1)]
    rates = [(derived.rate(x), derived.rate(y)) for x, y in joints]
    entries = 0
    for bases, values in (((joint_x, joint_y), joints), ((joint_vx, joint_vy), rates)):
        for axis, base in enumerate(bases):
            start, step, first = _running_sum(general, base)
            steps = [(f"{base}[{first}]", values[first][axis], start)]
            for link in range(first, derived.n):
                difference = values[link + 1][axis] - values[link][axis]
                steps.append((f"{base}[{link + 1}] - {base}[{link}]", difference, step))
            for at, (label, value, expression) in enumerate(steps, start=first - 1):
                _same_step(derived, label, value, expression, at)
            entries += len(steps)
    return Comparison("joints", EXPLICIT, entries)


def _running_sum(general: Equations, base: IndexedBase) -> tuple[Any, Any, int]:
    """Start, term and first link of the sum that derivation 2 has for a quantity of the joints."""
    array = general.arrays[base]
    (total,) = array.value.atoms(Sum)
    index, low, high = total.limits[0]
    if (index, low, high) != (i, array.low, joint - 1):
        raise DisagreementError(EXPLICIT, f"limits of {base}", total.limits[0], (i, 0, joint - 1))
    return array.value - total, total.function, int(low)


def _same_step(
    derived: ExplicitDerivation, label: str, value: PolyElement, expression: Any, link: int
) -> None:
    """A term of derivation 2 at one link, in the coordinates of derivation 1."""
    names = {str(q.func): q for q in derived.base}
    rates = {f"v{name}": q.diff(TIME) for name, q in names.items()}
    here = {symbol: {**names, **rates}.get(str(symbol)) for symbol in expression.free_symbols}
    at = {symbol: q for symbol, q in here.items() if q is not None}
    if link >= 0:
        at |= {phi[i]: derived.angles[link], omega[i]: derived.angles[link].diff(TIME)}
    there = derived.calculus.poly(expression.xreplace(at).subs({i: link, n: derived.n}))
    if derived.calculus.normal(value - there):
        raise DisagreementError(EXPLICIT, label, there, value)
