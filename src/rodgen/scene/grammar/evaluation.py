"""Evaluation of trees."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator, Mapping
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
from rodgen.scene.grammar.vocabulary import BINARY, COMPARE, FUNCTIONS, TABLE, UNARY

Functions = Mapping[str, Callable[..., Any]]


def evaluate(node: ast.AST, names: Mapping[str, Any], functions: Functions | None = None) -> Any:
    """Evaluate a tree, given values of its names and, by their texts, of its sensors. functions:
    those of other numbers than doubles."""
    values = [evaluate(child, names, functions) for child, _ in children(node)]
    if (sensor := sensor_of(node)) is not None:
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
            made: Callable[..., Any] = (functions or {}).get(TABLE, _interpolate)
            return made(values[0], table_numbers(table, names), table.kind)
        case ast.Call(func=ast.Name(id=name)):
            return (functions or {}).get(name, FUNCTIONS[name][2])(*values)
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


def _interpolate(x: Any, table: TableData, kind: str) -> Any:
    return table.at(x, kind)


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
