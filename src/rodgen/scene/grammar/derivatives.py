"""Derivatives of trees, and where a tree is not smooth or not finite."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import lru_cache

from rodgen.scene.grammar.syntax_tree import (
    KEPT,
    InterpolationTable,
    children,
    find_tables,
    is_table,
    make_tree,
    meaning_of,
    names_in,
    table_in_call,
    with_kind,
)
from rodgen.scene.grammar.vocabulary import FUNCTIONS, SLOPE


def derivative(node: ast.expr, by: str) -> ast.expr | None:
    """Derivative of a tree by a name; None where it is zero. At a kink it is that of one side."""
    if by not in names_in(node):
        return None
    slopes = [derivative(child, by) if not is_if else None for child, is_if in children(node)]
    match node:
        case ast.UnaryOp(op=op):
            return ast.UnaryOp(op, slopes[0]) if slopes[0] else None
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _sum(_product(slopes[0], right), _product(left, slopes[1]))
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            less = _product(_quotient(left, right), slopes[1])
            over = _sum(slopes[0], ast.UnaryOp(ast.USub(), less) if less else None)
            return _quotient(over, right) if over else None
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            lower = ast.BinOp(left, ast.Pow(), ast.BinOp(right, ast.Sub(), ast.Constant(1.0)))
            grown = ast.BinOp(node, ast.Mult(), _call("log", left))
            return _sum(_product(_product(right, lower), slopes[0]), _product(grown, slopes[1]))
        case ast.BinOp(op=op):
            other = ast.UnaryOp(ast.USub(), slopes[1]) if slopes[1] else None
            return _sum(slopes[0], other if isinstance(op, ast.Sub) else slopes[1])
        case ast.IfExp(test=test):
            _, body, orelse = slopes
            return _choice(test, body, orelse)
        case ast.Call() if meaning_of(node):
            return slopes[0]
        case ast.Call() if is_table(node):
            return _product(with_kind(node, table_in_call(node).kind + SLOPE), slopes[0])
        case ast.Call(func=ast.Name(id="min" | "max" as name), args=[*first, last]) if first:
            rest = first[0] if len(first) == 1 else _call(name, *first)
            smaller = ast.Lt() if name == "min" else ast.Gt()
            test = ast.Compare(rest, [smaller], [last])
            return _choice(test, derivative(rest, by), slopes[-1])
        case ast.Call(func=ast.Name(id=name), args=[arg]) if name in FUNCTIONS:
            slope = make_tree(FUNCTIONS[name].slope, {"x": arg, "f": node})
            return _product(slope, slopes[0])
    return ast.Constant(1.0)  # itself


def _call(name: str, *args: ast.expr) -> ast.expr:
    return ast.Call(ast.Name(name), list(args), [])


# None stands for zero.
def _sum(a: ast.expr | None, b: ast.expr | None) -> ast.expr | None:
    return ast.BinOp(a, ast.Add(), b) if a and b else a or b


def _quotient(a: ast.expr, b: ast.expr) -> ast.expr:
    return ast.BinOp(a, ast.Div(), b)


def _product(a: ast.expr | None, b: ast.expr | None) -> ast.expr | None:
    return ast.BinOp(a, ast.Mult(), b) if a and b else None


def _choice(test: ast.expr, body: ast.expr | None, orelse: ast.expr | None) -> ast.expr | None:
    if not (body or orelse):
        return None
    return ast.IfExp(test, body or ast.Constant(0.0), orelse or ast.Constant(0.0))


Pair = tuple[ast.expr, ast.expr | None]


@lru_cache(maxsize=KEPT)
def kinks(node: ast.AST, variable: str) -> tuple[Pair, ...]:
    """Pairs of parts whose difference is zero where the tree is not smooth; of a table, unless it
    is one of the variable itself (see ``tables_in_variable``), its argument and its call."""
    return tuple(_kinks(node, variable))


def _kinks(node: ast.AST, variable: str) -> Iterator[Pair]:
    match node:
        case ast.Compare(left=left, comparators=[right]):
            yield left, right
        case ast.Call(func=ast.Name(id="abs"), args=[arg]):
            yield arg, None
        case ast.Call(func=ast.Name(id="min" | "max"), args=args):
            yield from ((a, b) for at, a in enumerate(args) for b in args[at + 1 :])
        case ast.Call() if is_table(node):
            argument = table_in_call(node).argument
            if not _is_variable(argument, variable):
                yield argument, node
    for child, _ in children(node):
        yield from kinks(child, variable)


def conditions(node: ast.AST) -> frozenset[Pair]:
    """Pairs that conditions compare: where their difference is zero, what is chosen may jump."""
    own = {(node.left, node.comparators[0])} if isinstance(node, ast.Compare) else set()
    return frozenset(own).union(*(conditions(child) for child, _ in children(node)))


def tables_in_variable(node: ast.AST, variable: str) -> Iterator[InterpolationTable]:
    """Yield the tables whose argument is the variable itself."""
    return (one for one in find_tables(node) if _is_variable(one.argument, variable))


def _is_variable(node: ast.expr, variable: str) -> bool:
    return isinstance(node, ast.Name) and node.id == variable


@lru_cache(maxsize=KEPT)
def divisors(node: ast.AST) -> tuple[ast.expr, ...]:
    """Divisors in a tree, among them bases of powers and the cosines in tangents."""
    return tuple(_divisors(node))


def _divisors(node: ast.AST) -> Iterator[ast.expr]:
    match node:
        case ast.BinOp(op=ast.Div(), right=divisor) | ast.BinOp(op=ast.Pow(), left=divisor):
            yield divisor
        case ast.Call(func=ast.Name(id="tan"), args=args):
            yield ast.Call(ast.Name("cos"), args, [])
    for child, _ in children(node):
        yield from divisors(child)
