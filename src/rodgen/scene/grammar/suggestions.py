"""Suggestions for an expression, or a part of it, that is not allowed."""

from __future__ import annotations

import ast
import re
import warnings
from collections.abc import Iterable

from rodgen.errors import did_you_mean, shorten
from rodgen.scene.grammar.vocabulary import FUNCTIONS, SENSORS, TABLE

LINE_END = re.compile("\r\n|\r|\n")  # as Python counts lines
SHOWN = 20  # characters of a text from its mistake on
# Functions of other programs, and what is written here.
OTHERWISE = {
    **dict.fromkeys(("step", "heaviside", "Heaviside"), "`1 if x > 0 else 0`"),
    **dict.fromkeys(("sign", "sgn"), "`1 if x > 0 else -1`"),
    "ln": "log(x)",
    "radians": "deg(x)",
    "cosh": "(exp(x) + exp(-x))/2",
    "sinh": "(exp(x) - exp(-x))/2",
}


def syntax_error(text: str) -> str:
    """Reason and place of a syntax error; "" where Python names none."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ast.parse(text.strip(), mode="eval")
    except SyntaxError as error:
        said = error.msg.partition(".")[0]  # then Python guesses at statements, which none here is
        line, column = error.lineno or 1, error.offset or 0
        lines = LINE_END.split(text.strip())
        rest = lines[line - 1][column - 1 :] if column and line <= len(lines) else ""
        if not rest:
            return f"{said}, at the end"
        at = f"character {column}" + f" of line {line}" * (line > 1)
        return f"{said}, at {at}: {shorten(rest, SHOWN)}"
    except (ValueError, RecursionError, MemoryError):
        pass
    return ""


def suggest(node: ast.AST | None, names: Iterable[str]) -> str:
    """End of a message that suggests what to write instead of a part; names: the known ones."""
    match node:
        case ast.BinOp(op=ast.BitXor()):
            return "; a power is written **, not ^"
        case ast.Call(func=ast.Attribute(attr=name)) | ast.Attribute(attr=name) if (
            name in FUNCTIONS or name == "pi"
        ):
            return f"; write {name} without {ast.unparse(_receiver(node))}."
        case ast.Call(func=ast.Name(id=name)) if name in OTHERWISE:
            return f"; {name}(x) is written {OTHERWISE[name]}"
        case ast.Call(func=ast.Name(id=name)) if name in SENSORS:
            return "; it does not follow the motion, which sensors measure"
        case ast.Call(func=ast.Name(id=name)) if name not in FUNCTIONS:
            return did_you_mean(name, (*FUNCTIONS, TABLE, *SENSORS))
        case ast.Name(id="d" | "dt"):
            return "; there is no d/dt: omega(s), vx(s) and vy(s) are the rates"
        case ast.Name(id=name):
            return did_you_mean(name, (*names, "pi"))
    return ""


def _receiver(node: ast.AST) -> ast.AST:
    """Part before the dot."""
    inner = node.func if isinstance(node, ast.Call) else node
    assert isinstance(inner, ast.Attribute)
    return inner.value
