"""Exact arithmetic: angles known by cosine and sine, values of expressions in rational numbers."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from operator import add, eq, le, lt, mul
from typing import Any

import sympy
from sympy import (
    Add,
    And,
    Eq,
    Expr,
    Indexed,
    Le,
    Lt,
    Mul,
    Or,
    Piecewise,
    Pow,
    Rational,
    Sum,
    Symbol,
    true,
)

TURNED = "turned"  # key of what cosine and sine are taken of, where the values hold it apart


@dataclass(frozen=True)
class Angle:
    """An angle with exact cosine and sine; sums and differences by the addition theorems."""

    c: Any
    s: Any

    def __add__(self, other: Angle) -> Angle:
        return Angle(self.c * other.c - self.s * other.s, self.s * other.c + self.c * other.s)

    def __rmul__(self, sign: Any) -> Angle:
        if sign != -1:
            raise ValueError(
                f"only minus an angle is known by cosine and sine, not {sign} times it"
            )
        return Angle(self.c, -self.s)

    def __sub__(self, other: Angle) -> Angle:
        return Angle(self.c * other.c + self.s * other.s, self.s * other.c - self.c * other.s)


def cos(angle: Angle) -> Any:
    return angle.c


def sin(angle: Angle) -> Any:
    return angle.s


def pythagorean(t: Fraction) -> Angle:
    """The angle 2 atan(t), whose cosine and sine are rational."""
    return Angle((1 - t * t) / (1 + t * t), 2 * t / (1 + t * t))


def evaluate(expression: Expr, values: dict[Any, Any]) -> Any:
    """Value of an expression in exact arithmetic; angles are Angle."""
    match expression:
        case Rational():
            return Fraction(int(expression.p), int(expression.q))
        case Symbol():
            return values[expression]
        case Indexed():
            return values[expression.base][int(evaluate(expression.indices[0], values))]
        case Piecewise():
            return evaluate(next(e for e, c in expression.args if _is_true(c, values)), values)
        case sympy.cos() | sympy.sin():
            angle = evaluate(expression.args[0], {**values, **values.get(TURNED, {})})
            return angle.c if isinstance(expression, sympy.cos) else angle.s
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


def _is_true(condition: Any, values: dict[Any, Any]) -> bool:
    """Whether a comparison of indices, or several of them, holds."""
    match condition:
        case Eq() | Le() | Lt():
            compare = {Eq: eq, Le: le, Lt: lt}[type(condition)]
            return bool(compare(evaluate(condition.lhs, values), evaluate(condition.rhs, values)))
        case And():
            return all(_is_true(part, values) for part in condition.args)
        case Or():
            return any(_is_true(part, values) for part in condition.args)
    return bool(condition == true)
