"""Expressions in t or s: checked text, and where it is not smooth."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from rodgen.scene import grammar
from rodgen.scene.expression_text import ExpressionText, Numbers
from rodgen.scene.zeros import Pulse, breaks, find_pulses, half_period, poles, sample

# A switching function: of the variable of a law, and of its signals by name.
Difference = Callable[[Any, Mapping[str, Any]], Any]


@dataclass(frozen=True)
class PartFunction:
    """Difference of two parts of an expression, or one part alone, as a function of the variable
    and of signals by name. Two are equal where the parts and the values of their numbers are."""

    a: ast.expr
    b: ast.expr | None
    variable: str
    numbers: Numbers

    def __call__(self, at: Any, signals: Mapping[str, Any] | None = None) -> Any:
        with np.errstate(all="ignore"):
            here = {self.variable: np.asarray(at, dtype=float)}
            names = dict(self.numbers) | here | dict(signals or {})
            found = grammar.evaluate(self.a, names)
            return found if self.b is None else found - grammar.evaluate(self.b, names)


@dataclass(frozen=True)
class Expression(ExpressionText):
    """A checked expression, with its kinks, poles and oscillations."""

    def split_affine(self) -> tuple[Expression, float, float]:
        """Split it into a*core + b: core, a, b. Returns itself, 1 and 0 where that cannot be done,
        as where a is zero."""
        node, steps = grammar.affine_core(self._tree, frozenset((self.variable, *self.signals)))
        with np.errstate(all="ignore"):
            a, b = grammar.scale_and_offset(steps, self._values)
        if not (steps and a and math.isfinite(a) and math.isfinite(b)):
            return self, 1.0, 0.0
        return _open_core(node, self.variable, self.states).with_values(self._values), a, b

    def pulses(self, start: float, end: float) -> tuple[Pulse, ...]:
        """Pulses after rests, see zeros.find_pulses; they depend on its core alone."""
        return find_pulses(self.split_affine()[0], start, end)

    def kinks(self) -> list[Callable[[Any], Any]]:
        """Functions of the variable alone in whose zeros the expression is not smooth; knots of a
        table of the variable itself are not among them."""
        return [
            self._part_function(a, b) for a, b in self._kink_pairs if not self._reads_signals(a, b)
        ]

    def switches(self) -> dict[str, Difference]:
        """Functions in whose zeros the expression is not smooth in the motion, by their text."""
        return self._differences(self._reads_signals)

    def jumps(self) -> frozenset[str]:
        """Texts of the switches that are conditions: the expression may jump there."""
        return frozenset(_difference_text(*pair) for pair in grammar.conditions(self._tree))

    def corners(self) -> dict[str, Difference]:
        """All functions of the variable and of names without a value in whose zeros the expression
        is not smooth, by their text."""
        return self._differences(lambda *_: True)

    def _differences(self, taken: Callable[..., bool]) -> dict[str, Difference]:
        return {
            _difference_text(a, b): self._part_function(a, b)
            for a, b in self._kink_pairs
            if taken(a, b)
        }

    @property
    def _kink_pairs(self) -> list[grammar.Pair]:
        """Pairs of parts whose difference is zero where it is not smooth; of a table, its argument
        and each of the knots at which steps end."""
        return [
            pair
            for a, b in grammar.kinks(self._tree, self.variable)
            for pair in (self._table_kinks(a, b) if b and grammar.is_table(b) else [(a, b)])
        ]

    def _table_kinks(self, argument: ast.expr, call: ast.Call) -> list[grammar.Pair]:
        table = grammar.table_in_call(call)
        if not table.name:
            return [(argument, knot) for knot in table.knots]
        data = self._values[table.name]
        if data is None:  # which a module alone knows
            return [(argument, call)]
        assert isinstance(data, grammar.TableData)
        return list(_knot_pairs(argument, data))

    def _reads_signals(self, *parts: ast.expr | None) -> bool:
        """Whether any of some parts follows a state or a sensor."""
        return any(part and grammar.signals_in(part, self.states or ()) for part in parts)

    def knots(self) -> list[float]:
        """Knots at which steps end, of tables of the variable itself, ascending."""
        tables = grammar.tables_in_variable(self._tree, self.variable)
        found = (grammar.table_numbers(one, self._values).corners for one in tables)
        return sorted({float(knot) for knots in found for knot in knots})

    def _part_function(self, a: ast.expr, b: ast.expr | None) -> PartFunction:
        named = dict.fromkeys((*grammar.names_in(a), *(grammar.names_in(b) if b else ())))
        numbers = ((name, self._values[name]) for name in named if name in self._values)
        return PartFunction(a, b, self.variable, tuple(numbers))

    def breaks(self, start: float, end: float) -> list[float]:
        """Zeros of the kinks (see zeros.py) and knots strictly between start and end, ascending."""
        return list(breaks(self, start, end))

    def poles(self, start: float, end: float) -> list[float]:
        """Poles from start to end, ascending.

        They are searched at zeros of kinks and divisors, which are found like break points.
        """
        return list(poles(self, start, end))

    def half_period(self, start: float, end: float) -> float:
        """Half-period of its fastest common oscillation between start and end; infinity where it
        does not oscillate, or too often to be resolved."""
        half, enough = half_period(self, start, end)
        return half if enough else math.inf

    def is_resolvable(self, start: float, end: float) -> bool:
        """Whether samples resolve all its break points and oscillations."""
        return self.has_resolvable_kinks(start, end) and half_period(self, start, end)[1]

    def has_resolvable_kinks(self, start: float, end: float) -> bool:
        """Whether samples resolve all sign changes of its kinks."""
        return all(sample(kink, start, end)[2] for kink in self.kinks())

    def divisors(self) -> list[Callable[[Any], Any]]:
        """Functions of the variable by which it divides."""
        return [self._part_function(node, None) for node in grammar.divisors(self._tree)]

    def open_divisors(self) -> list[Difference]:
        """Functions of the variable and of names without a value by which it divides; constant
        divisors are left out."""
        parts = grammar.divisors(self._tree)
        open_to = {self.variable, *(self.states or ())}
        kept = (part for part in parts if open_to.intersection(grammar.names_in(part)))
        return [self._part_function(part, None) for part in kept]


@lru_cache(maxsize=64)
def _knot_pairs(argument: ast.expr, table: grammar.TableData) -> tuple[grammar.Pair, ...]:
    """Pair the argument of a table with each of the knots at which steps end."""
    return tuple((argument, ast.Constant(knot)) for knot in table.corners.tolist())


@lru_cache(maxsize=4096)
def _difference_text(a: ast.expr, b: ast.expr | None) -> str:
    """Text of the difference of two expressions, or of the one alone."""
    return " - ".join(ast.unparse(part) for part in (a, b) if part)


@lru_cache(maxsize=256)
def _open_core(node: ast.expr, variable: str, states: tuple[str, ...] | None) -> Expression:
    """Expression of a part of a tree, without values of its numbers."""
    others = {variable, *grammar.signals_in(node, states or ())}
    numbers = tuple((name, None) for name in grammar.names_in(node) if name not in others)
    made = object.__new__(Expression)  # which was checked, and read, as part of the whole
    known = {"variable": variable, "field": "expression", "numbers": numbers, "states": states}
    vars(made).update(known, text=ast.unparse(node), _tree=node)
    return made


@lru_cache(maxsize=256)
def open_expression(
    text: str, variable: str, states: tuple[str, ...] = (), field: str = "expressions"
) -> Expression:
    """An expression of a module, whose numbers have names and no values; other names are refused
    where the module's structure is checked. field: what errors call it."""
    tree = grammar.parse(text, field)
    names = grammar.names_in(tree) if tree is not None else ()
    others = {variable, *(grammar.signals_in(tree, states) if tree is not None else ())}
    numbers = tuple((name, None) for name in names if name not in others)
    return Expression(text, variable, field, numbers, states)


# A scene is run again and again: what it takes milliseconds to find is kept.
@lru_cache(maxsize=256)
def parse_expression(
    text: str,
    variable: str,
    field: str,
    numbers: Numbers,
    states: tuple[str, ...] | None = None,
) -> Expression:
    """Parse and check an expression of a scene."""
    return Expression(text, variable, field, numbers, states)
