"""Numbers in the text of an expression, listed and replaced by others; and names of numbers: those
of a module, and which of others a user may give.

Another value of one of them needs no other module: see `Expression.with_parameters`.
"""

from __future__ import annotations

import ast
import keyword
import math
import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import takewhile

from rodgen.errors import InputError
from rodgen.model.quantities import QUANTITIES, parse_number
from rodgen.model.rod import MASS_PER_LENGTH
from rodgen.model.term import ANY, KNOTS, Parameter
from rodgen.model.terms import CONTACTS, PARAMETERS, TERMS
from rodgen.scene import grammar
from rodgen.scene.grammar import FUNCTIONS, TABLE
from rodgen.scene.plain_tables import is_number

MARKED, CUT = "«%s»", "…"
NEAR = 16  # characters of the text before and behind a number that tell where it stands

LONGEST = 64  # characters
NAME = re.compile(rf"[A-Za-z][A-Za-z0-9_]{{0,{LONGEST - 1}}}")
# Names with a meaning in generated modules, and the variables of expressions.
TAKEN = {"isa", "t", "s", "d", "k", "p", "y", "np", "math", "fins", "N", "pi", TABLE, *FUNCTIONS}
# A number of an expression without a name, or a table.
MADE = re.compile(r"(.+?)_(?:knot_|value_|table_)?\d+")
# Before the name of a load, its quantities; of contacts, theirs.
OF_LOADS = (
    *("work_", "power_", "force_", "airspeed_", "attack_"),
    *(f"{what}_{term.name}" for what in ("depth", "push") for term in CONTACTS),
)
SENSORS = re.compile(r"(phi|omega|x|y|vx|vy|stop|joint_stop)(_?\d+)?")


@dataclass(frozen=True)
class Literal:
    """A number in a text. around: the text near it, in which it is marked; leads: whether all that
    changes is multiplied by it; signed: whether its sign is part of it."""

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
            around=_context(text, *places[at]),
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
            for child, _ in grammar.written_parts(node):
                yield from _numbers_outside_tables(child)


def _text_span(text: str, node: ast.expr) -> tuple[int, int]:
    """Positions in the text at which a node begins and ends."""
    lines = text.strip().encode().splitlines(keepends=True)
    assert node.end_lineno is not None
    assert node.end_col_offset is not None

    def offset(line: int, column: int) -> int:
        before = b"".join(lines[: line - 1]) + lines[line - 1][:column]
        return len(text) - len(text.lstrip()) + len(before.decode())

    return offset(node.lineno, node.col_offset), offset(node.end_lineno, node.end_col_offset)


def _context(text: str, first: int, last: int) -> str:
    """Text near a number, which is marked; first, last: its span."""
    before, after = text[:first], text[last:]
    low = max(0, len(before) - NEAR)
    near = before[low:] + MARKED % text[first:last] + after[:NEAR]
    return " ".join(f"{CUT * (low > 0)}{near}{CUT * (len(after) > NEAR)}".split())


def check_name(name: str, field: str) -> None:
    """Raise InputError for what cannot be the name of a number in an expression."""
    if not NAME.fullmatch(name):
        raise InputError(field, name, f"a plain identifier of at most {LONGEST} ASCII characters")
    taken = name in TAKEN or name in PARAMETERS or keyword.iskeyword(name)
    if taken or SENSORS.fullmatch(name) or name.startswith("_"):
        raise InputError(field, name, "a name that stands for nothing else in a module")


def check_states(names: Iterable[str], numbers: Iterable[str]) -> None:
    """Raise InputError for names of states that stand for something else, in expressions or where
    states are listed beside terms and quantities; numbers: names in the table [parameters]."""
    taken = {name.upper() for term in TERMS.values() for name in (term.name, term.table)}
    taken |= {name.upper() for name in numbers}
    known = [name for of in QUANTITIES for name in (of.name, *of.numbers) if name != "{}"]
    for name in names:
        shown = any(parse_number(name, template) is not None for template in known)
        shown |= name.startswith(OF_LOADS)
        if name.upper() in taken or shown:
            allowed = "unlike the names of terms, quantities and [parameters]"
            raise InputError(f"states.{name}", name, allowed)


def mass_name(body: str) -> str:
    """Name in a module of a mass that changes with time: of a body, or, of "", of the links."""
    return f"body_{body}_mass" if body else MASS_PER_LENGTH.name


def number_parameter(name: str, rule: str = ANY) -> Parameter:
    """Module parameter for a number of an expression."""
    what = "a number in an expression" + " of t" * (rule == ANY)
    return Parameter(name, name, name, "", "", what, rule=rule)


def table_parameter(name: str) -> Parameter:
    """Module parameter for a table of an expression."""
    what = "knots of a table in an expression, which ascend, and then a value for each"
    return Parameter(name, name, name, "", "", what, each=KNOTS)


def check_names(names: Iterable[str], table: str, also: Iterable[str] = ()) -> None:
    """Raise InputError for names of a table that differ in case alone, or that a module gives to
    numbers of its parameters and of `also`, other prefixes of such names."""
    seen: dict[str, str] = {}
    numbered = {one.lower() for one in also}
    for name in names:
        field = f"{table}.{name}"
        check_name(name, field)
        if (other := seen.setdefault(name.upper(), name)) != name:
            raise InputError(field, name, f"unlike {other} by more than the size of its letters")
        made = MADE.fullmatch(name.lower())
        if made and (made[1] in PARAMETERS or made[1] in numbered):
            raise InputError(field, name, "unlike the names of numbers in expressions")
