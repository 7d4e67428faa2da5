"""Splitting of a tree into a*core + b, of which the core alone changes."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from rodgen.scene.grammar.evaluation import evaluate
from rodgen.scene.grammar.syntax_tree import names_in

# An affine step: its operator, and the tree of its number, None for a sign.
Step = tuple[type[ast.operator] | type[ast.unaryop], ast.expr | None]


@lru_cache(maxsize=256)
def affine_core(node: ast.expr, changing: frozenset[str]) -> tuple[ast.expr, tuple[Step, ...]]:
    """Innermost part of a tree with all that changes with some names, and the steps to it."""

    def is_constant(part: ast.expr) -> bool:
        return changing.isdisjoint(names_in(part))

    steps: list[Step] = []
    while True:
        match node:
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
