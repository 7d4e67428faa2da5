"""Law of the springs as an expression of the derivation, from its text: the checked tree is walked,
and nothing is evaluated."""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import cache
from typing import Any

import sympy
from sympy import Expr, Piecewise, Symbol

from rodgen.derive.chain import LINEAR, spring_energy
from rodgen.derive.symbols import bend, k
from rodgen.emit.printer import NUMPY, Printer
from rodgen.errors import InputError
from rodgen.scene import grammar, spring_law
from rodgen.scene.structure import Structure

COMPARE: dict[type[ast.cmpop], Any] = {
    ast.Lt: sympy.Lt,
    ast.LtE: sympy.Le,
    ast.Gt: sympy.Gt,
    ast.GtE: sympy.Ge,
}
BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}

CAPITAL = "abs", "min", "max"  # which SymPy spells Abs, Min, Max
FUNCTIONS = {
    name: getattr(sympy, name.title() if name in CAPITAL else name)
    for name, of in grammar.FUNCTIONS.items()
    if not of.meaning
}


def law_of(structure: Structure) -> Expr:
    """The law of the springs of a structure. Raises InputError where its energy cannot be had."""
    return _parse_law(structure.spring) if structure.spring else LINEAR


@cache
def _parse_law(text: str) -> Expr:
    tree = grammar.parse(text, spring_law.FIELD)
    assert tree is not None
    found = _expression(tree)
    try:
        for needed in (found, spring_energy(found)):
            Printer(NUMPY, str, lambda _: 0)(needed)
    except TypeError:
        allowed = "a law whose integral over d, its energy, SymPy finds in elementary functions"
        raise InputError(spring_law.FIELD, text, allowed) from None
    return found


def _expression(node: ast.expr) -> Any:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        return _expression(node.left) ** int(grammar.evaluate(node.right, {}))
    parts = [_expression(child) for child, _ in grammar.children(node)]
    match node:
        case ast.Constant(value=int() as whole):  # of what a function stands for
            return sympy.Integer(whole)
        case ast.Name(id=name):
            # Numbers are not negative, which the scene has seen to.
            known = {spring_law.BEND: bend, spring_law.STIFFNESS: k, "pi": sympy.pi}
            return known.get(name) or Symbol(name, positive=True)
        case ast.BinOp(op=op):
            return BINARY[type(op)](*parts)
        case ast.UnaryOp(op=op):
            return -parts[0] if isinstance(op, ast.USub) else parts[0]
        case ast.Compare(ops=[op]):
            return COMPARE[type(op)](*parts)
        case ast.IfExp():
            condition, value, other = parts
            return Piecewise((value, condition), (other, True))
        case ast.Call(func=ast.Name(id=name)):
            return FUNCTIONS[name](*parts) if name in FUNCTIONS else parts[0]
    raise AssertionError(f"unchecked node {node!r}")
