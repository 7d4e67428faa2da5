"""The words of expressions: constants, operators, functions, tables and sensors."""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

LINEAR, CUBIC = "linear", "cubic"
TABLE = "interp"
SLOPE = "_slope"  # of a table: what its kind ends in where its derivative is meant
SENSORS = ("phi", "omega", "x", "y", "vx", "vy")
FUNCTIONS: dict[str, tuple[int, int | None, Callable[..., Any]]] = {
    "sin": (1, 1, np.sin),
    "cos": (1, 1, np.cos),
    "tan": (1, 1, np.tan),
    "exp": (1, 1, np.exp),
    "log": (1, 1, np.log),
    "sqrt": (1, 1, np.sqrt),
    "abs": (1, 1, np.abs),
    "tanh": (1, 1, np.tanh),
    "min": (2, None, lambda *a: reduce(np.minimum, a)),
    "max": (2, None, lambda *a: reduce(np.maximum, a)),
}
BINARY: dict[type[ast.operator], tuple[str, Callable[..., Any]]] = {
    ast.Add: ("+", np.add),
    ast.Sub: ("-", np.subtract),
    ast.Mult: ("*", np.multiply),
    ast.Div: ("/", np.divide),
    ast.Pow: ("**", np.power),
}
UNARY: dict[type[ast.unaryop], tuple[str, Callable[..., Any]]] = {
    ast.USub: ("-", np.negative),
    ast.UAdd: ("+", np.positive),
}
COMPARE: dict[type[ast.cmpop], tuple[str, Callable[..., Any]]] = {
    ast.Lt: ("<", np.less),
    ast.LtE: ("<=", np.less_equal),
    ast.Gt: (">", np.greater),
    ast.GtE: (">=", np.greater_equal),
}
ALLOWED = (
    "an expression of numbers, {names}, pi, + - * / **, < <= > >=, `a if c else b`, "
    + " ".join(FUNCTIONS)
    + " and interp(x, [knots], [values]) or interp(x, 'table')"
)
SENSED = ", and " + " ".join(f"{name}(s)" for name in SENSORS) + " with a number s from 0 to 1"
