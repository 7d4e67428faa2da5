"""The grammar of expressions in t or s: parsed and checked, never evaluated as Python.

    numbers, the variable, pi, + - * / **, comparisons, `a if c else b`,
    sin cos tan exp log sqrt abs min max tanh

The text is parsed to a syntax tree (which runs nothing), every node of it is checked against
the list above, and the tree is walked to compute values, to find break points and to print code.
"""

from __future__ import annotations

import ast
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import accumulate
from typing import Any

import numpy as np

from rodgen.scene.errors import SceneError, short
from rodgen.scene.zeros import sampled, zeros

LONGEST = 1000  # characters
BRACKETS = 50  # in each other
FEWEST_TURNS = 3  # of what swings
COMMON = 0.2  # share of the times between turns that are shorter
TURNS = 1e-6  # of the largest value: changes from one sample to the next that are none
DEEPEST = 200  # nested operations, of which a sum of as many terms is one

# Towards a pole: shares of the time scale, and how much more from each to the next. A power of
# -1/4 grows as much; what min or max bounds, and a logarithm, do not.
NEARER, LARGER = 2.0 ** np.array([-20, -32, -44]), 7.9

FUNCTIONS: dict[str, tuple[int, int | None, Callable[..., Any]]] = {
    "sin": (1, 1, np.sin),
    "cos": (1, 1, np.cos),
    "tan": (1, 1, np.tan),
    "exp": (1, 1, np.exp),
    "log": (1, 1, np.log),
    "sqrt": (1, 1, np.sqrt),
    "abs": (1, 1, np.abs),
    "tanh": (1, 1, np.tanh),
    "min": (2, None, lambda *a: _fold(np.minimum, a)),
    "max": (2, None, lambda *a: _fold(np.maximum, a)),
}
BINARY: dict[type[ast.operator], tuple[str, Callable[..., Any]]] = {
    ast.Add: ("+", np.add),
    ast.Sub: ("-", np.subtract),
    ast.Mult: ("*", np.multiply),
    ast.Div: ("/", np.divide),
    ast.Pow: ("**", np.power),
}
UNARY: dict[type[ast.unaryop], tuple[str, Callable[..., Any]]] = {
    ast.USub: ("-", np.negative),
    ast.UAdd: ("+", np.positive),
}
COMPARE: dict[type[ast.cmpop], tuple[str, Callable[..., Any]]] = {
    ast.Lt: ("<", np.less),
    ast.LtE: ("<=", np.less_equal),
    ast.Gt: (">", np.greater),
    ast.GtE: (">=", np.greater_equal),
}


@dataclass(frozen=True)
class Language:
    """How code is written: prefix of functions, those with another name, a choice by condition,
    value and other value, and a power."""

    prefix: str
    names: dict[str, str]
    choice: str
    power: str


LANGUAGES = {
    "numpy": Language(
        "np.",
        {"min": "np.minimum", "max": "np.maximum"},
        "np.where({0}, {1}, {2})",
        "({0} ** {1})",
    ),
    "c": Language(
        "",
        {"min": "least", "max": "greatest", "abs": "fabs"},
        "({0} ? {1} : {2})",
        "pow({0}, {1})",
    ),
}
ALLOWED = (
    "an expression of numbers, {variable}, pi, + - * / **, < <= > >=, `a if c else b` and "
    + " ".join(FUNCTIONS)
)


def _fold(function: Callable[..., Any], values: tuple[Any, ...]) -> Any:
    total = values[0]
    for value in values[1:]:
        total = function(total, value)
    return total


@dataclass(frozen=True)
class Expression:
    """A checked expression in one variable. field: where it stands, for error messages."""

    text: str
    variable: str
    field: str = "expression"

    def __post_init__(self) -> None:
        _check(self._tree, self)
        for part in _constants(self._tree, self.variable):
            with np.errstate(all="ignore"):
                if not np.isfinite(_value(part, self.variable, None)):
                    raise self.refused(ast.unparse(part))

    @cached_property
    def _tree(self) -> ast.expr:
        if len(self.text) > LONGEST:
            raise SceneError(
                self.field, self.text, f"an expression of at most {LONGEST} characters"
            )
        if max(accumulate((c in "([") - (c in ")]") for c in self.text), default=0) > BRACKETS:
            raise SceneError(self.field, self.text, f"of parentheses at most {BRACKETS} deep")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # Python's opinion of "1if t<1else 2"
                return ast.parse(self.text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise self.refused(self.text) from None

    def refused(self, part: str) -> SceneError:
        """The error for a part that the grammar has no room for."""
        allowed = ALLOWED.format(variable=self.variable)
        where = "" if part == self.text else f" (not {part!r})"
        return SceneError(self.field, self.text, allowed + where)

    @property
    def canonical(self) -> str:
        """The same expression, equal for equal trees however they were spaced."""
        return ast.unparse(self._tree)

    @property
    def constant(self) -> bool:
        """Whether the variable is not in it."""
        return self._tree in _constants(self._tree, self.variable)

    def __call__(self, at: Any) -> Any:
        """Value at a number or an array; not-a-number and infinity where the maths has them."""
        with np.errstate(all="ignore"):
            return _value(self._tree, self.variable, np.asarray(at, dtype=float))

    def source(self, language: str = "numpy") -> str:
        """The expression as code in the variable, for NumPy or C (with ``least`` and ``greatest``
        of two numbers); canonical, so equal for equal trees."""
        return _source(self._tree, LANGUAGES[language], self.variable)

    def kinks(self) -> list[Callable[[Any], Any]]:
        """Functions of the variable in whose zeros the expression is not smooth."""
        return [self._difference(a, b) for a, b in _kinks(self._tree)]

    def _difference(self, a: ast.expr, b: ast.expr | None) -> Callable[[Any], Any]:
        def difference(at: Any) -> Any:
            with np.errstate(all="ignore"):
                x = np.asarray(at, dtype=float)
                left = _value(a, self.variable, x)
                return left if b is None else left - _value(b, self.variable, x)

        return difference

    def breaks(self, start: float, end: float) -> list[float]:
        """Zeros of the kinks strictly between start and end, ascending (see zeros.py)."""
        return list(_breaks(self, start, end))

    def poles(self, start: float, end: float) -> list[float]:
        """Places from start to end towards which it grows beyond all bounds, ascending.

        They are looked for where it divides by zero, in the way of the break points.
        """
        return list(_poles(self, start, end))

    def swing(self, start: float, end: float) -> float:
        """Half a period of what it does between start and end, of the fastest that is common there;
        infinity where it does not swing, or changes too often to be followed."""
        half, enough = _swing(self, start, end)
        return half if enough else math.inf

    def followed(self, start: float, end: float) -> bool:
        """Whether its break points and swings are found, or it changes too often for that."""
        kinks = all(sampled(kink, start, end)[2] for kink in self.kinks())
        return kinks and _swing(self, start, end)[1]

    def divisors(self) -> list[Callable[[Any], Any]]:
        """Functions of the variable by which it divides."""
        return [self._difference(node, None) for node in _divisors(self._tree)]

    def not_finite(self, at: float) -> str:
        """What is said of it at a place where it is no number."""
        return f"{self.field} = {short(self.text)} is not finite at {self.variable} = {at:.9g}"


# The same scene is run again and again: what it takes milliseconds to find is kept.
@lru_cache(maxsize=256)
def _breaks(e: Expression, start: float, end: float) -> tuple[float, ...]:
    found = zeros(e.kinks(), start, end)
    return tuple(x for x in found if start < x < end)


@lru_cache(maxsize=256)
def _poles(e: Expression, start: float, end: float) -> tuple[float, ...]:
    scale = max(abs(start), abs(end))

    def grows(x: float, side: int) -> bool:
        points = x + side * scale * NEARER
        sizes = np.abs(e(points))
        larger = bool((sizes[1:] > LARGER * sizes[:-1]).all()) or np.isinf(sizes[-1])
        return bool(start <= points[0] <= end and larger)

    found = zeros([*e.kinks(), *e.divisors()], start, end)
    return tuple(x for x in found if grows(x, 1) or grows(x, -1))


@lru_cache(maxsize=256)
def _swing(e: Expression, start: float, end: float) -> tuple[float, bool]:
    grid, values, enough = sampled(e, start, end, lambda values: len(_turns(values)))
    turns = grid[_turns(values)]
    if len(turns) < FEWEST_TURNS:
        return math.inf, enough
    return float(np.quantile(np.diff(turns), COMMON) + grid[1] - grid[0]), enough


def _turns(values: Any) -> Any:
    """Where values that rise begin to fall, or the other way; rounding is no such thing."""
    finite = values[np.isfinite(values)]
    change = np.diff(values)
    moves = np.flatnonzero(np.abs(change) > TURNS * np.abs(finite).max(initial=0.0))
    return moves[1:][change[moves[1:]] * change[moves[:-1]] < 0]


def _check(node: ast.AST, expression: Expression, depth: int = 0, condition: bool = False) -> None:
    def refuse() -> SceneError:
        return expression.refused(ast.unparse(node))

    if depth > DEEPEST:
        raise SceneError(expression.field, expression.text, f"nested at most {DEEPEST} deep")
    if condition != isinstance(node, ast.Compare):
        raise refuse()
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            try:
                finite = math.isfinite(value)
            except OverflowError:
                finite = False
            if not finite:
                raise refuse()
        case ast.Name(id=name) if name in (expression.variable, "pi"):
            pass
        case ast.BinOp(op=op) if type(op) in BINARY:
            pass
        case ast.UnaryOp(op=op) if type(op) in UNARY:
            pass
        case ast.Compare(ops=ops) if all(type(op) in COMPARE for op in ops) and len(ops) == 1:
            pass
        case ast.IfExp():
            pass
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            least, most, _ = FUNCTIONS[name]
            if len(args) < least or (most is not None and len(args) > most):
                raise refuse()
        case _:
            raise refuse()
    for child, is_condition in _children(node):
        _check(child, expression, depth + 1, is_condition)


def _children(node: ast.AST) -> Iterator[tuple[ast.expr, bool]]:
    match node:
        case ast.BinOp(left=left, right=right):
            yield from ((left, False), (right, False))
        case ast.UnaryOp(operand=operand):
            yield operand, False
        case ast.Compare(left=left, comparators=[right]):
            yield from ((left, False), (right, False))
        case ast.IfExp(test=test, body=body, orelse=orelse):
            yield from ((test, True), (body, False), (orelse, False))
        case ast.Call(args=args):
            yield from ((arg, False) for arg in args)


def _value(node: ast.AST, variable: str, at: Any) -> Any:
    values = [_value(child, variable, at) for child, _ in _children(node)]
    match node:
        case ast.Constant(value=int() | float() as value):
            return np.float64(value)
        case ast.Name(id=name):
            return np.float64(math.pi) if name == "pi" else at
        case ast.BinOp(op=op):
            return BINARY[type(op)][1](*values)
        case ast.UnaryOp(op=op):
            return UNARY[type(op)][1](*values)
        case ast.Compare(ops=[op]):
            return COMPARE[type(op)][1](*values)
        case ast.IfExp():
            return np.where(*values)
        case ast.Call(func=ast.Name(id=name)):
            return FUNCTIONS[name][2](*values)
    raise AssertionError(f"unchecked node {node!r}")


def _constants(node: ast.AST, variable: str) -> Iterator[ast.AST]:
    """The largest parts of a tree that the variable is not in; comparisons are no numbers."""
    names = {inner.id for inner in ast.walk(node) if isinstance(inner, ast.Name)}
    if variable not in names and not isinstance(node, ast.Compare):
        yield node
        return
    for child, _ in _children(node):
        yield from _constants(child, variable)


def _source(node: ast.AST, language: Language, variable: str) -> str:
    # Numbers are worked out here: Python's own 1.0/0.0 or (-1.0)**0.5 are not those of NumPy.
    if node in _constants(node, variable):
        return repr(float(_value(node, variable, None)))
    parts = [_source(child, language, variable) for child, _ in _children(node)]
    match node:
        case ast.Name(id=name):
            return name
        case ast.BinOp(op=ast.Pow()):
            return language.power.format(*parts)
        case ast.BinOp(op=op):
            return f"({parts[0]} {BINARY[type(op)][0]} {parts[1]})"
        case ast.UnaryOp(op=op):
            return f"({UNARY[type(op)][0]}{parts[0]})"
        case ast.Compare(ops=[op]):
            return f"({parts[0]} {COMPARE[type(op)][0]} {parts[1]})"
        case ast.IfExp():
            return language.choice.format(*parts)
        case ast.Call(func=ast.Name(id=name)):
            function = language.names.get(name, f"{language.prefix}{name}")
            total = parts[0]
            if FUNCTIONS[name][1] == 1:
                return f"{function}({total})"
            for part in parts[1:]:
                total = f"{function}({total}, {part})"
            return total
    raise AssertionError(f"unchecked node {node!r}")


def _kinks(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr | None]]:
    match node:
        case ast.Compare(left=left, comparators=[right]):
            yield left, right
        case ast.Call(func=ast.Name(id="abs"), args=[arg]):
            yield arg, None
        case ast.Call(func=ast.Name(id="min" | "max"), args=args):
            yield from ((a, b) for at, a in enumerate(args) for b in args[at + 1 :])
    for child, _ in _children(node):
        yield from _kinks(child)


def _divisors(node: ast.AST) -> Iterator[ast.expr]:
    """What is divided by; the base of a power stands for its negative exponents."""
    match node:
        case ast.BinOp(op=ast.Div(), right=divisor) | ast.BinOp(op=ast.Pow(), left=divisor):
            yield divisor
        case ast.Call(func=ast.Name(id="tan"), args=args):
            yield ast.Call(ast.Name("cos"), args, [])
    for child, _ in _children(node):
        yield from _divisors(child)
