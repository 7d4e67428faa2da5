"""Names in place of the numbers of a tree, and numbers in place of its names."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Mapping

from rodgen.scene.grammar.syntax import is_sensor, is_table, number_of, sensor_of, table_of
from rodgen.scene.grammar.values import is_whole
from rodgen.scene.grammar.vocabulary import TABLE

FEW = 5  # knots of a table that is shown whole
# What a number of an expression, or a table, is called after.
NUMBER, KNOT, VALUE, WHOLE = "", "knot_", "value_", "table_"
Namer = Callable[[float | str, str], ast.expr]


def with_names(node: ast.expr, name: Namer) -> ast.expr:
    """A tree in which what ``name`` returns for it stands in place of every number, in the order of
    the text; whole exponents, which say what kind of function it is, stay.

    name: of a value, and of what it is: NUMBER, KNOT or VALUE of a table, or, of the name of a
    table whose numbers are not in the text, WHOLE.
    """
    match node:
        case ast.Constant(value=int() | float() as value):
            return name(float(value), NUMBER)
        case ast.BinOp(left=left, op=ast.Pow() as op, right=right) if is_whole(right):
            return ast.BinOp(with_names(left, name), op, right)
        case ast.BinOp(left=left, op=op, right=right):
            return ast.BinOp(with_names(left, name), op, with_names(right, name))
        case ast.UnaryOp(op=op, operand=operand):
            return ast.UnaryOp(op, with_names(operand, name))
        case ast.Compare(left=left, ops=ops, comparators=[right]):
            return ast.Compare(with_names(left, name), ops, [with_names(right, name)])
        case ast.IfExp(test=test, body=body, orelse=orelse):
            # The text has the value before the condition.
            first = with_names(body, name)
            return ast.IfExp(with_names(test, name), first, with_names(orelse, name))
        case ast.Call(func=func, args=args) if is_table(node):
            table = table_of(node)
            argument = with_names(table.argument, name)
            if table.name:
                return ast.Call(func, [argument, name(table.name, WHOLE), *args[2:]], [])
            knots = ast.List([_named(e, name, KNOT) for e in table.knots], ast.Load())
            values = ast.List([_named(e, name, VALUE) for e in table.values], ast.Load())
            return ast.Call(func, [argument, knots, values, *args[3:]], [])
        case ast.Call(func=func, args=args) if not is_sensor(node):
            return ast.Call(func, [with_names(arg, name) for arg in args], [])
        case ast.Call(func=func):  # where a sensor is belongs to the code, by one way to write it
            sensor = sensor_of(node)
            assert sensor is not None
            return ast.Call(func, [ast.Constant(sensor.at)], [])
    return node


def in_brief(text: str) -> str:
    """A text for readers: of a table that is long, how many knots it has, and of which kind."""
    if TABLE not in text:
        return text

    class Brief(ast.NodeTransformer):
        def visit_Call(self, node: ast.Call) -> ast.expr:
            self.generic_visit(node)
            if is_table(node) and len(table_of(node).knots) > FEW:
                argument, knots, _, *kind = node.args
                assert isinstance(knots, ast.List)
                node.args = [argument, ast.Name(f"{len(knots.elts)} knots"), *kind]
            return node

    return ast.unparse(Brief().visit(ast.parse(text.strip(), mode="eval")))


def _named(element: ast.expr, name: Namer, what: str) -> ast.expr:
    """A number of a table, with its sign, by name."""
    value = number_of(element)
    return element if value is None else name(value, what)


def with_values(node: ast.expr, values: Mapping[str, float]) -> ast.expr:
    """A tree in which numbers stand in place of some names."""

    class Values(ast.NodeTransformer):
        def visit_Name(self, name: ast.Name) -> ast.expr:
            if name.id not in values:
                return name
            return ast.parse(repr(float(values[name.id])), mode="eval").body

    made: ast.expr = Values().visit(copy.deepcopy(node))
    return ast.fix_missing_locations(made)
