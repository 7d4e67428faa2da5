"""Text of an expression in t or s: checked, with its values, its derivatives and its code."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from rodgen.errors import InputError, shorten
from rodgen.scene import grammar

# Numbers and tables by name; None where only a module knows the value.
Numbers = tuple[tuple[str, float | grammar.TableData | None], ...]


@dataclass(frozen=True)
class ExpressionText:
    """Checked text of an expression in one variable and in numbers that have names.

    variable: "" of one that has none; field: where it stands, for error messages; numbers: those
    that it may name, and tables, whose names stand in quotes; states: names of states that it may
    follow, with sensors; None: neither.
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
        grammar.check_tree(
            self._tree, self.variable, names, self._error, states=states, known_tables=tables
        )
        self._check_constants()

    def _check_constants(self) -> None:
        """Raise InputError where a part that is constant is not finite."""
        with np.errstate(all="ignore"):
            for part in self._constant_parts:
                if not np.isfinite(grammar.evaluate(part, self._values)):
                    raise self._error(part)

    @cached_property
    def _tree(self) -> ast.expr:
        tree = grammar.parse(self.text, self.field)
        if tree is None:
            said = grammar.syntax_error(self.text)
            raise self._error(None, f"an expression that can be read ({said})" if said else "")
        return tree

    @cached_property
    def _values(self) -> dict[str, float | grammar.TableData | None]:
        return dict(self.numbers)

    @cached_property
    def _all_names(self) -> tuple[str, ...]:
        """Names in it, in the order of the text."""
        return grammar.names_in(self._tree)

    @property
    def _known(self) -> set[str]:
        """Names of numbers that have a value."""
        return {name for name, value in self.numbers if value is not None}

    @property
    def _constant_parts(self) -> Iterator[ast.AST]:
        """Largest parts of the expression that have only numbers with a value."""
        return grammar.constant_parts(self._tree, self._known)

    def _error(self, node: ast.AST | None, allowed: str = "") -> InputError:
        """Error for a part of it; allowed: what may stand in its place, by default the grammar."""
        part = self.text if node is None else ast.unparse(node)
        named = (name for name in self._values if name.isidentifier())
        names = (self.variable, *named, *(self.states or ()))
        sensed = grammar.SENSED if self.states is not None else ""
        hint = "" if allowed else grammar.suggest(node, names)
        known = ", ".join(filter(None, ("numbers", *names, "pi")))
        allowed = allowed or grammar.ALLOWED.format(names=known) + sensed
        where = "" if part == self.text else f" (not {shorten(part)})"
        return InputError(self.field, self.text, allowed + where + hint)

    @cached_property
    def canonical(self) -> str:
        """Text that is equal for equal trees, whatever the spacing."""
        return ast.unparse(self._tree)

    @property
    def is_constant(self) -> bool:
        """Whether neither the variable nor a signal is in it."""
        return not (self.has_variable or self.signals)

    @property
    def has_variable(self) -> bool:
        """Whether the variable is in it."""
        return self.variable in self._all_names

    def at_value(self, at: float) -> str:
        """The text with a number in place of the variable."""
        return grammar.replace_names(self._tree, {self.variable: repr(float(at))})

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers in it, in the order of the text."""
        others = {self.variable, *self.signals, *self.tables}
        return tuple(n for n in self._all_names if n not in others)

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
        """The sensors that it reads."""
        return tuple(grammar.sensors_in(self._tree))

    def derivative_source(
        self,
        by: str,
        language: grammar.Language,
        places: Mapping[str, slice],
        start: str,
        signals: Mapping[str, str],
        order: int = 1,
    ) -> str:
        """Code of its derivative by one of its signals, or of one of a higher order."""
        tree = self._derivative_tree(by, order)
        return "0.0" if tree is None else grammar.to_source(tree, language, places, start, signals)

    def _derivative_tree(self, by: str, order: int) -> ast.expr | None:
        """Tree of a derivative; None where it is zero."""
        tree: ast.expr | None = self._tree
        for _ in range(order):
            tree = grammar.derivative(tree, by) if tree else None
        return tree

    def evaluate(
        self, at: Any, signals: Mapping[str, Any], functions: grammar.Functions | None = None
    ) -> Any:
        """Evaluate it, given values of its signals; functions: for other numbers than doubles."""
        with np.errstate(all="ignore"):
            names = self._values | {self.variable: at} | dict(signals)
            return grammar.evaluate(self._tree, names, functions)

    def derivative(
        self, at: Any, signals: Mapping[str, Any], order: int = 1, by: str | None = None
    ) -> Any:
        """Derivative by the variable, or one of a higher order, given values of its signals; by: a
        number in it that has a name, in place of the variable."""
        tree = self._derivative_tree(self.variable if by is None else by, order)
        with np.errstate(all="ignore"):
            names = self._values | {self.variable: at} | dict(signals)
            return 0.0 if tree is None else grammar.evaluate(tree, names)

    def with_parameters(self, prefix: str) -> tuple[str, dict[str, Any]]:
        """Canonical text with a name in place of every number, and the values by name; for tables
        whose numbers are not in the text, TableData.

        Names are ``prefix_1``, ``prefix_2``, ..., in tables ``prefix_knot_1``, ``prefix_value_1``,
        ..., of a whole table ``prefix_table_1``, ..., in the order of the text, and those that the
        numbers have already; whole exponents stay as they are.
        """
        if prefix not in self._parameter_cache:
            self._parameter_cache[prefix] = self._with_names(prefix)
        return self._parameter_cache[prefix]

    @cached_property
    def _parameter_cache(self) -> dict[str, tuple[str, dict[str, Any]]]:
        """Cache of `with_parameters`, by prefix."""
        return {}

    def _with_names(self, prefix: str) -> tuple[str, dict[str, Any]]:
        counts: Counter[str] = Counter()
        values: dict[str, Any] = {}

        def make_name(value: float | str, what: str) -> ast.expr:
            counts[what] += 1
            name = f"{prefix}_{what}{counts[what]}"
            values[name] = self._values[value] if isinstance(value, str) else value
            return ast.Name(name)

        tree = grammar.replace_numbers(self._tree, make_name)
        own = {name: self._values[name] for name in self.names if name in self._known}
        return ast.unparse(tree), values | own

    @property
    def knot_names(self) -> list[list[str]]:
        """Names of the knots of every table, which are to ascend."""
        found = ([k.id for k in table.knots if isinstance(k, ast.Name)] for table in self._tables)
        return [names for names in found if names]

    @property
    def has_cubic(self) -> bool:
        """Whether a table in it is interpolated by a cubic."""
        return any(table.kind == grammar.CUBIC for table in self._tables)

    @property
    def has_linear_table(self) -> bool:
        """Whether a table in it is interpolated by straight lines."""
        return any(table.kind == grammar.LINEAR for table in self._tables)

    @property
    def has_table(self) -> bool:
        """Whether there is a table in it."""
        return bool(self._tables)

    @cached_property
    def _tables(self) -> list[grammar.InterpolationTable]:
        return list(grammar.find_tables(self._tree))

    def accepts(self, values: Mapping[str, float]) -> bool:
        """Whether its constant parts stay finite, as they must, with other values of numbers."""
        names = self._values | {name: np.float64(value) for name, value in values.items()}
        with np.errstate(all="ignore"):
            found = (grammar.evaluate(part, names) for part in self._constant_parts)
            return all(map(np.isfinite, found))

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Copy with values of its numbers and tables; those of other names are ignored."""
        known: Numbers = (
            *((name, float(values[name])) for name in self.names),
            *((name, grammar.TableData.of(values[name])) for name in self.tables),
        )
        # What follows from the text alone is checked and known.
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__, numbers=known, _values=dict(known), _parameter_cache={})
        made._check_constants()
        return made

    def __call__(self, at: Any) -> Any:
        """Value at a number or an array; not-a-number and infinity where the maths has them."""
        return self.evaluate(np.asarray(at, dtype=float), {})

    def source(
        self,
        language: grammar.Language = grammar.NUMPY,
        places: Mapping[str, slice] | None = None,
        start: str = "",
        signals: Mapping[str, str] | None = None,
    ) -> str:
        """Code of the expression in the variable; equal for equal trees.

        places: in p, from ``start`` on, of the numbers and tables that have names; signals: code of
        its states and sensors.
        """
        return grammar.to_source(self._tree, language, places or {}, start, signals)

    def not_finite_message(self, at: float) -> str:
        """Message that it is not finite at this value of the variable."""
        return f"{self.field} = {shorten(self.text)} is not finite at {self.variable} = {at:.9g}"
