"""Exact evaluation at random rational points, for chains too long to compare symbolically.

Angles are taken from Pythagorean triples, so that cosine and sine are rational and every number
below is exact: an entry agrees or it does not, no tolerance is involved.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import reduce
from operator import add, mul
from typing import Any

from sympy import (
    Add,
    And,
    Eq,
    Expr,
    Indexed,
    IndexedBase,
    Mul,
    Or,
    Piecewise,
    Pow,
    Rational,
    Sum,
    Symbol,
    cos,
    sin,
    true,
)

from . import angles
from .closed_form import Arithmetic, ClosedForm
from .comparison import POINTS, Comparison, DisagreementError
from .general import Equations, drag_x, drag_y, joint_moment
from .loads import TERMS
from .symbols import ALPHA, C_INT, F_TIP, NU, G, P, i, j, k, l, later, m, n, omega, phi, s

TURNED = "turned"  # key of what cosine and sine are taken of, where the values hold it apart
ENTRIES = 10_000  # of M and of Q, at most
ROWS = 200  # of the vectors and of banded matrices, at most
REACH = 2_000  # longest sum over joints that is evaluated

EXACT = Arithmetic(
    angles.cos,
    angles.sin,
    Fraction(1, 2),
    lambda term, low, high: sum(term(q) for q in range(low, high + 1)),
)

# label of an entry, derived expression, indices at which it is evaluated, value of the closed form
Entry = tuple[str, Expr, dict[Any, int], Any]


def prove_at_points(
    links: int, boundary: str, inertia: str, terms: Sequence[str] = TERMS, seed: int = 1
) -> Iterator[Comparison]:
    """Entries of derivation 2 at n links against the closed form; raises DisagreementError."""
    return _Points(Equations(boundary, inertia, tuple(terms)), links, seed).compare()


class _Points:
    """A random state of a chain in exact numbers, and the closed form there."""

    def __init__(self, derived: Equations, links: int, seed: int):
        self.derived, self.draw = derived, random.Random(seed)
        palette = [pythagorean(self._rational()) for _ in range(30)]
        directions = [self.draw.choice(palette) for _ in range(links)]
        self.forces = [[self.draw.randint(-99, 99) for _ in range(links + 1)] for _ in range(2)]
        self.values: dict[Any, Any] = {x: self._rational() for x in (m, l, k, P, G, C_INT, *F_TIP)}
        self.values |= {n: links, NU: self.draw.choice(palette), phi: directions}
        self.values |= {drag_x: self.forces[0], drag_y: self.forces[1]}
        sizes = (self.values[m], self.values[l], self.values[k])
        lumped = derived.inertia == "lumped"
        self.closed = ClosedForm(links, *sizes, directions, derived.hold, EXACT, lumped)
        moving = self.closed.links
        self.rows = sorted(
            {*self.draw.sample(moving, min(len(moving), ROWS)), moving[-1], moving[0]}
        )
        few = len(moving) ** 2 <= ENTRIES
        every = ((a, b) for a in moving for b in moving if a != b)
        self.pairs = list(every if few else (self._pair(moving) for _ in range(ENTRIES)))

    def _rational(self) -> Fraction:
        return Fraction(self.draw.randint(1, 99), self.draw.randint(1, 99))

    def _pair(self, moving: range) -> tuple[int, int]:
        a, b = self.draw.sample(moving, 2)
        return a, b

    def compare(self) -> Iterator[Comparison]:
        """All comparisons of the scene's terms."""
        derived, closed, value = self.derived, self.closed, self.values
        yield self._same("M", self._mass())
        yield self._same("Q", self._velocity())
        joined = closed.n > derived.hold.first_spring  # else there is no spring
        if joined:
            moments = derived.spring, derived.root_spring
            yield self._same("K", self._bending(moments, phi, closed.k, ALPHA))
        if "follower" in derived.terms:
            base = closed.F_base(value[P], value[NU])
            hand = [closed.F_link(a, value[P], value[NU]) for a in self.rows]
            yield self._same("F", self._work(derived.follower, base, hand, self.rows))
        if "tip_load" in derived.terms:
            force = (value[F_TIP[0]], value[F_TIP[1]])
            hand = [closed.T_link(a, force) for a in self.rows]
            yield self._same(
                "T", self._work(derived.tip_load, closed.T_base(force), hand, self.rows)
            )
        if "gravity" in derived.terms:
            hand = [closed.A_link(a, value[G]) for a in self.rows]
            yield self._same(
                "A", self._work(derived.gravity, closed.A_base(value[G]), hand, self.rows)
            )
        if "internal_damping" in derived.terms and joined:
            moments = derived.damper, derived.root_damper
            yield self._same("D_i", self._bending(moments, omega, value[C_INT] * value[m]))
        if "external_damping" in derived.terms:
            resisting = ([-f for f in self.forces[0]], [-f for f in self.forces[1]])
            near = [a for a in self.rows if closed.n - a <= REACH]
            base = tuple(-f for f in closed.D_e_base(resisting))
            hand = [-closed.D_e_link(a, resisting) for a in near]
            yield self._same("D_e", self._work(derived.external_damping, base, hand, near))

    def _same(self, name: str, entries: Iterable[Entry]) -> Comparison:
        count = 0
        for label, expression, at, by_hand in entries:
            value = evaluate(expression, {**self.values, **at})
            if value != by_hand:
                raise DisagreementError(POINTS, f"{name}[{label}]", value, by_hand)
            count += 1
        return Comparison(name, POINTS, count)

    def _mass(self) -> Iterator[Entry]:
        derived, closed = self.derived, self.closed
        yield from self._in_pairs(derived.mass_link_link, closed.M_link_link)
        for a in self.rows:
            yield f"phi_{a},phi_{a}", derived.mass_link, {i: a}, closed.M_link(a)
        if derived.hold.translates:
            yield "x0,x0", derived.mass_base, {}, closed.M_base()
            yield from self._in_columns(derived.mass_base_link, closed.M_base_link)

    def _velocity(self) -> Iterator[Entry]:
        derived, closed = self.derived, self.closed
        yield from self._in_pairs(derived.velocity_link_link, closed.Q_link_link)
        if derived.hold.translates:
            yield from self._in_columns(derived.velocity_base_link, closed.Q_base_link)

    def _in_pairs(
        self, expression: Expr, by_hand: Callable[[int, int, int], Any]
    ) -> Iterator[Entry]:
        for a, b in self.pairs:
            at = {i: a, j: b, later: max(a, b)}
            yield f"phi_{a},phi_{b}", expression, at, by_hand(a, b, max(a, b))

    def _in_columns(
        self, expressions: Sequence[Expr], by_hand: Callable[[int], Sequence[Any]]
    ) -> Iterator[Entry]:
        for a in self.rows:
            for axis, expression, hand in zip("xy", expressions, by_hand(a), strict=True):
                yield f"{axis}0,phi_{a}", expression, {i: a}, hand

    def _work(
        self, work: Any, base: Sequence[Any], hand: Sequence[Any], rows: Sequence[int]
    ) -> Iterator[Entry]:
        short = not any(e.has(Sum) for e in work.base) or self.closed.n <= REACH
        if self.derived.hold.translates and short:
            for axis, expression, value in zip("xy", work.base, base, strict=True):
                yield f"{axis}0", expression, {}, value
        for a, value in zip(rows, hand, strict=True):
            yield f"phi_{a}", work.link, {i: a}, value

    def _bending(
        self, moments: tuple[Expr, Expr], of: IndexedBase, factor: Any, clamp: Symbol | None = None
    ) -> Iterator[Entry]:
        """Coefficients of the three links that bend a link, from the moments at its ends, inner
        joint's and root's; clamp: what stands before the first link, unless that is zero."""
        inner, root = moments
        last = self.closed.n - 1
        work = self.derived.link_moment.subs(n, self.closed.n)
        for a in self.rows:
            start = inner.subs(s, i) if a else root.xreplace({of[0]: of[i]})
            here = work.subs({Eq(i, at): at == a for at in (0, last)})
            here = here.xreplace(
                {joint_moment[i]: start, joint_moment[i + 1]: inner.subs(s, i + 1)}
            )
            row = self.closed.bending_row(factor, 1 if a else self.closed.root, int(a < last))
            for neighbour, hand in zip(
                (of[i - 1] if a else clamp, of[i], of[i + 1]), row, strict=True
            ):
                if neighbour is not None:
                    yield f"phi_{a},{neighbour}", -here.diff(neighbour), {i: a}, hand


def pythagorean(t: Fraction) -> angles.Angle:
    """The angle 2 atan(t), whose cosine and sine are rational."""
    return angles.Angle((1 - t * t) / (1 + t * t), 2 * t / (1 + t * t))


def evaluate(expression: Expr, values: dict[Any, Any]) -> Any:
    """Value of an expression in exact arithmetic; angles are angles.Angle."""
    match expression:
        case Rational():
            return Fraction(int(expression.p), int(expression.q))
        case Symbol():
            return values[expression]
        case Indexed():
            return values[expression.base][int(evaluate(expression.indices[0], values))]
        case Piecewise():
            return evaluate(next(e for e, c in expression.args if _holds(c, values)), values)
        case cos() | sin():
            angle = evaluate(expression.args[0], {**values, **values.get(TURNED, {})})
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


def _holds(condition: Any, values: dict[Any, Any]) -> bool:
    """Whether an equality of indices, or several of them, holds."""
    match condition:
        case Eq():
            return bool(evaluate(condition.lhs, values) == evaluate(condition.rhs, values))
        case And():
            return all(_holds(part, values) for part in condition.args)
        case Or():
            return any(_holds(part, values) for part in condition.args)
    return bool(condition == true)
