"""Whether two expressions of the model are equal: exact, by a normal form.

Cosines and sines of sums of angles are expanded, so that what is left is a polynomial over the
rationals in the letters, the cosines and the sines; with every s^2 replaced by 1 - c^2 it is zero
if and only if the expression is, since no angle that is left is a multiple of another.
"""

from __future__ import annotations

from functools import cache

from sympy import (
    QQ,
    Abs,
    Dummy,
    Expr,
    Rational,
    cos,
    expand,
    expand_trig,
    factor_terms,
    fraction,
    simplify,
    sin,
    sympify,
    together,
)
from sympy.polys.polyerrors import PolynomialError
from sympy.polys.rings import PolyElement, PolyRing
from sympy.simplify.fu import TR8


class UndecidedError(ArithmeticError):
    """An expression that could be shown neither to be zero nor not to be."""


@cache
def _expand_angles(term: Expr) -> Expr:
    """Expand cos or sin of a sum of angles by the addition theorems."""
    return expand_trig(term)


def addition_theorems(expression: Expr) -> Expr:
    """The expression in cosines and sines of single angles."""
    found = expression.atoms(cos, sin)
    return expression.xreplace({term: _expand_angles(term) for term in found})


def normal_forms(*expressions: Expr) -> list[PolyElement]:
    """Normal forms of several expressions in one ring; PolynomialError for what is none."""
    flat = [addition_theorems(sympify(e)) for e in expressions]
    angles = sorted({t.args[0] for e in flat for t in e.atoms(cos, sin)}, key=str)
    if len({angle.as_coeff_Mul()[1] for angle in angles}) < len(angles):
        raise PolynomialError(f"angles that depend on one another: {angles}")
    names: dict[Expr, Expr] = {}
    for angle in angles:
        names[cos(angle)], names[sin(angle)] = Dummy(f"c({angle})"), Dummy(f"s({angle})")
    plain = [e.xreplace(names) for e in flat]
    letters = sorted({x for e in plain for x in e.free_symbols} - set(names.values()), key=str)
    ring = PolyRing([*letters, *names.values()], QQ)
    try:
        polynomials = [ring.from_expr(e) for e in plain]
    except ValueError as error:
        raise PolynomialError(str(error)) from None
    for angle in angles:
        at = ring.symbols.index(names[sin(angle)])
        cosine = ring.gens[ring.symbols.index(names[cos(angle)])]
        polynomials = [_without_square(p, at, 1 - cosine**2) for p in polynomials]
    return polynomials


def _without_square(poly: PolyElement, at: int, square: PolyElement) -> PolyElement:
    """The polynomial with the square of a generator replaced."""
    if poly.degree(at) < 2:
        return poly
    total = poly.ring.zero
    for monomial, coefficient in poly.terms():
        power, rest = divmod(monomial[at], 2)
        low = (*monomial[:at], rest, *monomial[at + 1 :])
        total += poly.ring.term_new(low, coefficient) * square**power
    return total


@cache  # many entries are the same for every n
def is_zero(expression: Expr) -> bool:
    """Exactly zero or not; raises UndecidedError."""
    try:
        return not normal_forms(expression)[0]
    except PolynomialError:
        return _is_zero_fraction(expression)


def _is_zero_fraction(expression: Expr) -> bool:
    """Whether an expression that is no polynomial is zero.

    By its numerator, a number at a point, or SymPy's simplify.
    """
    numerator, denominator = fraction(together(addition_theorems(expression)))
    if denominator != 1:
        try:
            return not normal_forms(numerator)[0]
        except PolynomialError:
            pass
    if _differs_at_a_point(expression):
        return False
    if simplify(expression) == 0:
        return True
    raise UndecidedError(f"neither zero nor not: {expression}")


def _differs_at_a_point(expression: Expr) -> bool:
    """Whether 50-digit arithmetic at a rational point, one with every sign that may be, gives more
    than rounding can."""
    letters = sorted(expression.free_symbols, key=str)
    for sign in (1, -1):
        point = {
            x: Rational(7 * at + 3, 5 * at + 11) * (1 if x.is_nonnegative else sign)
            for at, x in enumerate(letters)
        }
        value = expression.subs(point).evalf(50)
        if value.is_number and abs(value) > Rational(1, 10**30):
            return True
    return False


def is_part(printed: Expr, truth: Expr) -> bool:
    """Whether every term of the printed form is a term of the truth, with its coefficient."""
    try:
        some, whole = normal_forms(printed, truth)
    except PolynomialError:
        return False
    return all(whole.get(monomial) == coefficient for monomial, coefficient in some.terms())


def readable(expression: Expr) -> Expr:
    """The expression with products of cosines and sines gathered into cosines of sums."""
    if expression.has(Abs):
        return simplify(expression)
    gathered = TR8(expand(expression))
    return factor_terms(expand(gathered)) if isinstance(gathered, Expr) else expression
