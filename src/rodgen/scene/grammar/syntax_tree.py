"""Parsing and checking of expressions, and the parts that their trees are made of."""

from __future__ import annotations

import ast
import math
import warnings
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import NamedTuple, TypeGuard

from rodgen.errors import InputError
from rodgen.scene.grammar.vocabulary import (
    BINARY,
    COMPARE,
    FUNCTIONS,
    LINEAR,
    OF_STOPS,
    SENSORS,
    TABLE,
    UNARY,
)

LONGEST = 20_000  # characters
BRACKETS = 50  # in each other
DEEPEST = 200  # nested operations, of which a sum of as many terms is one
MOST_KNOTS = 1000  # of a table
MOST_CHOICES = 100  # of an expression, each of which is looked at by itself
CHOICES = "min", "max", "abs"
KEPT = 4096  # parts of trees of which something is remembered
# Makes the error for a part (None: the whole) from what is allowed there ("": the grammar).
Refusal = Callable[[ast.AST | None, str], InputError]


class InterpolationTable(NamedTuple):
    """A call of interp: its argument, the name of its table, its kind of interpolation, and the
    numbers that stand in the text in place of a name."""

    argument: ast.expr
    name: str
    kind: str
    knots: Sequence[ast.expr] = ()
    values: Sequence[ast.expr] = ()


class Sensor(NamedTuple):
    """A sensor: its quantity, of SENSORS, and its place on the rod, from 0 to 1; of a stop the
    number of that."""

    what: str
    at: float

    @property
    def text(self) -> str:
        """Text of the sensor in an expression."""
        return f"{self.what}({self.at!r})"


def parse(text: str, field: str) -> ast.expr | None:
    """Parse a text, None for what Python cannot parse; raises InputError beyond the limits."""
    if len(text) > LONGEST:
        raise InputError(field, text, f"an expression of at most {LONGEST} characters")
    if max(accumulate((c in "([") - (c in ")]") for c in text), default=0) > BRACKETS:
        raise InputError(field, text, f"of parentheses at most {BRACKETS} deep")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python's opinion of "1if t<1else 2"
            tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    if sum(map(_count_choices, ast.walk(tree))) > MOST_CHOICES:
        what = f"an expression of at most {MOST_CHOICES} choices ({', '.join(CHOICES)}, if)"
        raise InputError(field, text, f"{what}; a table, {TABLE}, may have {MOST_KNOTS} knots")
    return tree


def _count_choices(node: ast.AST) -> int:
    """Number of choices that a node makes between the parts below it."""
    match node:
        case ast.IfExp():
            return 1
        case ast.Call(func=ast.Name(id=name), args=args) if name in CHOICES:
            return max(len(args) - 1, 1)
    return 0


def check_tree(
    node: ast.AST,
    variable: str,
    numbers: Container[str],
    refuse: Refusal,
    depth: int = 0,
    condition: bool = False,
    states: Container[str] | None = None,
    known_tables: Container[str] = (),
) -> None:
    """Raise what ``refuse`` makes of the first part that is not allowed; numbers, states,
    known_tables: names that are; where states is None, sensors are refused too."""
    if depth > DEEPEST:
        raise refuse(None, f"nested at most {DEEPEST} deep")
    if condition != isinstance(node, ast.Compare):
        raise refuse(node, "")
    match node:
        case ast.Constant() if is_number(node):
            pass
        case ast.Name(id=name) if name in (variable, "pi") or name in numbers:
            pass
        case ast.Name(id=name) if states and name in states:
            pass
        case ast.BinOp(op=op) | ast.UnaryOp(op=op) if type(op) in (*BINARY, *UNARY):
            pass
        case ast.Compare(ops=ops) if all(type(op) in COMPARE for op in ops) and len(ops) == 1:
            pass
        case ast.IfExp():
            pass
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            least, most = FUNCTIONS[name].least, FUNCTIONS[name].most
            if len(args) < least or (most is not None and len(args) > most):
                raise refuse(node, "")
        case ast.Call(func=ast.Name(id=name), keywords=[]) if name == TABLE:
            _check_table(node, numbers, known_tables, refuse)
        case ast.Call(func=ast.Name(id=name)) if name in SENSORS and states is not None:
            if sensor_of(node) is None:
                stops = f"{name}(k) with the number k of one of [[{name}s]], from 0 on"
                at_point = f"{name}(s) with a number s from 0 to 1"
                raise refuse(node, stops if name in OF_STOPS else at_point)
        case _:
            raise refuse(node, "")
    for child, is_condition in children(node):
        check_tree(child, variable, numbers, refuse, depth + 1, is_condition, states, known_tables)


def _check_table(
    node: ast.Call, numbers: Container[str], named: Container[str], refuse: Refusal
) -> None:
    shape = "interp(x, 'table') or interp(x, [knots], [values]), of as many values as knots, 2 to "
    match node.args:
        case [_, ast.List(), ast.List(), ast.Constant(value="linear" | "cubic")]:
            pass
        case [_, ast.List(), ast.List()]:
            pass
        case [_, ast.Constant(value=str()) | ast.Name(), *kind]:
            if table_in_call(node).name not in named:
                allowed = "of a table of [tables]; files are read by Scene.from_toml"
                raise refuse(node, allowed)
            match kind:
                case [] | [ast.Constant(value="linear" | "cubic")]:
                    return
            raise refuse(node, "interp(x, 'table'), and 'linear' or 'cubic'")
        case _:
            raise refuse(node, f"{shape}{MOST_KNOTS}, and 'linear' or 'cubic'")
    table = table_in_call(node)
    if len(table.knots) != len(table.values) or not 2 <= len(table.knots) <= MOST_KNOTS:
        raise refuse(node, f"{shape}{MOST_KNOTS}")
    for element in (*table.knots, *table.values):
        inner = element.operand if isinstance(element, ast.UnaryOp) else element
        known = isinstance(inner, ast.Name) and inner.id in numbers and inner is element
        sign = not isinstance(element, ast.UnaryOp) or type(element.op) in UNARY
        if not (known or (is_number(inner) and sign)):
            raise refuse(element, "a number, in a table")
    knots = [constant_value(knot) for knot in table.knots]
    given = [knot for knot in knots if knot is not None]
    if len(given) == len(knots) and any(b <= a for a, b in pairwise(given)):
        raise refuse(node, "of knots that ascend")


# Trees are never changed, and walked again and again.
@lru_cache(maxsize=KEPT)
def children(node: ast.AST) -> tuple[tuple[ast.expr, bool], ...]:
    """The parts of a node, and whether each is to be a condition; a table's numbers are none, and
    the part of a call that stands for something else is that."""
    meaning = meaning_of(node)
    return tuple(written_parts(node)) if meaning is None else ((meaning, False),)


@lru_cache(maxsize=KEPT)
def meaning_of(node: ast.AST) -> ast.expr | None:
    """Return the tree for which a call stands, of other functions; None for any other node."""
    match node:
        case ast.Call(func=ast.Name(id=name), args=[x]) if (
            name in FUNCTIONS and FUNCTIONS[name].meaning
        ):
            return make_tree(FUNCTIONS[name].meaning, {"x": x})
    return None


def make_tree(text: str, trees: Mapping[str, ast.expr]) -> ast.expr:
    """Make the tree of a text, with other trees in place of some names."""

    class Filled(ast.NodeTransformer):
        def visit_Name(self, name: ast.Name) -> ast.expr:
            return trees.get(name.id, name)

    made: ast.expr = Filled().visit(ast.parse(text, mode="eval").body)
    return made


def written_parts(node: ast.AST) -> Iterator[tuple[ast.expr, bool]]:
    """Yield the parts of a node as they stand in its text, like `children`."""
    match node:
        case ast.BinOp(left=left, right=right):
            yield from ((left, False), (right, False))
        case ast.UnaryOp(operand=operand):
            yield operand, False
        case ast.Compare(left=left, comparators=[right]):
            yield from ((left, False), (right, False))
        case ast.IfExp(test=test, body=body, orelse=orelse):
            yield from ((test, True), (body, False), (orelse, False))
        case ast.Call(args=args) if not sensor_of(node):
            yield from ((arg, False) for arg in (args[:1] if is_table(node) else args))


@lru_cache(maxsize=KEPT)
def names_in(node: ast.AST) -> tuple[str, ...]:
    """Names of the variable, numbers and states, and sensors, in the order of the text."""
    called = {inner.func for inner in ast.walk(node) if isinstance(inner, ast.Call)}
    named = [of for of in ast.walk(node) if isinstance(of, ast.Name) and of not in called]
    found = named + [inner for inner in ast.walk(node) if sensor_of(inner)]
    found += [name for name in _table_names(node) if isinstance(name, ast.Constant)]
    found.sort(key=lambda name: (getattr(name, "lineno", 0), getattr(name, "col_offset", 0)))
    names = (of.text if (of := sensor_of(one)) else ast.unparse(one) for one in found)
    return tuple(dict.fromkeys(name for name in names if name and name != "pi"))


def _table_names(node: ast.AST) -> list[ast.expr]:
    """Return the nodes of a tree, checked or not, that name tables."""
    found = (inner.args[1] for inner in ast.walk(node) if is_table(inner) and inner.args[1:])
    return [name for name in found if isinstance(name, ast.Constant | ast.Name)]


def table_names(node: ast.AST) -> tuple[str, ...]:
    """Return the names of tables in a tree, checked or not, in the order of the text."""
    found = {*map(ast.unparse, _table_names(node))}
    return tuple(name for name in names_in(node) if name in found)


def is_number(node: ast.AST) -> bool:
    """Whether a part is a finite number without a sign."""
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            try:
                return math.isfinite(value)
            except OverflowError:
                return False
    return False


def is_table(node: ast.AST) -> TypeGuard[ast.Call]:
    """Whether a part is a call of interp."""
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == TABLE


def table_in_call(node: ast.Call) -> InterpolationTable:
    """The parts of a call of interp."""
    match node.args:
        case [argument, ast.List(elts=knots), ast.List(elts=values), *kind]:
            return InterpolationTable(argument, "", _kind(kind), knots, values)
        case [argument, name, *kind]:
            return InterpolationTable(argument, ast.unparse(name), _kind(kind))
    raise AssertionError(f"unchecked node {node!r}")


def _kind(said: Sequence[ast.expr]) -> str:
    """Return the kind of interpolation from the last arguments of interp."""
    return str(said[0].value) if said and isinstance(said[0], ast.Constant) else LINEAR


def find_tables(node: ast.AST) -> Iterator[InterpolationTable]:
    """The tables in a tree."""
    if is_table(node):
        yield table_in_call(node)
    for child, _ in children(node):
        yield from find_tables(child)


def with_kind(node: ast.Call, kind: str) -> ast.Call:
    """Return the call of interp on the same table by another kind of interpolation."""
    numbers = 3 if isinstance(node.args[1], ast.List) else 2
    return ast.Call(node.func, [*node.args[:numbers], ast.Constant(kind)], [])


def constant_value(element: ast.expr) -> float | None:
    """A number of a table; None for one that has a name."""
    if isinstance(element, ast.Name):
        return None
    return float(ast.literal_eval(element))


@lru_cache(maxsize=KEPT)
def sensor_of(node: ast.AST) -> Sensor | None:
    """The sensor that a part names; None for any other part, and for one beside the rod."""
    match node:
        case ast.Call(
            func=ast.Name(id=what), args=[ast.Constant(value=int() | float() as at)], keywords=[]
        ) if what in SENSORS and not isinstance(at, bool):
            there = float(at).is_integer() and at >= 0 if what in OF_STOPS else 0 <= at <= 1
            return Sensor(what, float(at)) if there else None
    return None


def sensors_in(node: ast.AST) -> list[Sensor]:
    """The sensors that a tree names."""
    return list(dict.fromkeys(filter(None, map(sensor_of, ast.walk(node)))))


def signals_in(node: ast.AST, states: Container[str]) -> list[str]:
    """States and sensors that a tree names, in the order of the text."""
    return [name for name in names_in(node) if name in states or "(" in name]
