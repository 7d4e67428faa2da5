"""Syntax of expressions in C: those of the equations, and those of a scene."""

from __future__ import annotations

from sympy import Abs, Max, Min, asin, asinh, atan, cos, cosh, exp, log, sign, sin, sinh, tan, tanh

from rodgen.emit.printer import ATOM, PRODUCT, Dialect
from rodgen.scene.grammar import CUBIC, LINEAR, SLOPE, Language


def _power(base: str, exponent: str, strength: int) -> tuple[str, int]:
    if exponent == "2":
        return f"square({base})", ATOM
    if exponent == "3" and strength == ATOM:
        return f"{base}*square({base})", PRODUCT
    return f"pow({base}, {exponent})", ATOM


# With least and greatest of two numbers, as they are not-a-number where one of them is.
SCENE = Language(
    prefix="",
    names={"min": "least", "max": "greatest", "abs": "fabs"},
    choice="({0} ? {1} : {2})",
    power="pow({0}, {1})",
    list="(const double[]){{{0}}}",
    part="p + {start}{first}",
    tables={
        kind: f"{kind}({{0}}, {{1}}, {{2}}, {{3}})"
        for kind in (LINEAR, CUBIC, LINEAR + SLOPE, CUBIC + SLOPE)
    },
)
EQUATIONS = Dialect(
    functions={
        sin: "sine",
        cos: "cosine",
        tan: "tan",
        exp: "exp",
        log: "log",
        sinh: "sinh",
        cosh: "cosh",
        tanh: "tanh",
        asinh: "asinh",
        atan: "atan",
        asin: "asin",
        Abs: "fabs",
        sign: "sign",
    },
    extremes={Min: "fmin", Max: "fmax"},
    root="sqrt",
    choice="({condition} ? {value} : {other})",
    power=_power,
    fraction="{p}.0/{q}",
    language=SCENE,
)
