"""Printer of SymPy expressions in a dialect, with the cheap factors of a product first.

Scalars multiply before arrays and arrays along one axis before whole matrices, so that a
product touches as few numbers as it can.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce

from sympy import (
    Abs,
    Add,
    And,
    Expr,
    Float,
    Heaviside,
    Max,
    Min,
    Mul,
    NumberSymbol,
    Or,
    Piecewise,
    Pow,
    Rational,
    Symbol,
    asin,
    asinh,
    atan,
    cos,
    cosh,
    exp,
    log,
    sign,
    sin,
    sinh,
    tan,
    tanh,
)
from sympy.core.relational import Relational
from sympy.logic.boolalg import ITE, BooleanTrue

from rodgen.emit.laws import LawFunction
from rodgen.scene import grammar

SUM, PRODUCT, POWER, ATOM = range(4)


@dataclass(frozen=True)
class Dialect:
    """Syntax of functions, among them the least and the greatest, choices, powers and rationals,
    and of the laws of scenes."""

    functions: dict[type, str]
    root: str
    choice: str
    power: Callable[[str, str, int], tuple[str, int]]
    fraction: str
    language: grammar.Language = grammar.NUMPY


def _numpy_power(base: str, exponent: str, strength: int) -> tuple[str, int]:
    return f"{base if strength == ATOM else f'({base})'}**{exponent}", POWER


# Names of functions in SymPy and in C.
ELEMENTARY = (sin, cos, tan, exp, log, sinh, cosh, tanh, asinh, atan, asin, sign)
NAMES: dict[type, str] = {function: function.__name__ for function in ELEMENTARY}
NUMPY = Dialect(
    functions={function: f"np.{name}" for function, name in NAMES.items()}
    | {asinh: "np.arcsinh", atan: "np.arctan", asin: "np.arcsin"}
    | {Abs: "np.abs", Min: "np.minimum", Max: "np.maximum"},
    root="np.sqrt",
    choice="np.where({condition}, {value}, {other})",
    power=_numpy_power,
    fraction="{p}/{q}",
)


class Printer:
    """Printer of expressions; ``name`` says how a symbol is written, ``rank`` how large it is (0
    for a number, 1 for an array along one axis, 2 for a matrix), ``start`` where in p the
    parameters of a rod begin, ``clock`` how the time is written."""

    def __init__(
        self,
        dialect: Dialect,
        name: Callable[[Symbol], str],
        rank: Callable[[Symbol], int],
        start: str = "",
        clock: str = "t",
    ):
        self._dialect, self._name, self._rank, self._start = dialect, name, rank, start
        self._clock = clock

    def __call__(self, expression: Expr) -> str:
        return self._print(expression)[0]

    def rank(self, expression: Expr) -> int:
        """Number of axes of the value of an expression."""
        return max((self._rank(symbol) for symbol in expression.free_symbols), default=0)

    def _parenthesise(self, expression: Expr, least: int) -> str:
        text, strength = self._print(expression)
        return text if strength >= least else f"({text})"

    def _print(self, e: Expr) -> tuple[str, int]:
        match e:
            case Symbol():
                return self._name(e), ATOM
            case Rational():
                text = str(e.p) if e.q == 1 else self._dialect.fraction.format(p=e.p, q=e.q)
                return text, ATOM if e.q == 1 and e.p >= 0 else PRODUCT if e.p >= 0 else SUM
            case Add():
                content, rest = e.primitive()
                if content.q != 1 and self._has_unit_coefficients(rest):  # (a + b)/2, not a/2 + b/2
                    return self._mul(Mul(content, rest, evaluate=False))
                return self._add(e), SUM
            case Mul():
                return self._mul(e)
            case Pow():
                return self._pow(e)
            case Piecewise():
                return self._piecewise(e), ATOM
            case Relational():
                return f"{self(e.lhs)} {e.rel_op} {self(e.rhs)}", SUM
            case Heaviside():  # the slope of the least and the greatest, whichever at a kink
                positive = f"{self._parenthesise(e.args[0], SUM)} > 0"
                return self._dialect.choice.format(condition=positive, value=1, other=0), ATOM
            case Max() | Min():
                extreme = self._dialect.functions[type(e)]
                return reduce(lambda a, b: f"{extreme}({a}, {b})", map(self, e.args)), ATOM
            case ITE():
                condition, value, other = (self(part) for part in e.args)
                choice = self._dialect.choice
                return choice.format(condition=condition, value=value, other=other), ATOM
            case And() | Or():
                joint = " & " if isinstance(e, And) else " | "
                return joint.join(map(self._condition, e.args)), SUM
            case NumberSymbol() | Float():
                return repr(float(e)), ATOM
            case LawFunction():
                signals = list(map(self, e.args))
                return e.text(self._dialect.language, self._start, self._clock, signals), ATOM
        if type(e) in self._dialect.functions:
            return f"{self._dialect.functions[type(e)]}({self(e.args[0])})", ATOM
        raise TypeError(f"no text for {type(e).__name__}: {e}")

    def _condition(self, e: Expr) -> str:
        """Text of one of several conditions; one that was computed before is a number."""
        return f"({self(e)} != 0)" if isinstance(e, Symbol) else f"({self(e)})"

    def _add(self, e: Add) -> str:
        terms = sorted(e.args, key=lambda a: (self._is_negative(a), a.sort_key()))
        text = self._parenthesise(terms[0], SUM)
        for term in terms[1:]:
            if self._is_negative(term):
                text += f" - {self._parenthesise(-term, PRODUCT)}"
            else:
                text += f" + {self._parenthesise(term, PRODUCT)}"
        return text

    def _has_unit_coefficients(self, e: Expr) -> bool:
        return all(abs(term.as_coeff_Mul()[0]) == 1 for term in e.args)

    def _is_negative(self, e: Expr) -> bool:
        return bool(e.as_coeff_Mul()[0] < 0)

    def _mul(self, e: Mul) -> tuple[str, int]:
        number, _ = e.as_coeff_Mul()
        if number < 0:
            return f"-{self._parenthesise(-e, PRODUCT)}", SUM
        parts: list[tuple[int, bool, Expr]] = [
            (self.rank(f), self._is_inverse(f), f) for f in e.args if not f.is_Rational
        ]
        if number.q != 1:
            parts.append((0, True, Rational(number.q)))
        if number.p != 1:
            parts.append((0, False, Rational(number.p)))
        parts.sort(key=lambda part: (part[0], part[1], not part[2].is_Rational, part[2].sort_key()))
        if parts[0][1]:
            parts.insert(0, (0, False, Rational(1)))
        if parts[0][2].is_Rational and parts[1][2].is_Rational and parts[1][1]:
            _, _, top = parts.pop(0)
            bottom = parts.pop(0)[2]
            text = self._dialect.fraction.format(p=top, q=bottom)
        else:
            text = self._parenthesise(parts.pop(0)[2], PRODUCT)
        for _, inverse, factor in parts:
            if inverse:
                shown = factor if factor.is_Rational else 1 / factor
                text += f"/{self._parenthesise(shown, POWER)}"
            else:
                text += f"*{self._parenthesise(factor, POWER)}"
        return text, PRODUCT

    def _is_inverse(self, e: Expr) -> bool:
        return bool(e.is_Pow and e.exp.is_Rational and e.exp < 0)

    def _pow(self, e: Pow) -> tuple[str, int]:
        if e.exp == Rational(1, 2):
            return f"{self._dialect.root}({self(e.base)})", ATOM
        if e.exp.is_Rational and e.exp < 0:
            return f"1/{self._parenthesise(1 / e, POWER)}", PRODUCT
        base, strength = self._print(e.base)
        return self._dialect.power(base, self._parenthesise(e.exp, ATOM), strength)

    def _piecewise(self, e: Piecewise) -> str:
        text = None
        for value, condition in reversed(e.args):
            if text is None and isinstance(condition, BooleanTrue):
                text = self(value)
            else:
                text = self._dialect.choice.format(
                    condition=self(condition), value=self(value), other=text
                )
        assert text is not None
        return text
