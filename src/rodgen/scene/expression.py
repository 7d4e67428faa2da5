"""Expressions in t or s: checked text, its values, its code, and where it is not smooth."""

from __future__ import annotations

import ast
import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from rodgen.errors import InputError, short
from rodgen.scene import grammar
from rodgen.scene.singularities import breaks, poles, swing
from rodgen.scene.zeros import Pulse, onsets, sampled

# What a law switches by: of its variable and of what it follows, by name.
Difference = Callable[[Any, Mapping[str, Any]], Any]
# Numbers and tables by name; None where only a module knows the value.
Numbers = tuple[tuple[str, float | grammar.TableData | None], ...]


@dataclass(frozen=True)
class Apart:
    """What two parts of an expression are apart, or what one is, as a function of the variable:
    equal where the values of the numbers in both are."""

    a: ast.expr
    b: ast.expr | None
    variable: str
    numbers: Numbers

    def __call__(self, at: Any) -> Any:
        with np.errstate(all="ignore"):
            names = {**dict(self.numbers), self.variable: np.asarray(at, dtype=float)}
            found = grammar.value_of(self.a, names)
            return found if self.b is None else found - grammar.value_of(self.b, names)


@dataclass(frozen=True)
class Expression:
    """A checked expression in one variable and in numbers that have names.

    field: where it stands, for error messages; numbers: those that it may name, and tables, whose
    names stand in quotes; states: names of states that it may follow, with sensors; None: neither.
    """

    text: str
    variable: str
    field: str = "expression"
    numbers: Numbers = ()
    states: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        known = {name: self._values[name] for name in self.tables if name in self._values}
        tables = [name for name, of in known.items() if not isinstance(of, float | int)]
        names, states = self._values.keys() - tables, self.states
        grammar.check(
            self._tree, self.variable, names, self._refused, states=states, known_tables=tables
        )
        self._check_constants()

    def _check_constants(self) -> None:
        """Raise InputError where a part that is constant is not finite."""
        with np.errstate(all="ignore"):
            for part in _constants(self._tree, frozenset(self._known)):
                if not np.isfinite(grammar.value_of(part, self._values)):
                    raise self._refused(part)

    @cached_property
    def _tree(self) -> ast.expr:
        tree = grammar.parse(self.text, self.field)
        if tree is None:
            said = grammar.mistake(self.text)
            raise self._refused(None, f"an expression that can be read ({said})" if said else "")
        return tree

    @cached_property
    def _values(self) -> dict[str, float | grammar.TableData | None]:
        return dict(self.numbers)

    @cached_property
    def _mentioned(self) -> list[str]:
        """All that is named in it, in the order of the text."""
        return grammar.names_in(self._tree)

    @property
    def _known(self) -> set[str]:
        """Names of numbers that have a value."""
        return {name for name, value in self.numbers if value is not None}

    def _refused(self, node: ast.AST | None, allowed: str = "") -> InputError:
        """The error for a part in whose place something else is allowed, or the grammar."""
        part = self.text if node is None else ast.unparse(node)
        named = (name for name in self._values if name.isidentifier())
        names = (self.variable, *named, *(self.states or ()))
        sensed = grammar.SENSED if self.states is not None else ""
        hint = "" if allowed else grammar.advice(node, names)
        allowed = allowed or grammar.ALLOWED.format(names=", ".join(names)) + sensed
        where = "" if part == self.text else f" (not {short(part)})"
        return InputError(self.field, self.text, allowed + where + hint)

    @cached_property
    def canonical(self) -> str:
        """The expression as text that is equal for equal trees, however they were spaced."""
        return ast.unparse(self._tree)

    @property
    def constant(self) -> bool:
        """Whether it names numbers alone."""
        return not (self.changes or self.signals)

    @property
    def changes(self) -> bool:
        """Whether the variable is in it."""
        return self.variable in self._mentioned

    def held(self, at: float) -> str:
        """The text with a number in place of the variable."""
        tree = grammar.with_values(self._tree, {self.variable: at})
        return ast.unparse(tree)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers in it, in the order of the text."""
        others = {self.variable, *self.signals, *self.tables}
        return tuple(n for n in self._mentioned if n not in others)

    @cached_property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables in it whose numbers do not stand in the text."""
        return grammar.table_names(self._tree)

    @cached_property
    def signals(self) -> tuple[str, ...]:
        """The states and sensors that it follows, in the order of the text."""
        return tuple(grammar.signals_in(self._tree, self.states or ()))

    @cached_property
    def sensors(self) -> tuple[grammar.Sensor, ...]:
        """Sensors among these."""
        return tuple(grammar.sensors_in(self._tree))

    def slope_source(
        self,
        by: str,
        language: grammar.Language,
        places: Mapping[str, slice],
        start: str,
        signals: Mapping[str, str],
    ) -> str:
        """Code of the derivative by one of its signals."""
        tree = grammar.derivative(self._tree, by)
        return "0.0" if tree is None else grammar.source_of(tree, language, places, start, signals)

    def value(
        self, at: Any, signals: Mapping[str, Any], functions: grammar.Functions | None = None
    ) -> Any:
        """Its value where the signals have values, too; functions: those of other numbers."""
        with np.errstate(all="ignore"):
            names = self._values | {self.variable: at} | dict(signals)
            return grammar.value_of(self._tree, names, functions)

    def slope(self, at: Any, signals: Mapping[str, Any]) -> Any:
        """The derivative of that by the variable."""
        tree = grammar.derivative(self._tree, self.variable)
        with np.errstate(all="ignore"):
            names = self._values | {self.variable: at} | dict(signals)
            return 0.0 if tree is None else grammar.value_of(tree, names)

    def parametrised(self, prefix: str) -> tuple[str, dict[str, Any]]:
        """Canonical text in which every number has a name, and the values by name; of tables whose
        numbers are not in the text, TableData.

        Names are ``prefix_1``, ``prefix_2``, ..., in tables ``prefix_knot_1``, ``prefix_value_1``,
        ..., of a whole table ``prefix_table_1``, ..., in the order of the text, and those that the
        numbers have already; whole exponents stay as they are.
        """
        if prefix not in self._parametrised:
            self._parametrised[prefix] = self._with_names(prefix)
        return self._parametrised[prefix]

    @cached_property
    def _parametrised(self) -> dict[str, tuple[str, dict[str, Any]]]:
        """The text and the values by prefix, as a scene and its module ask for both."""
        return {}

    def _with_names(self, prefix: str) -> tuple[str, dict[str, Any]]:
        counts: Counter[str] = Counter()
        values: dict[str, Any] = {}

        def named(value: float | str, what: str) -> ast.expr:
            counts[what] += 1
            name = f"{prefix}_{what}{counts[what]}"
            values[name] = self._values[value] if isinstance(value, str) else value
            return ast.Name(name)

        tree = grammar.with_names(self._tree, named)
        own = {name: value for name, value in self.numbers if value is not None}
        return ast.unparse(tree), values | {name: own[name] for name in self.names if name in own}

    @property
    def knot_names(self) -> list[list[str]]:
        """Names of the knots of every table, which are to ascend."""
        found = ([k.id for k in table.knots if isinstance(k, ast.Name)] for table in self._tables)
        return [names for names in found if names]

    @property
    def cubic(self) -> bool:
        """Whether a table in it goes as a cubic between its knots."""
        return any(table.kind == grammar.CUBIC for table in self._tables)

    @property
    def tabulated(self) -> bool:
        """Whether there is a table in it."""
        return bool(self._tables)

    @cached_property
    def _tables(self) -> list[grammar.Table]:
        return list(grammar.tables(self._tree))

    def takes(self, values: Mapping[str, float]) -> bool:
        """Whether the parts of it that are constant stay finite with other values of some of its
        numbers, as they are to be."""
        names = self._values | {name: np.float64(value) for name, value in values.items()}
        with np.errstate(all="ignore"):
            parts = _constants(self._tree, frozenset(self._known))
            return all(bool(np.isfinite(grammar.value_of(part, names))) for part in parts)

    def with_values(self, values: Mapping[str, Any]) -> Expression:
        """The expression with values of its numbers and tables; those of other names are left
        out."""
        known: Numbers = (
            *((name, float(values[name])) for name in self.names),
            *((name, grammar.TableData.of(values[name])) for name in self.tables),
        )
        # What follows from the text alone is checked and known.
        made = object.__new__(Expression)
        made.__dict__.update(self.__dict__, numbers=known, _values=dict(known), _parametrised={})
        made._check_constants()
        return made

    def __call__(self, at: Any) -> Any:
        """Value at a number or an array; not-a-number and infinity where the maths has them."""
        return self._at(self._tree, at)

    def _at(self, part: ast.expr, at: Any) -> Any:
        with np.errstate(all="ignore"):
            x = np.asarray(at, dtype=float)
            return grammar.value_of(part, self._values | {self.variable: x})

    def source(
        self,
        language: grammar.Language = grammar.NUMPY,
        places: Mapping[str, slice] | None = None,
        start: str = "",
        signals: Mapping[str, str] | None = None,
    ) -> str:
        """The expression as code in the variable; canonical, so equal for equal trees.

        places: in p, from ``start`` on, of the numbers and tables that have names; signals: code of
        its states and sensors.
        """
        return grammar.source_of(self._tree, language, places or {}, start, signals)

    def affine(self) -> tuple[Expression, float, float]:
        """What of it changes, its core, and a and b of a times that plus b, which it is; itself
        where that is not so, as where a is zero."""
        node, steps = grammar.core(self._tree, frozenset((self.variable, *self.signals)))
        with np.errstate(all="ignore"):
            a, b = grammar.scale_and_offset(steps, self._values)
        if not (steps and a and math.isfinite(a) and math.isfinite(b)):
            return self, 1.0, 0.0
        return _open_core(node, self.variable, self.states).with_values(self._values), a, b

    def pulses(self, start: float, end: float) -> tuple[Pulse, ...]:
        """What it does after rests, see zeros.onsets: a matter of its core alone."""
        return onsets(self.affine()[0], start, end)

    def kinks(self) -> list[Callable[[Any], Any]]:
        """Functions of the variable alone in whose zeros the expression is not smooth; knots of a
        table of the variable itself are not among them."""
        return [self._difference(a, b) for a, b in self._kinks if not self._follows(a, b)]

    def switches(self) -> dict[str, Difference]:
        """Functions of the variable and the signals in whose zeros the expression is not smooth as
        it follows these, by their text."""
        return self._differences(self._follows)

    def jumps(self) -> frozenset[str]:
        """Which of the switches are of conditions, by their text: the expression may jump there."""
        return frozenset(_compared(*pair) for pair in grammar.conditions(self._tree))

    def corners(self) -> dict[str, Difference]:
        """All functions of the variable and of names without a value in whose zeros the expression
        is not smooth, by their text."""
        return self._differences(lambda *_: True)

    def _differences(self, taken: Callable[..., bool]) -> dict[str, Difference]:
        return {_compared(a, b): partial(self._apart, a, b) for a, b in self._kinks if taken(a, b)}

    @property
    def _kinks(self) -> list[grammar.Pair]:
        """Pairs whose difference is zero where it is not smooth: of a table, its argument and each
        of the knots at which steps end."""
        return [
            pair
            for a, b in grammar.kinks(self._tree, self.variable)
            for pair in (self._corners(a, b) if b and grammar.is_table(b) else [(a, b)])
        ]

    def _corners(self, argument: ast.expr, call: ast.Call) -> list[grammar.Pair]:
        table = grammar.table_of(call)
        if not table.name:
            return [(argument, knot) for knot in table.knots]
        data = self._values[table.name]
        if data is None:  # which a module alone knows
            return [(argument, call)]
        assert isinstance(data, grammar.TableData)
        return list(_at_corners(argument, data))

    def _apart(self, a: ast.expr, b: ast.expr | None, at: Any, signals: Mapping[str, Any]) -> Any:
        with np.errstate(all="ignore"):
            names = self._values | {self.variable: at} | dict(signals)
            less = grammar.value_of(b, names) if b else 0.0
            return grammar.value_of(a, names) - less

    def _follows(self, *parts: ast.expr | None) -> bool:
        """Whether any of some parts follows a state or a sensor."""
        return any(part and grammar.signals_in(part, self.states or ()) for part in parts)

    def knots(self) -> list[float]:
        """Knots of the tables of the variable itself that tell what these are like, ascending."""
        tables = grammar.tables_of(self._tree, self.variable)
        found = (grammar.data_of(one, self._values).corners for one in tables)
        return sorted({float(knot) for knots in found for knot in knots})

    def _difference(self, a: ast.expr, b: ast.expr | None) -> Apart:
        named = dict.fromkeys((*grammar.names_in(a), *(grammar.names_in(b) if b else ())))
        numbers = ((name, self._values[name]) for name in named if name in self._values)
        return Apart(a, b, self.variable, tuple(numbers))

    def breaks(self, start: float, end: float) -> list[float]:
        """Zeros of the kinks (see zeros.py) and knots strictly between start and end, ascending."""
        return list(breaks(self, start, end))

    def poles(self, start: float, end: float) -> list[float]:
        """Places from start to end towards which it grows beyond all bounds, ascending.

        They are looked for where it divides by zero, in the way of the break points.
        """
        return list(poles(self, start, end))

    def swing(self, start: float, end: float) -> float:
        """Half a period of what it does between start and end, of the fastest that is common there;
        infinity where it does not swing, or changes too often to be followed."""
        half, enough = swing(self, start, end)
        return half if enough else math.inf

    def followed(self, start: float, end: float) -> bool:
        """Whether its break points and swings are found, or it changes too often for that."""
        return self.kinks_are_found(start, end) and swing(self, start, end)[1]

    def kinks_are_found(self, start: float, end: float) -> bool:
        """Whether what it compares changes its sign no more often than can be looked at."""
        return all(sampled(kink, start, end)[2] for kink in self.kinks())

    def divisors(self) -> list[Callable[[Any], Any]]:
        """Functions of the variable by which it divides."""
        return [self._difference(node, None) for node in grammar.divisors(self._tree)]

    def denominators(self) -> list[Difference]:
        """Functions of the variable and of names without a value by which it divides, numbers not
        among them."""
        parts = grammar.divisors(self._tree)
        open_to = {self.variable, *(self.states or ())}
        kept = (part for part in parts if open_to.intersection(grammar.names_in(part)))
        return [partial(self._apart, part, None) for part in kept]

    def not_finite(self, at: float) -> str:
        """What is said of it at a place where it is no number."""
        return f"{self.field} = {short(self.text)} is not finite at {self.variable} = {at:.9g}"


@lru_cache(maxsize=64)
def _at_corners(argument: ast.expr, table: grammar.TableData) -> tuple[grammar.Pair, ...]:
    """Pair the argument of a table with each of the knots at which steps end."""
    return tuple((argument, ast.Constant(knot)) for knot in table.corners.tolist())


@lru_cache(maxsize=4096)
def _compared(a: ast.expr, b: ast.expr | None) -> str:
    """Text of the difference of two expressions, or of the one alone."""
    return " - ".join(ast.unparse(part) for part in (a, b) if part)


def _constants(node: ast.expr, known: frozenset[str]) -> tuple[ast.AST, ...]:
    return tuple(grammar.constants(node, set(known)))


@lru_cache(maxsize=256)
def _open_core(node: ast.expr, variable: str, states: tuple[str, ...] | None) -> Expression:
    """A part of an expression, whose numbers have no values yet."""
    others = {variable, *grammar.signals_in(node, states or ())}
    numbers = tuple((name, None) for name in grammar.names_in(node) if name not in others)
    made = object.__new__(Expression)  # which was checked, and read, as part of the whole
    known = {"variable": variable, "field": "expression", "numbers": numbers, "states": states}
    vars(made).update(known, text=ast.unparse(node), _tree=node)
    return made


@lru_cache(maxsize=256)
def open_expression(text: str, variable: str, states: tuple[str, ...] = ()) -> Expression:
    """An expression of a module, whose numbers have names and no values; other names are refused
    where the module's structure is checked."""
    tree = grammar.parse(text, "expressions")
    names = grammar.names_in(tree) if tree is not None else []
    others = {variable, *(grammar.signals_in(tree, states) if tree is not None else ())}
    numbers = tuple((name, None) for name in names if name not in others)
    return Expression(text, variable, "expressions", numbers, states)


# A scene is run again and again: what it takes milliseconds to find is kept.
@lru_cache(maxsize=256)
def parsed(
    text: str,
    variable: str,
    field: str,
    numbers: Numbers,
    states: tuple[str, ...] | None = None,
) -> Expression:
    """An expression of a scene."""
    return Expression(text, variable, field, numbers, states)
