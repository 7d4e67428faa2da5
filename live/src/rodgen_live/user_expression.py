"""Expressions of quantities and of their time derivatives, as a user types them for a plot."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError, did_you_mean
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import FUNCTIONS, TABLE
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
        parts = self.expression, *self.rates.values()
        names = {"t", *(name for one in parts for name in one.signals)} - self.rates.keys()
        if not names <= units.keys():
            return ""
        far = {name: FAR[at] * _factors(units[name]) for at, name in enumerate(sorted(names))}
        for name, one in self.rates.items():
            far[name] = one.evaluate(far["t"], far, PLAIN) / _factors("s")
        found = self.expression.evaluate(far["t"], far, PLAIN) * np.ones_like(far["t"])
        with np.errstate(all="ignore"):
            powers = np.log2(np.abs(found[1:] / found[0]))
        powers = powers[:, np.isfinite(powers).all(axis=0)]
        whole = powers[:, :1].round()
        if not powers.size or not np.allclose(powers, whole, rtol=0.0, atol=1e-6):
            return ""
        spelt = (units[name] for name in names if np.all(_factors(units[name])[1:] == 2.0**whole))
        return min(spelt, default="", key=len) or _format_unit(whole[:, 0])

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


# Units: by what a value is multiplied where the values of kg, m, s or rad double -----------------

KG, M, S, RAD = 1.0 + np.eye(4, 5, 1)  # factors of a value of this unit: 1, then for each doubled
BASES = {"kg": KG, "m": M, "s": S, "rad": RAD}
NAMED = {"N": KG * M / S**2, "J": KG * M**2 / S**2, "W": KG * M**2 / S**3}
HIGH = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
LOW = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
SYMBOL = re.compile(r"([A-Za-z]+)([⁰¹²³⁴⁵⁶⁷⁸⁹]*)")
# Values by name and sample, so far from zero that numbers added to them do not count: these may
# have any unit.
FAR = 1e15 * np.random.default_rng(0).normal(size=(LONGEST, 1, 16))
# Functions for units; the numbers of a table have some that nobody tells.
PLAIN: dict[str, Callable[..., Any]] = {
    **{name: lambda *_, unit=of.unit: _factors(unit) for name, of in FUNCTIONS.items()},
    "abs": np.abs,
    "sqrt": np.sqrt,
    TABLE: lambda *_: np.float64(np.nan),
    **dict.fromkeys(("min", "max"), lambda *parts: sum(parts)),
}


def _factors(unit: str) -> Array:
    """Factors (5, 1) of a value of this unit."""
    found = np.ones(5)
    for sign, part in zip((1, -1), unit.split("/"), strict=False):
        for symbol, power in SYMBOL.findall(part):
            found *= {**BASES, **NAMED}[symbol] ** (sign * int(power.translate(LOW) or 1))
    return found[:, None]


def _format_unit(powers: Array) -> str:
    """Shortest text of a unit, given the exponents of kg, m, s and rad."""
    texts = []
    for head, factors in {"": np.ones(5), **NAMED}.items():
        above, below = [head] * bool(head), list[str]()
        for symbol, power in zip(BASES, powers - np.log2(factors[1:]), strict=True):
            size = f"{abs(power):.0f}".translate(HIGH) if abs(power) > 1 else ""
            (above if power > 0 else below).extend([symbol + size] * bool(power))
        under = f"({' '.join(below)})" if len(below) > 1 else "".join(below)
        texts.append(f"{' '.join(above) or 1}/{under}" if below else " ".join(above))
    return min(texts, key=len)
