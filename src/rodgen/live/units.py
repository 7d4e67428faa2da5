"""Units of expressions of quantities, as far as they follow from those of the quantities."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping

from rodgen.scene.grammar import names_in, parse

Powers = dict[str, int]  # of symbols, such as {"m": 1, "s": -2}
# What symbols stand for, by which units with unlike symbols are told to be alike.
MEANT = {"J": "kg m²/s²", "N": "kg m/s²", "W": "kg m²/s³", "rad": ""}
HIGH = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
LOW = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
SYMBOL = re.compile(r"([A-Za-z]+)([⁰¹²³⁴⁵⁶⁷⁸⁹]*)")
ALIKE = "abs", "min", "max"  # functions whose value is of the kind of what they are given


def unit_of(text: str, units: Mapping[str, str]) -> str | None:
    """The unit of an expression in the grammar of scenes, empty for a plain number; None where none
    follows, as where unlike units are added. units: of what it names, as far as they are known."""
    tree = parse(text, "expression")
    known = {name: _read(unit) for name, unit in units.items()}
    found = None if tree is None else _unit(tree, known)
    return None if found is None else _written(found)


def rate_of(unit: str) -> str:
    """The unit of the derivative by time of what has a unit."""
    return _written(_times(_read(unit), {"s": 1}, -1))


def _unit(node: ast.expr, units: Mapping[str, Powers]) -> Powers | None:
    """Of a part of an expression; None: it is not known."""

    def of(part: ast.expr) -> Powers | None:
        return _unit(part, units)

    match node:
        case ast.Constant() | ast.Name(id="pi"):
            return {}
        case ast.Name(id=name):
            return units.get(name)
        case ast.UnaryOp(operand=part):
            return of(part)
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
            return _common((left, right), units)
        case ast.BinOp(left=base, op=ast.Pow(), right=power):
            return _raised(of(base), power)
        case ast.BinOp(left=left, op=op, right=right):
            if (first := of(left)) is None or (second := of(right)) is None:
                return None
            return _times(first, second, 1 if isinstance(op, ast.Mult) else -1)
        case ast.IfExp(body=body, orelse=other):
            return _common((body, other), units)
        case ast.Call(func=ast.Name(id=name), args=parts) if name in ALIKE:
            return _common(parts, units)
        case ast.Call(func=ast.Name(id="sqrt"), args=[part]):
            found = of(part)
            if found is None or any(power % 2 for power in found.values()):
                return None
            return {key: power // 2 for key, power in found.items()}
        case ast.Call(func=ast.Name(id="interp")):
            return None
    return {}


def _common(parts: Iterable[ast.expr], units: Mapping[str, Powers]) -> Powers | None:
    """The unit that all parts have, but for plain numbers, which may have any."""
    found = [_unit(part, units) for part in parts if set(names_in(part)) - {"pi"}]
    known = [one for one in found if one is not None]
    alike = len(known) == len(found) and all(_meant(one) == _meant(known[0]) for one in known)
    return (known or [{}])[0] if alike else None


def _raised(base: Powers | None, power: ast.expr) -> Powers | None:
    if not base:
        return base
    match power:
        case ast.Constant(value=int(times)):
            return {key: times * of for key, of in base.items() if times}
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int(times))):
            return {key: -times * of for key, of in base.items() if times}
    return None


def _times(first: Powers, second: Powers, sign: int) -> Powers:
    powers = {key: first.get(key, 0) + sign * second.get(key, 0) for key in {**first, **second}}
    return {key: power for key, power in powers.items() if power}


def _meant(powers: Powers) -> Powers:
    found: Powers = {}
    for symbol, power in powers.items():
        stands = _read(MEANT[symbol]) if symbol in MEANT else {symbol: 1}
        found = _times(found, {key: times * power for key, times in stands.items()}, 1)
    return found


def _read(unit: str) -> Powers:
    above, _, below = unit.partition("/")
    found: Powers = {}
    for text, sign in ((above, 1), (below, -1)):
        for symbol, power in SYMBOL.findall(text):
            found = _times(found, {symbol: int(power.translate(LOW) or 1)}, sign)
    return found


def _written(powers: Powers) -> str:
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
