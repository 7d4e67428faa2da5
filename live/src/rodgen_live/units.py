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
    """Unit of an expression in the grammar of scenes, empty for a plain number; None where none
    follows, as where unlike units are added. units: of its names, as far as known."""
    tree = parse(text, "expression")
    known = {name: _parse_unit(unit) for name, unit in units.items()}
    found = None if tree is None else _unit(tree, known)
    return None if found is None else _format_unit(found)


def rate_of(unit: str) -> str:
    """Unit of the time derivative of a quantity, from its unit."""
    return _format_unit(_multiply(_parse_unit(unit), {"s": 1}, -1))


def _unit(node: ast.expr, units: Mapping[str, Powers]) -> Powers | None:
    """Unit of a part of an expression; None where it is not known."""

    def part_unit(part: ast.expr) -> Powers | None:
        return _unit(part, units)

    match node:
        case ast.Constant() | ast.Name(id="pi"):
            return {}
        case ast.Name(id=name):
            return units.get(name)
        case ast.UnaryOp(operand=part):
            return part_unit(part)
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
            return _common_unit((left, right), units)
        case ast.BinOp(left=base, op=ast.Pow(), right=power):
            return _power(part_unit(base), power)
        case ast.BinOp(left=left, op=op, right=right):
            if (first := part_unit(left)) is None or (second := part_unit(right)) is None:
                return None
            return _multiply(first, second, 1 if isinstance(op, ast.Mult) else -1)
        case ast.IfExp(body=body, orelse=other):
            return _common_unit((body, other), units)
        case ast.Call(func=ast.Name(id=name), args=parts) if name in ALIKE:
            return _common_unit(parts, units)
        case ast.Call(func=ast.Name(id="sqrt"), args=[part]):
            found = part_unit(part)
            if found is None or any(power % 2 for power in found.values()):
                return None
            return {key: power // 2 for key, power in found.items()}
        case ast.Call(func=ast.Name(id="interp")):
            return None
    return {}


def _common_unit(parts: Iterable[ast.expr], units: Mapping[str, Powers]) -> Powers | None:
    """Unit that all parts share, plain numbers aside, which may have any; None for unlike ones."""
    found = [_unit(part, units) for part in parts if set(names_in(part)) - {"pi"}]
    known = [one for one in found if one is not None]
    alike = len(known) == len(found) and all(
        _base_units(one) == _base_units(known[0]) for one in known
    )
    return (known or [{}])[0] if alike else None


def _power(base: Powers | None, power: ast.expr) -> Powers | None:
    if not base:
        return base
    match power:
        case ast.Constant(value=int(times)):
            return {key: times * of for key, of in base.items() if times}
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int(times))):
            return {key: -times * of for key, of in base.items() if times}
    return None


def _multiply(first: Powers, second: Powers, sign: int) -> Powers:
    powers = {key: first.get(key, 0) + sign * second.get(key, 0) for key in {**first, **second}}
    return {key: power for key, power in powers.items() if power}


def _base_units(powers: Powers) -> Powers:
    found: Powers = {}
    for symbol, power in powers.items():
        stands = _parse_unit(MEANT[symbol]) if symbol in MEANT else {symbol: 1}
        found = _multiply(found, {key: times * power for key, times in stands.items()}, 1)
    return found


def _parse_unit(unit: str) -> Powers:
    above, _, below = unit.partition("/")
    found: Powers = {}
    for text, sign in ((above, 1), (below, -1)):
        for symbol, power in SYMBOL.findall(text):
            found = _multiply(found, {symbol: int(power.translate(LOW) or 1)}, sign)
    return found


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
