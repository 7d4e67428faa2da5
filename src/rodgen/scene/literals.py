"""Numbers that stand in the text of an expression: each by itself, and the text with another one.

Another value of one of them needs no other module: see `Expression.parametrised`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import takewhile

from rodgen.errors import InputError
from rodgen.scene import grammar
from rodgen.scene.plain import is_number

THIS, OTHER, CUT = "□", "·", "…"
NEAR = 12  # characters of the text before and behind a number that tell where it stands


@dataclass(frozen=True)
class Literal:
    """A number in a text: its value; the text around it, in which it is □ and others are ·, so that
    it stays what it is when they change; leads: whether all that changes is multiplied by it;
    signed: whether its sign is part of it."""

    value: float
    around: str
    leads: bool
    signed: bool


def literals(text: str, named: Collection[str] = ()) -> list[Literal]:
    """The numbers in a checked expression, in the order of the text, without whole exponents and
    the places of sensors; named: names in it that stand for numbers."""
    tree = _tree(text)
    found = _found(tree)
    changing = frozenset(grammar.names_in(tree)) - {*named}
    outer = takewhile(lambda step: step[0] in (ast.Mult, ast.Div), grammar.core(tree, changing)[1])
    factors = [part for kind, part in outer if kind is ast.Mult]
    places = [_place(text, node) for node in found]
    return [
        Literal(
            value=float(ast.literal_eval(node)),
            around=_around(text, places, at),
            leads=node in factors[:1],
            signed=tabled,
        )
        for at, (node, tabled) in enumerate(found.items())
    ]


def with_literal(text: str, at: int, value: object, field: str) -> str:
    """The text with another value of one of its numbers, all else as it is written; field: what
    the text is called in messages. Raises InputError for what is no number."""
    found = _found(_tree(text))
    if at >= len(found):
        allowed = f"a key of the scene ({text} has {len(found)} numbers, counted from 0)"
        raise InputError("key", field, allowed)
    value = checked(value, field)
    if value < 0 and not [*found.values()][at]:
        raise InputError(field, value, "at least 0: a sign stands in the text before it")
    return with_name(text, at, repr(value).removesuffix(".0"))


def checked(value: object, field: str) -> float:
    """The number that a value is. Raises InputError where it is none."""
    allowed = "a finite number, such as 0.25 or 1e-3"
    try:
        number = float(value) if is_number(value) else math.nan
    except OverflowError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(field, value, allowed)
    return number or 0.0


def with_name(text: str, at: int, name: str) -> str:
    """The text with a name, or anything else, in place of one of its numbers."""
    first, last = _place(text, [*_found(_tree(text))][at])
    return text[:first] + name + text[last:]


def _tree(text: str) -> ast.expr:
    tree = grammar.parse(text, "expression")
    if tree is None:
        raise InputError("expression", text, "one that can be read")
    return tree


def _found(tree: ast.expr) -> dict[ast.expr, bool]:
    """Its numbers in the order of the text, and whether each is one of a table, with its sign."""
    tabled = (element for of in grammar.tables(tree) for element in (*of.knots, *of.values))
    found = dict.fromkeys(_free(tree), False)
    found |= {element: True for element in tabled if not isinstance(element, ast.Name)}
    return dict(sorted(found.items(), key=lambda pair: (pair[0].lineno, pair[0].col_offset)))


def _free(node: ast.expr) -> Iterator[ast.expr]:
    """Its numbers that are in no table."""
    match node:
        case ast.Constant():
            yield node
        case ast.BinOp(left=left, op=ast.Pow(), right=right) if grammar.is_whole(right):
            yield from _free(left)
        case _:
            for child, _ in grammar.children(node):
                yield from _free(child)


def _place(text: str, node: ast.expr) -> tuple[int, int]:
    """Where in the text a part begins and ends."""
    lines = text.strip().encode().splitlines(keepends=True)
    assert node.end_lineno is not None
    assert node.end_col_offset is not None

    def place(line: int, column: int) -> int:
        before = b"".join(lines[: line - 1]) + lines[line - 1][:column]
        return len(text) - len(text.lstrip()) + len(before.decode())

    return place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset)


def _around(text: str, places: list[tuple[int, int]], at: int) -> str:
    """The text near a number, all numbers in it shown by signs."""
    parts, end = [], 0
    for number, (first, last) in enumerate(places):
        parts += [text[end:first], THIS if number == at else OTHER]
        end = last
    whole = " ".join("".join((*parts, text[end:])).split())
    here = whole.index(THIS)
    low, high = max(0, here - NEAR), here + 1 + NEAR
    return CUT * (low > 0) + whole[low:high] + CUT * (high < len(whole))
