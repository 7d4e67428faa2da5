"""Expressions of quantities and of their time derivatives, as a user types them for a plot."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError, did_you_mean
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import FUNCTIONS, TABLE, names_in, parse
from rodgen_live.sample_store import Chunk

LONGEST = 200  # letters
TURN = 1e-5  # rad or m by which the state moves in a difference: errors are its square
RATE = re.compile(r"\bd\s*/\s*dt\b\s*")
NAME = re.compile(r"[^\W\d]\w*")
ALONE = re.compile(r"[^\W\d]\w*\b(?!\s*\.)")  # not np of np.sin
EXAMPLES = ("tip_x", "kinetic_energy")
WORDS = {"if", "else", "pi", TABLE, *FUNCTIONS}
# What does not follow from the state alone: its rate is not told by where the state goes.
PATHS = re.compile(r"work_\w+|energy_balance|total_work")

Columns = Callable[[Sequence[str], Chunk], Array]  # of quantities at samples, (K, names)


@dataclass(frozen=True)
class UserExpression:
    """An expression as a quantity; rates: its parts under d/dt, by names that stand for them."""

    expression: Expression
    rates: Mapping[str, Expression]

    @classmethod
    def parse(cls, text: str, known: Set[str], field: str) -> UserExpression:
        """Parse a text in the grammar of scenes, over quantities, t, numbers, and d/dt before
        brackets or a name. Raises InputError."""
        if len(text) > LONGEST:
            raise InputError(field, text, f"at most {LONGEST} letters")
        outer, inner = _split_rates(text, field)
        rates = {name: _parse_part(one, known, text, field) for name, one in inner.items()}
        for one in rates.values():
            if paths := [name for name in one.signals if PATHS.fullmatch(name)]:
                what = f"without {paths[0]} under d/dt: the rate of work is a power"
                raise InputError(field, text, what)
        return cls(_parse_part(outer, known | rates.keys(), text, field), rates)

    def unit(self, units: Mapping[str, str]) -> str:
        """Unit that follows from those of the quantities, given by name; empty where there is none,
        or none is known, as where unlike units are added."""
        known = {name: _parse_unit(unit) for name, unit in units.items()}
        with suppress(KeyError, ValueError):
            for name, one in self.rates.items():
                known[name] = _multiply(_unit(parse(one.text, name), known), {"s": 1}, -1)
            return _format_unit(_unit(parse(self.expression.text, "expression"), known))
        return ""

    def values(self, model: ModuleType, columns: Columns, chunk: Chunk) -> Array:
        """Values at the samples of a chunk, (K,)."""
        rates = self._rates(model, columns, chunk) if self.rates else {}
        return _evaluate(self.expression, columns, chunk, rates)

    def _rates(self, model: ModuleType, columns: Columns, chunk: Chunk) -> dict[str, Array]:
        """Time derivatives, by central differences along the motion at every sample."""
        moves = np.array([model.rhs(t, y, chunk.p) for t, y in zip(chunk.t, chunk.y, strict=True)])
        fastest = np.abs(moves.reshape(len(chunk), -1)).max(axis=1, initial=0.0)
        h = TURN / np.maximum(fastest, 1.0)
        sides = [
            replace(chunk, t=chunk.t + step, y=chunk.y + step[:, None] * moves) for step in (h, -h)
        ]
        found = {}
        for name, one in self.rates.items():
            up, down = (_evaluate(one, columns, side, {}) for side in sides)
            found[name] = (up - down) / (2 * h)
        return found


def _split_rates(text: str, field: str) -> tuple[str, dict[str, str]]:
    """Put a name in place of every d/dt: the text with these names, and what each differentiates.
    Raises InputError."""
    outer, inner = text.strip(), dict[str, str]()
    while found := RATE.search(outer):
        rest = outer[found.end() :]
        size = _bracket_length(rest) or (named.end() if (named := NAME.match(rest)) else 0)
        if not size or RATE.search(rest[:size]):
            raise InputError(field, text, "d/dt before brackets or a name, without d/dt in these")
        name = f"rate_{len(inner)}_of"
        inner[name] = rest[:size]
        outer = f"{outer[: found.start()]}{name}{rest[size:]}"
    return outer, inner


def _bracket_length(text: str) -> int:
    """Length of the bracket that a text begins with; 0 where there is none."""
    depth = 0
    for at, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if not depth:
            return at + 1 if at else 0
    return 0


def _parse_part(part: str, known: Set[str], text: str, field: str) -> Expression:
    """Parse a part of a text over the known names. Raises InputError that quotes the text."""
    here = tuple(name for name in dict.fromkeys(NAME.findall(part)) if name in known - {"t"})
    try:
        found = Expression(part, "t", field, states=here)
    except InputError as error:
        words = ALONE.findall(part)
        unknown = next((word for word in words if word not in known and word not in WORDS), None)
        if unknown is None:
            raise InputError(field, text, error.allowed) from None
        few = ", ".join(name for name in EXAMPLES if name in known)
        allowed = f"an expression of t and quantities such as {few} (not {unknown})"
        raise InputError(field, text, allowed + did_you_mean(unknown, known)) from None
    if found.sensors:
        raise InputError(field, text, "without sensors: quantities have names, such as phi_0")
    return found


def _evaluate(of: Expression, columns: Columns, chunk: Chunk, rates: Mapping[str, Array]) -> Array:
    """Evaluate an expression at the samples of a chunk, (K,); rates: values that are known."""
    names = [name for name in of.signals if name not in rates]
    values = columns(names, chunk) if names else np.empty((len(chunk), 0))
    found = of.evaluate(chunk.t, {**dict(zip(names, values.T, strict=True)), **rates})
    return np.array(np.broadcast_to(found, chunk.t.shape), dtype=float)


# Units, as far as they follow from those of the quantities --------------------------------------

Powers = dict[str, int]  # of symbols, such as {"m": 1, "s": -2}
# Any numbers, as many times as large for symbols that stand for others: 1 J = 1 N m.
SIZES = {"kg": 2.0, "m": 3.0, "s": 5.0, "rad": 1.0, "N": 6 / 25, "J": 18 / 25, "W": 18 / 125}
HIGH = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
LOW = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
SYMBOL = re.compile(r"([A-Za-z]+)([⁰¹²³⁴⁵⁶⁷⁸⁹]*)")


def _unit(node: ast.AST | None, units: Mapping[str, Powers]) -> Powers:
    """Unit of an expression. Raises KeyError or ValueError where none follows."""
    match node:
        case ast.Name(id=name) if name != "pi":
            return units[name]
        case ast.UnaryOp(operand=part):
            return _unit(part, units)
        case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as op, right=right):
            sign = 1 if isinstance(op, ast.Mult) else -1
            return _multiply(_unit(left, units), _unit(right, units), sign)
        case ast.BinOp(left=base, op=ast.Pow(), right=power):
            return _raised(_unit(base, units), ast.literal_eval(power))
        case ast.Call(func=ast.Name(id="sqrt"), args=[part]):
            return _raised(_unit(part, units), 0.5)
        case ast.BinOp(left=one, right=other) | ast.IfExp(body=one, orelse=other):
            return _common_unit((one, other), units)
        case ast.Call(func=ast.Name(id="abs" | "min" | "max"), args=parts):
            return _common_unit(parts, units)
        case ast.Call(func=ast.Name(id="interp")):
            raise ValueError
    return {}


def _common_unit(parts: Iterable[ast.expr], units: Mapping[str, Powers]) -> Powers:
    """Unit that all parts share, plain numbers aside, which may have any."""
    found = [_unit(part, units) for part in parts if set(names_in(part)) - {"pi"}] or [{}]
    sizes = [math.prod(SIZES[key] ** power for key, power in one.items()) for one in found]
    if not np.allclose(sizes, sizes[0], rtol=1e-9):
        raise ValueError
    return found[0]


def _raised(unit: Powers, power: float) -> Powers:
    if any(power * of % 1 for of in unit.values()):
        raise ValueError
    return {key: int(power * of) for key, of in unit.items() if power}


def _multiply(first: Powers, second: Powers, sign: int) -> Powers:
    powers = {key: first.get(key, 0) + sign * second.get(key, 0) for key in {**first, **second}}
    return {key: power for key, power in powers.items() if power}


def _parse_unit(unit: str) -> Powers:
    above, below = (
        {symbol: int(power.translate(LOW) or 1) for symbol, power in SYMBOL.findall(part)}
        for part in f"{unit}/".split("/")[:2]
    )
    return _multiply(above, below, -1)


def _format_unit(powers: Powers) -> str:
    def product(sign: int) -> str:
        return " ".join(
            symbol + (str(abs(power)).translate(HIGH) if abs(power) > 1 else "")
            for symbol, power in powers.items()
            if sign * power > 0
        )

    above, below = product(1), product(-1)
    if not below:
        return above
    return f"{above or 1}/({below})" if " " in below else f"{above or 1}/{below}"
