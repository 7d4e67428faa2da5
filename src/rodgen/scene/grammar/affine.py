"""What of a tree changes, apart from the numbers that it is multiplied by and that are added."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from rodgen.scene.grammar.syntax import names_in
from rodgen.scene.grammar.values import value_of

# The kind of a step from the inside out, and the tree of its number.
Step = tuple[type[ast.operator] | type[ast.unaryop], ast.expr | None]


@lru_cache(maxsize=256)
def core(node: ast.expr, changing: frozenset[str]) -> tuple[ast.expr, tuple[Step, ...]]:
    """The part of a tree that changes with some names, and the steps from the whole to it."""

    def fixed(part: ast.expr) -> bool:
        return changing.isdisjoint(names_in(part))

    steps: list[Step] = []
    while True:
        match node:
            case ast.UnaryOp(op=op, operand=inner):
                steps.append((type(op), None))
            case ast.BinOp(
                left=inner, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() as op, right=by
            ) if fixed(by):
                steps.append((type(op), by))
            case ast.BinOp(left=by, op=ast.Add() | ast.Mult() as op, right=inner) if fixed(by):
                steps.append((type(op), by))
            case ast.BinOp(left=by, op=ast.Sub(), right=inner) if fixed(by):
                steps += ((ast.Add, by), (ast.USub, None))
            case _:
                return node, tuple(steps)
        node = inner


def scale_and_offset(steps: tuple[Step, ...], names: Mapping[str, Any]) -> tuple[float, float]:
    """a and b of what the whole is, a times its core plus b, by the values of its names."""
    a, b = 1.0, 0.0
    for kind, part in steps:
        value = float(value_of(part, names)) if part is not None else 1.0
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
