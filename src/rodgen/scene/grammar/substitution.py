"""Trees made of trees: numbers replaced by names and names by numbers, and splitting into
a*core + b, of which the core alone changes.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from rodgen.scene.grammar.code_generation import evaluate, is_whole_number
from rodgen.scene.grammar.syntax_tree import (
    constant_value,
    is_table,
    meaning_of,
    names_in,
    sensor_of,
    table_in_call,
)
from rodgen.scene.grammar.vocabulary import TABLE

FEW = 5  # knots of a table that is shown whole
# Prefixes of the names of numbers and tables of an expression.
NUMBER, KNOT, VALUE, WHOLE = "", "knot_", "value_", "table_"
Namer = Callable[[float | str, str], ast.expr]

# An affine step: its operator, and the tree of its number, None for a sign.
Step = tuple[type[ast.operator] | type[ast.unaryop], ast.expr | None]


def replace_numbers(node: ast.expr, name: Namer) -> ast.expr:
    """Replace every number of a tree by what ``name`` returns for it, in the order of the text;
    whole exponents, which say what kind of function it is, stay.

    name: of a value, and of what it is: NUMBER, KNOT or VALUE of a table, or, of the name of a
    table whose numbers are not in the text, WHOLE.
    """
    match node:
        case ast.Constant(value=int() | float() as value):
            return name(float(value), NUMBER)
        case ast.BinOp(left=left, op=ast.Pow() as op, right=right) if is_whole_number(right):
            return ast.BinOp(replace_numbers(left, name), op, right)
        case ast.BinOp(left=left, op=op, right=right):
            return ast.BinOp(replace_numbers(left, name), op, replace_numbers(right, name))
        case ast.UnaryOp(op=op, operand=operand):
            return ast.UnaryOp(op, replace_numbers(operand, name))
        case ast.Compare(left=left, ops=ops, comparators=[right]):
            return ast.Compare(replace_numbers(left, name), ops, [replace_numbers(right, name)])
        case ast.IfExp(test=test, body=body, orelse=orelse):
            # The text has the value before the condition.
            first = replace_numbers(body, name)
            return ast.IfExp(replace_numbers(test, name), first, replace_numbers(orelse, name))
        case ast.Call(func=func, args=args) if is_table(node):
            table = table_in_call(node)
            argument = replace_numbers(table.argument, name)
            if table.name:
                return ast.Call(func, [argument, name(table.name, WHOLE), *args[2:]], [])
            knots = ast.List([_name_number(e, name, KNOT) for e in table.knots], ast.Load())
            values = ast.List([_name_number(e, name, VALUE) for e in table.values], ast.Load())
            return ast.Call(func, [argument, knots, values, *args[3:]], [])
        case ast.Call(func=func) if sensor := sensor_of(node):
            # Where a sensor is belongs to the code, by one way to write it.
            return ast.Call(func, [ast.Constant(sensor.at)], [])
        case ast.Call(func=func, args=args):
            return ast.Call(func, [replace_numbers(arg, name) for arg in args], [])
    return node


def abbreviate(text: str) -> str:
    """Shorten the long tables in a text, for readers, to their number of knots and their kind."""
    if TABLE not in text:
        return text

    class Brief(ast.NodeTransformer):
        def visit_Call(self, node: ast.Call) -> ast.expr:
            self.generic_visit(node)
            if is_table(node) and len(table_in_call(node).knots) > FEW:
                argument, knots, _, *kind = node.args
                assert isinstance(knots, ast.List)
                node.args = [argument, ast.Name(f"{len(knots.elts)} knots"), *kind]
            return node

    return ast.unparse(Brief().visit(ast.parse(text.strip(), mode="eval")))


def _name_number(element: ast.expr, name: Namer, what: str) -> ast.expr:
    """Replace a number of a table, with its sign, by its name."""
    value = constant_value(element)
    return element if value is None else name(value, what)


def replace_names(node: ast.expr, texts: Mapping[str, str]) -> str:
    """Text of a tree with other texts in place of some names."""

    class Renamed(ast.NodeTransformer):
        def visit_Name(self, name: ast.Name) -> ast.expr:
            return ast.parse(texts.get(name.id, name.id), mode="eval").body

        def visit_Call(self, call: ast.Call) -> ast.expr:
            call.args = [self.visit(argument) for argument in call.args]  # not what is called
            return call

    return ast.unparse(Renamed().visit(copy.deepcopy(node)))


@lru_cache(maxsize=256)
def affine_core(node: ast.expr, changing: frozenset[str]) -> tuple[ast.expr, tuple[Step, ...]]:
    """Innermost part of a tree with all that changes with some names, and the steps to it."""

    def is_constant(part: ast.expr) -> bool:
        return changing.isdisjoint(names_in(part))

    steps: list[Step] = []
    while True:
        match meaning_of(node) or node:
            case ast.UnaryOp(op=op, operand=inner):
                steps.append((type(op), None))
            case ast.BinOp(
                left=inner, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() as op, right=by
            ) if is_constant(by):
                steps.append((type(op), by))
            case ast.BinOp(left=by, op=ast.Add() | ast.Mult() as op, right=inner) if is_constant(
                by
            ):
                steps.append((type(op), by))
            case ast.BinOp(left=by, op=ast.Sub(), right=inner) if is_constant(by):
                steps += ((ast.Add, by), (ast.USub, None))
            case _:
                return node, tuple(steps)
        node = inner


def scale_and_offset(steps: tuple[Step, ...], names: Mapping[str, Any]) -> tuple[float, float]:
    """Coefficients a and b of the whole, a*core + b, by the values of its names."""
    a, b = 1.0, 0.0
    for kind, part in steps:
        value = float(evaluate(part, names)) if part is not None else 1.0
        if kind is ast.USub:
            a = -a
        elif kind is ast.Mult:
            a *= value
        elif kind is ast.Div:
            a = a / value if value else float("inf")
        elif kind is ast.Add:
            b += a * value
        elif kind is ast.Sub:
            b -= a * value
    return a, b
