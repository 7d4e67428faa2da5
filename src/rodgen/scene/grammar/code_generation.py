"""Evaluation of trees, and code generation from them."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from rodgen.scene.grammar.syntax_tree import (
    InterpolationTable,
    children,
    is_number,
    names_in,
    sensor_of,
    table_in_call,
)
from rodgen.scene.grammar.table_data import TableData
from rodgen.scene.grammar.vocabulary import (
    BINARY,
    COMPARE,
    CUBIC,
    FUNCTIONS,
    LINEAR,
    SLOPE,
    TABLE,
    UNARY,
)

Functions = Mapping[str, Callable[..., Any]]


def evaluate(node: ast.AST, names: Mapping[str, Any], functions: Functions | None = None) -> Any:
    """Evaluate a tree, given values of its names and, by their texts, of its sensors. functions:
    those of other numbers than doubles."""
    values = [evaluate(child, names, functions) for child, _ in children(node)]
    if sensor := sensor_of(node):
        return names[sensor.text]
    match node:
        case ast.Constant(value=int() | float() as value):
            return np.float64(value)
        case ast.Name(id=name):
            return np.float64(math.pi) if name == "pi" else names[name]
        case ast.BinOp(op=op):
            return BINARY[type(op)][1](*values)
        case ast.UnaryOp(op=op):
            return UNARY[type(op)][1](*values)
        case ast.Compare(ops=[op]):
            return COMPARE[type(op)][1](*values)
        case ast.IfExp():
            return np.where(*values)
        case ast.Call(func=ast.Name(id=name)) if name == TABLE:
            table = table_in_call(node)
            made: Callable[..., Any] = (functions or {}).get(TABLE, TableData.at)
            return made(table_numbers(table, names), values[0], table.kind)
        case ast.Call(func=ast.Name(id=name)):
            return (functions or {}).get(name, FUNCTIONS[name].value)(*values)
    raise AssertionError(f"unchecked node {node!r}")


def table_numbers(table: InterpolationTable, names: Mapping[str, Any]) -> TableData:
    """Return the numbers of a table, given the values of names."""
    if table.name:
        return TableData.of(names[table.name])
    return _cached_table(*(tuple(float(evaluate(e, names)) for e in part) for part in table[3:]))


@lru_cache(maxsize=64)
def _cached_table(knots: tuple[float, ...], values: tuple[float, ...]) -> TableData:
    """Make the table whose numbers stand in a text, once, as it is asked for again and again."""
    return TableData(knots, values)


def constant_parts(node: ast.AST, known: set[str]) -> Iterator[ast.AST]:
    """Yield the largest parts of a tree that have only known names and are no comparisons."""
    if known.issuperset(names_in(node)) and not isinstance(node, ast.Compare):
        yield node
        return
    for child, _ in children(node):
        yield from constant_parts(child, known)


def is_whole_number(node: ast.expr) -> bool:
    """Whether a tree is a whole number."""
    if names_in(node) or not all(is_number(part) for part in _leaves(node)):
        return False
    return float(evaluate(node, {})).is_integer()


def _leaves(node: ast.expr) -> Iterator[ast.AST]:
    inner = [child for child, _ in children(node)]
    if not inner:
        yield node
    for child in inner:
        yield from _leaves(child)


@dataclass(frozen=True)
class Language:
    """Syntax of a target language: prefix of functions, those with another name, a choice by
    condition, value and other value, a power, a list of numbers, a part of p, and a table of an
    argument, knots, values and how many they are."""

    prefix: str
    names: dict[str, str]
    choice: str
    power: str
    list: str
    part: str
    tables: dict[str, str]


NUMPY = Language(
    "np.",
    {"min": "np.minimum", "max": "np.maximum"},
    "np.where({0}, {1}, {2})",
    "({0} ** {1})",
    "np.array([{0}])",
    "p[{first}:{end}]",
    {
        LINEAR: "np.interp({0}, {1}, {2})",
        CUBIC: "_cubic({0}, {1}, {2})",
        LINEAR + SLOPE: "_linear_slope({0}, {1}, {2})",
        CUBIC + SLOPE: "_cubic({0}, {1}, {2}, True)",
        CUBIC + SLOPE + SLOPE: "_cubic({0}, {1}, {2}, 2)",
    },
)


def to_source(
    node: ast.AST,
    language: Language,
    places: Mapping[str, slice],
    start: str = "",
    signals: Mapping[str, str] | None = None,
) -> str:
    """Code of a tree; places: in p of the numbers and tables with names, from ``start`` on;
    signals: code of the states and sensors."""
    # Numbers are worked out here: Python's own 1.0/0.0 or (-1.0)**0.5 are not those of NumPy.
    if not names_in(node) and not isinstance(node, ast.Compare):
        return repr(float(evaluate(node, {})))
    signals = signals or {}
    parts = [to_source(child, language, places, start, signals) for child, _ in children(node)]
    if sensor := sensor_of(node):
        return signals[sensor.text]
    match node:
        case ast.Name(id=name):
            return signals.get(name) or (
                f"p[{start}{places[name].start}]" if name in places else name
            )
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
        case ast.Call(func=ast.Name(id=name)) if name == TABLE:
            lists, rows = _table_source(table_in_call(node), language, places, start)
            return language.tables[table_in_call(node).kind].format(*parts, *lists, rows)
        case ast.Call(func=ast.Name(id=name)):
            function = language.names.get(name, f"{language.prefix}{name}")
            total = parts[0]
            if FUNCTIONS[name].meaning:
                return total
            if FUNCTIONS[name].most == 1:
                return f"{function}({total})"
            for part in parts[1:]:
                total = f"{function}({total}, {part})"
            return total
    raise AssertionError(f"unchecked node {node!r}")


def _table_source(
    table: InterpolationTable, language: Language, places: Mapping[str, slice], start: str
) -> tuple[list[str], int]:
    """Return the code of the knots and the values of a table, and how many rows it has."""
    if not table.name:
        parts = table.knots, table.values
        return [_list_source(part, language, places, start) for part in parts], len(table.knots)
    first, last = places[table.name].start, places[table.name].stop
    middle = (first + last) // 2
    ends = (first, middle), (middle, last)
    lists = [language.part.format(first=a, end=b, start=start) for a, b in ends]
    return lists, middle - first


def _list_source(
    elements: Sequence[ast.expr], language: Language, places: Mapping[str, slice], start: str
) -> str:
    """Code of the numbers of a table: a part of p where they lie there side by side."""
    missing = slice(-1, -1)
    at = [places.get(e.id, missing).start if isinstance(e, ast.Name) else -1 for e in elements]
    if at[0] >= 0 and at == list(range(at[0], at[0] + len(at))):
        return language.part.format(first=at[0], end=at[-1] + 1, start=start)
    return language.list.format(", ".join(to_source(e, language, places, start) for e in elements))
