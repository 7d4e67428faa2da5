"""Derivation 1 at n links against the closed form, and sums of derivation 2 against its chain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import sympy
from sympy import IndexedBase, Sum
from sympy.polys.rings import PolyElement

from rodgen.model.terms import MOVING_BASE, boundary_of

from ..closed_form import Arithmetic, ClosedForm, link_masses
from ..comparison import EXPLICIT, Comparison, DisagreementError
from ..explicit import ExplicitDerivation
from ..general import GeneralEquations
from ..loads import TERMS, loads_of
from ..loads.kinds import JointMoment
from ..polynomials import TIME, Calculus
from ..symbols import (
    HALF,
    PARAMETERS,
    i,
    joint,
    joint_vx,
    joint_vy,
    joint_x,
    joint_y,
    k,
    l,
    m,
    n,
    omega,
    phi,
)
from . import exact


def prove_explicit(
    links: int,
    boundary: str,
    inertia: str,
    terms: Sequence[str] = TERMS,
    nonuniform: Sequence[str] = (),
) -> Iterator[Comparison]:
    """Compare every entry of M, Q, K and the loads at n links; raises DisagreementError."""
    derived = ExplicitDerivation(links, boundary, inertia, tuple(nonuniform), tuple(terms))
    closed = _closed_form(derived)
    compare = partial(_compare, derived.calculus)
    yield compare("M", derived.mass_matrix, closed.M())
    for row, rest in enumerate(derived.remainder):
        for factor, coefficient in rest.items():
            left = derived.calculus.expr(coefficient)
            raise DisagreementError(EXPLICIT, f"row {row}, {factor}", left, 0)
    yield compare("Q", derived.velocity_matrix, closed.Q())
    yield compare(
        "K", derived.stiffness_matrix, [_merge_columns(row, derived.bent) for row in closed.K()]
    )
    if "rest" in nonuniform:
        yield compare("r", [[e] for e in derived.rest_moments], [[e] for e in closed.rest()])
    at_base = tuple(term for term in terms if term.partition("@")[0] == MOVING_BASE)
    yield _compare_joints(derived, GeneralEquations(boundary, inertia, at_base, derived.nonuniform))
    value = _Value(derived)
    for term, load in loads_of(terms, derived.rod).items():
        column = derived.load(term)
        if isinstance(load, JointMoment):
            resisting = [[-e for e in row] for row in derived.rate_coefficients(column)]
            factor = partial(load.coefficient_by_hand, closed, value)
            yield compare(load.letter, resisting, closed.damping(factor))
        else:
            by_hand = load.column_by_hand(closed, value)
            yield compare(load.letter, [[e] for e in column], [[e] for e in by_hand])


class _Value:
    """Numbers and expressions as polynomials of a derivation; angles by cosine and sine."""

    def __init__(self, derived: ExplicitDerivation):
        self._derived = derived
        self._angles = {phi[q]: angle for q, angle in enumerate(derived.angles)}

    def __call__(self, of: Any) -> Any:
        calculus = self._derived.calculus
        if isinstance(of, IndexedBase):
            elements = (e for e in calculus.meaning if e.is_Indexed and e.base == of)
            return {int(e.indices[0]): calculus.generator[e] for e in elements}
        of = self._derived.given.get(of, of)
        if sympy.cos(of) in calculus.generator:
            return exact.Angle(calculus.poly(sympy.cos(of)), calculus.poly(sympy.sin(of)))
        return calculus.poly(of.subs(n, self._derived.n).xreplace(self._angles))


def _closed_form(derived: ExplicitDerivation) -> ClosedForm:
    """The closed form in the polynomials of a derivation."""
    calculus, poly = derived.calculus, derived.calculus.poly
    known = [exact.Angle(poly(sympy.cos(a)), poly(sympy.sin(a))) for a in derived.angles]

    def total(term: Any, low: int, high: int) -> PolyElement:
        return sum((term(q) for q in range(low, high + 1)), start=calculus.zero)

    polynomials = Arithmetic(exact.cos, exact.sin, poly(HALF), total)
    boundary_condition = boundary_of(derived.boundary, derived.terms)
    sizes = (poly(m), poly(l), poly(k))
    lumped = derived.inertia == "lumped"
    joints = dict(zip(boundary_condition.spring_joints(derived.n), derived.joints, strict=True))
    differing, rest = (
        {at: poly(getattr(one, what)) for at, one in joints.items()}
        if what in derived.nonuniform
        else None
        for what in ("stiffness", "rest")
    )

    def of_links(name: str) -> dict[int, PolyElement]:
        return {q: calculus.generator[PARAMETERS[name][q]] for q in range(derived.n)}

    links = link_masses(derived.nonuniform, of_links, lumped, poly(HALF))
    lengths = of_links("link_length") if derived.rod.has_link_lengths else None
    return ClosedForm(
        *(derived.n, *sizes, known, boundary_condition, polynomials, lumped),
        *(differing, links, rest, lengths),
    )


def _merge_columns(row: Sequence[Any], angles: Sequence[Any]) -> list[Any]:
    """Row of K in which columns of one angle are added up."""
    sums: dict[Any, Any] = {}
    for angle, entry in zip(angles, row, strict=True):
        sums[angle] = sums[angle] + entry if angle in sums else entry
    return list(sums.values())


def _compare(
    calculus: Calculus, name: str, one: list[list[Any]], two: list[list[Any]]
) -> Comparison:
    """Compare matrices of polynomials, entry by entry."""
    if [len(row) for row in one] != [len(row) for row in two]:
        raise DisagreementError(EXPLICIT, f"shape of {name}", len(one), len(two))
    for r, (derived_row, closed_row) in enumerate(zip(one, two, strict=True)):
        for c, (derived, closed) in enumerate(zip(derived_row, closed_row, strict=True)):
            if calculus.normal_form(derived - closed):
                shown = calculus.expr(derived), calculus.expr(closed)
                raise DisagreementError(EXPLICIT, f"{name}[{r},{c}]", *shown)
    return Comparison(name, EXPLICIT, sum(map(len, one)))


def _compare_joints(derived: ExplicitDerivation, general: GeneralEquations) -> Comparison:
    """Compare positions and velocities of the joints: running sums of derivation 2, term by term,
    with the differences between neighbouring joints of derivation 1."""
    joints = [derived.joint(q) for q in range(derived.n + 1)]
    rates = [(derived.time_derivative(x), derived.time_derivative(y)) for x, y in joints]
    entries = 0
    for bases, values in (((joint_x, joint_y), joints), ((joint_vx, joint_vy), rates)):
        for axis, base in enumerate(bases):
            start, step, first = _running_sum_parts(general, base)
            steps = [(f"{base}[{first}]", values[first][axis], start)]
            for link in range(first, derived.n):
                difference = values[link + 1][axis] - values[link][axis]
                steps.append((f"{base}[{link + 1}] - {base}[{link}]", difference, step))
            for at, (label, value, expression) in enumerate(steps, start=first - 1):
                _compare_step(derived, label, value, expression, at)
            entries += len(steps)
    return Comparison("joints", EXPLICIT, entries)


def _running_sum_parts(general: GeneralEquations, base: IndexedBase) -> tuple[Any, Any, int]:
    """Start, term and first link of the sum that derivation 2 has for a quantity of the joints."""
    array = general.arrays[base]
    (total,) = array.value.atoms(Sum)
    index, low, high = total.limits[0]
    if (index, low, high) != (i, array.low, joint - 1):
        raise DisagreementError(EXPLICIT, f"limits of {base}", total.limits[0], (i, 0, joint - 1))
    return array.value - total, total.function, int(low)


def _compare_step(
    derived: ExplicitDerivation, label: str, value: PolyElement, expression: Any, link: int
) -> None:
    """Compare a term of derivation 2 at one link, in the coordinates of derivation 1."""
    names = {str(q.func): q for q in derived.base}
    rates = {f"v{name}": q.diff(TIME) for name, q in names.items()}
    here = {symbol: {**names, **rates}.get(str(symbol)) for symbol in expression.free_symbols}
    at = {symbol: q for symbol, q in here.items() if q is not None} | derived.given
    if link >= 0:
        at |= {phi[i]: derived.angles[link], omega[i]: derived.angles[link].diff(TIME)}
    there = derived.calculus.poly(expression.xreplace(at).subs({i: link, n: derived.n}))
    if derived.calculus.normal_form(value - there):
        raise DisagreementError(EXPLICIT, label, there, value)
