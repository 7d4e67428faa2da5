"""Numbers in the text of an expression: listed, and replaced by others.

Another value of one of them needs no other module: see `Expression.with_parameters`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import takewhile

from rodgen.errors import InputError
from rodgen.scene import grammar
from rodgen.scene.plain_tables import is_number

THIS, OTHER, CUT = "□", "·", "…"
NEAR = 12  # characters of the text before and behind a number that tell where it stands


@dataclass(frozen=True)
class Literal:
    """A number in a text. around: the text near it, with □ for it and · for others, which does not
    change with these; leads: whether all that changes is multiplied by it; signed: whether its sign
    is part of it."""

    value: float
    around: str
    leads: bool
    signed: bool


def literals(text: str, named: Collection[str] = ()) -> list[Literal]:
    """Numbers in a checked expression, in the order of the text, without whole exponents and the
    places of sensors; named: names in it that stand for numbers."""
    tree = _parse(text)
    found = _number_nodes(tree)
    changing = frozenset(grammar.names_in(tree)) - {*named}
    outer = takewhile(
        lambda step: step[0] in (ast.Mult, ast.Div), grammar.affine_core(tree, changing)[1]
    )
    factors = [part for kind, part in outer if kind is ast.Mult]
    places = [_text_span(text, node) for node in found]
    return [
        Literal(
            value=float(ast.literal_eval(node)),
            around=_context(text, places, at),
            leads=node in factors[:1],
            signed=tabled,
        )
        for at, (node, tabled) in enumerate(found.items())
    ]


def replace_literal(text: str, at: int, value: object, field: str) -> str:
    """Replace a number in a text, and leave all else as it is written; field: what the text is
    called in messages. Raises InputError for what is no number."""
    found = _number_nodes(_parse(text))
    if at >= len(found):
        allowed = f"a key of the scene ({text} has {len(found)} numbers, counted from 0)"
        raise InputError("key", field, allowed)
    value = to_finite_number(value, field)
    if value < 0 and not [*found.values()][at]:
        raise InputError(field, value, "at least 0: a sign stands in the text before it")
    return replace_literal_by_name(text, at, repr(value).removesuffix(".0"))


def to_finite_number(value: object, field: str) -> float:
    """Convert a value to a finite number. Raises InputError where it is none."""
    allowed = "a finite number, such as 0.25 or 1e-3"
    try:
        number = float(value) if is_number(value) else math.nan
    except OverflowError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(field, value, allowed)
    return number or 0.0


def replace_literal_by_name(text: str, at: int, name: str) -> str:
    """Replace a number in a text by a name, or anything else."""
    first, last = _text_span(text, [*_number_nodes(_parse(text))][at])
    return text[:first] + name + text[last:]


def _parse(text: str) -> ast.expr:
    tree = grammar.parse(text, "expression")
    if tree is None:
        raise InputError("expression", text, "one that can be read")
    return tree


def _number_nodes(tree: ast.expr) -> dict[ast.expr, bool]:
    """Nodes of the numbers in a tree, in the order of the text, and whether each is in a table."""
    tabled = (element for of in grammar.find_tables(tree) for element in (*of.knots, *of.values))
    found = dict.fromkeys(_numbers_outside_tables(tree), False)
    found |= {element: True for element in tabled if not isinstance(element, ast.Name)}
    return dict(sorted(found.items(), key=lambda pair: (pair[0].lineno, pair[0].col_offset)))


def _numbers_outside_tables(node: ast.expr) -> Iterator[ast.expr]:
    """Yield the numbers that are in no table, without whole exponents."""
    match node:
        case ast.Constant():
            yield node
        case ast.BinOp(left=left, op=ast.Pow(), right=right) if grammar.is_whole_number(right):
            yield from _numbers_outside_tables(left)
        case _:
            for child, _ in grammar.children(node):
                yield from _numbers_outside_tables(child)


def _text_span(text: str, node: ast.expr) -> tuple[int, int]:
    """Where in the text a node begins and ends."""
    lines = text.strip().encode().splitlines(keepends=True)
    assert node.end_lineno is not None
    assert node.end_col_offset is not None

    def offset(line: int, column: int) -> int:
        before = b"".join(lines[: line - 1]) + lines[line - 1][:column]
        return len(text) - len(text.lstrip()) + len(before.decode())

    return offset(node.lineno, node.col_offset), offset(node.end_lineno, node.end_col_offset)


def _context(text: str, places: list[tuple[int, int]], at: int) -> str:
    """Text near a number, with signs in place of all numbers."""
    parts, end = [], 0
    for number, (first, last) in enumerate(places):
        parts += [text[end:first], THIS if number == at else OTHER]
        end = last
    whole = " ".join("".join((*parts, text[end:])).split())
    here = whole.index(THIS)
    low, high = max(0, here - NEAR), here + 1 + NEAR
    return CUT * (low > 0) + whole[low:high] + CUT * (high < len(whole))
