"""Parameters of a scene in a stretch in which they are smooth, as numbers or symbols."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from typing import Any

import rodgen
from rodgen.scene.expression import Expression

NAMES = ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh")  # what is left of the grammar
Functions = Mapping[str, Callable[[Any], Any]]
PLAIN: Functions = {name: getattr(math, name) for name in NAMES}


Parameters = Callable[[Any], dict[str, Any]]  # t [s], a number or a symbol -> values by name


def parameters(scene: rodgen.Scene, middle: float, functions: Functions) -> Parameters:
    """Values of all parameters as the functions make them of t.

    middle: a time of the stretch, in which no condition changes its answer.
    """
    scope = {"__builtins__": {}, "pi": math.pi, "deg": lambda x: x * (math.pi / 180), **functions}
    fixed, codes = scene.parameters, {}
    for name, expression in scene.time_dependent_loads.items():
        codes[name] = compile(smooth(expression, middle), "<load>", "eval")

    def at(t: Any) -> dict[str, Any]:
        return {**fixed, **{name: eval(code, scope, {"t": t}) for name, code in codes.items()}}

    return at


def smooth(expression: Expression, middle: float) -> str:
    """The expression as it is in that stretch: without conditions, min, max and abs."""
    tree = ast.parse(expression.canonical, mode="eval").body
    return ast.unparse(_Resolved(middle).visit(tree))


class _Resolved(ast.NodeTransformer):
    def __init__(self, middle: float):
        self.middle = middle

    def _value(self, node: ast.expr) -> float:
        return float(Expression(ast.unparse(node), "t")(self.middle))

    def visit(self, node: ast.AST) -> Any:
        """A number for what t is not in, which symbols have no functions of."""
        inside = {inner.id for inner in ast.walk(node) if isinstance(inner, ast.Name)}
        if isinstance(node, ast.expr) and "t" not in inside:
            return ast.Constant(self._value(node))
        return super().visit(node)

    def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
        holds = self._value(ast.IfExp(node.test, ast.Constant(1), ast.Constant(0)))
        chosen: ast.AST = self.visit(node.body if holds else node.orelse)
        return chosen

    def visit_Call(self, node: ast.Call) -> ast.AST:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name in ("min", "max"):
            found: ast.AST = self.visit({"min": min, "max": max}[name](node.args, key=self._value))
            return found
        if name == "abs":
            inner = self.visit(node.args[0])
            return inner if self._value(node.args[0]) >= 0 else ast.UnaryOp(ast.USub(), inner)
        node.args = [self.visit(argument) for argument in node.args]
        return node
