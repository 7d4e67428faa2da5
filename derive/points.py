"""Exact evaluation at random rational points, for chains too long to compare symbolically.

Angles are taken from Pythagorean triples, so that cosine and sine are rational and every number
below is exact: an entry agrees or it does not, no tolerance is involved.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import reduce
from operator import add, mul
from typing import Any

from sympy import Add, Expr, Indexed, Mul, Pow, Rational, Sum, Symbol, cos, sin

from . import angles
from .chain import BOUNDARIES
from .closed_form import ClosedForm
from .general import Equations, drag_x, drag_y
from .loads import TERMS
from .proof import POINTS, Comparison, DisagreementError
from .symbols import NU, G, P, i, j, k, l, later, m, n, phi

ENTRIES = 10_000  # of M and of Q, at most, at each point
ROWS = 200  # of the vectors, at most, at each point
REACH = 2_000  # longest sum over joints that is evaluated


def evaluate(expression: Expr, values: dict[Any, Any]) -> Any:
    """Value of an expression in exact arithmetic; angles are angles.Angle."""
    match expression:
        case Rational():
            return Fraction(int(expression.p), int(expression.q))
        case Symbol():
            return values[expression]
        case Indexed():
            return values[expression.base][int(evaluate(expression.indices[0], values))]
        case cos() | sin():
            angle = evaluate(expression.args[0], values)
            return angle.c if isinstance(expression, cos) else angle.s
        case Add():
            return reduce(add, (evaluate(a, values) for a in expression.args))
        case Mul():
            return reduce(mul, (evaluate(a, values) for a in expression.args))
        case Pow():
            return evaluate(expression.base, values) ** int(expression.exp)
        case Sum():
            index, low, high = expression.limits[0]
            span = range(int(evaluate(low, values)), int(evaluate(high, values)) + 1)
            terms = (evaluate(expression.function, {**values, index: q}) for q in span)
            return sum(terms, start=Fraction(0))
    raise TypeError(f"no exact value for {expression}")


def prove_at_points(
    n_links: int, boundary: str, inertia: str, terms: Sequence[str] = TERMS, seed: int = 1
) -> Iterator[Comparison]:
    """Entries of derivation 2 at n links against the closed form; raises DisagreementError."""
    draw = random.Random(seed)
    derived, hold = Equations(boundary, inertia, tuple(terms)), BOUNDARIES[boundary]

    def rational() -> Fraction:
        return Fraction(draw.randint(1, 99), draw.randint(1, 99))

    palette = [_pythagorean(rational()) for _ in range(30)]
    directions = [draw.choice(palette) for _ in range(n_links)]
    forces = [[draw.randint(-99, 99) for _ in range(n_links + 1)] for _ in range(2)]
    values: dict[Any, Any] = {symbol: rational() for symbol in (m, l, k, P, G)}
    values |= {n: n_links, NU: draw.choice(palette), phi: directions}
    values |= {drag_x: forces[0], drag_y: forces[1]}
    closed = ClosedForm(
        n_links,
        values[m],
        values[l],
        values[k],
        directions,
        angles.cos,
        angles.sin,
        Fraction(1, 2),
        lambda term, low, high: sum(term(q) for q in range(low, high + 1)),
        hold.translates,
        hold.first,
    )
    links = range(hold.first, n_links)
    rows = sorted(draw.sample(links, min(len(links), ROWS)))
    pairs = (
        [(a, b) for a in links for b in links if a != b]
        if len(links) ** 2 <= ENTRIES
        else [(a, b) for a, b in (draw.sample(links, 2) for _ in range(ENTRIES))]
    )

    def same(name: str, entries: Iterator[tuple[str, Expr, dict[Any, int], Any]]) -> Comparison:
        count = 0
        for label, expression, at, by_hand in entries:
            value = evaluate(expression, {**values, **at})
            if value != by_hand:
                raise DisagreementError(POINTS, f"{name}[{label}]", value, by_hand)
            count += 1
        return Comparison(name, POINTS, count)

    def in_pairs(expression: Expr, by_hand: Any) -> Iterator[tuple[str, Expr, dict[Any, int], Any]]:
        for a, b in pairs:
            at = {i: a, j: b, later: max(a, b)}
            yield f"phi_{a},phi_{b}", expression, at, by_hand(a, b, max(a, b))

    def in_rows(
        expressions: Sequence[Expr], by_hand: Any, over: Sequence[int] = rows
    ) -> Iterator[tuple[str, Expr, dict[Any, int], Any]]:
        for a in over:
            hand = by_hand(a)
            for at, expression in enumerate(expressions):
                label = f"{'xy'[at]}0,phi_{a}" if len(expressions) > 1 else f"phi_{a}"
                yield label, expression, {i: a}, hand[at] if len(expressions) > 1 else hand

    yield same("M", in_pairs(derived.mass_link_link, closed.M_link_link))
    yield same("M diagonal", in_rows([derived.mass_link], closed.M_link))
    yield same("Q", in_pairs(derived.velocity_link_link, closed.Q_link_link))
    if hold.translates:
        yield same("M base", in_rows(derived.mass_base_link, closed.M_base_link))
        yield same("Q base", in_rows(derived.velocity_base_link, closed.Q_base_link))
    if "follower" in terms:
        hand = lambda a: closed.F_link(a, values[P], values[NU])  # noqa: E731
        yield same("F", in_rows([derived.follower.link], hand))
    if "gravity" in terms:
        yield same("A", in_rows([derived.gravity.link], lambda a: closed.A_link(a, values[G])))
    if "external_damping" in terms:
        resisting = ([-f for f in forces[0]], [-f for f in forces[1]])
        near = [a for a in rows if n_links - a <= REACH]
        hand = lambda a: -closed.D_e_link(a, resisting)  # noqa: E731
        yield same("D_e", in_rows([derived.external_damping.link], hand, near))


def _pythagorean(t: Fraction) -> angles.Angle:
    """The angle 2 atan(t), whose cosine and sine are rational."""
    return angles.Angle((1 - t * t) / (1 + t * t), 2 * t / (1 + t * t))
