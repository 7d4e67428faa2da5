"""The words of expressions: constants, operators, functions, tables and sensors."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

LINEAR, CUBIC = "linear", "cubic"
TABLE = "interp"
SLOPE = "_slope"  # of a table: what its kind ends in where its derivative is meant
AT_POINTS = ("phi", "omega", "x", "y", "vx", "vy")
OF_STOPS = ("stop", "joint_stop")  # what pushes, by its number in the scene: its force or moment
SENSORS = (*AT_POINTS, *OF_STOPS)


@dataclass(frozen=True)
class ExpressionFunction:
    """A function of expressions.

    value: of NumPy's numbers; slope: its derivative, as text in its number x and its value f;
    least, most: how many numbers it takes; meaning: text in x for which it stands, whose value,
    code and derivative are then its own; unit: of its value.
    """

    value: Callable[..., Any]
    slope: str = ""
    least: int = 1
    most: int | None = 1
    meaning: str = ""
    unit: str = ""


FUNCTIONS = {
    "sin": ExpressionFunction(np.sin, "cos(x)"),
    "cos": ExpressionFunction(np.cos, "-sin(x)"),
    "tan": ExpressionFunction(np.tan, "1 + f*f"),
    "exp": ExpressionFunction(np.exp, "f"),
    "log": ExpressionFunction(np.log, "1/x"),
    "sqrt": ExpressionFunction(np.sqrt, "0.5/f"),
    "abs": ExpressionFunction(np.abs, "-1 if x < 0 else 1"),
    "tanh": ExpressionFunction(np.tanh, "1 - f*f"),
    "min": ExpressionFunction(lambda *a: reduce(np.minimum, a), least=2, most=None),
    "max": ExpressionFunction(lambda *a: reduce(np.maximum, a), least=2, most=None),
    "deg": ExpressionFunction(np.positive, meaning="x*(pi/180)", unit="rad"),
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
    "an expression of {names}, + - * / **, < <= > >=, `a if c else b`, "
    + " ".join(FUNCTIONS)
    + " and interp(x, [knots], [values]) or interp(x, 'table')"
)
SENSED = ", and " + " ".join(f"{name}(s)" for name in AT_POINTS) + " with a number s from 0 to 1"
SENSED += ", stop(0) joint_stop(0) with the number of a table"
