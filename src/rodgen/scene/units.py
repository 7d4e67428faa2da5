"""Units other than SI, in which the tables of a scene may be given: `units = {length = "mm"}`.

They are those of the table and of all within it. Numbers are converted as a scene is made, which
has SI units from there on; an expression is multiplied by the factor of its value. What has a time
in its unit, densities and coefficients of drag are in SI units always: who draws in millimetres has
speeds in m/s all the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from decimal import Decimal
from functools import cache
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rodgen.errors import InputError, did_you_mean

UNITS = "units"  # the key of a table
DEGREE = "0.01745329251994329576923690768"  # pi/180, with the digits of Decimal
FEET = {"in": "0.0254", "ft": "0.3048"}
# By kind of quantity: its SI unit, and others by their names, in that.
KINDS: dict[str, tuple[str, dict[str, Decimal]]] = {
    kind: (si, {name: Decimal(size) for name, size in known.items()})
    for kind, (si, known) in {
        "length": ("m", {"m": "1", "mm": "1e-3", "cm": "1e-2", "km": "1e3"} | FEET),
        "mass": ("kg", {"kg": "1", "g": "1e-3", "t": "1e3", "lb": "0.45359237"}),
        "force": (
            "N",
            {"N": "1", "mN": "1e-3", "kN": "1e3", "MN": "1e6", "lbf": "4.4482216152605"},
        ),
        "angle": ("rad", {"rad": "1", "deg": DEGREE}),
    }.items()
}
ALWAYS_SI = {"kg/m^3", "kg/m^2"}
PART = re.compile(r"(kg|rad|[mNsJW1])(?:\^(\d))?")
BRACKET = re.compile(r"\[([^\]`]*)\]")
# Words that are no expressions, and keys whose expressions are in numbers of the module.
WORDS, OF_MODULE = ("rest", "isa"), ("spring",)
NAMED = "states", "tables", "parameters", "numbers"  # tables whose keys are names of a user

UnitNames = Mapping[str, str]


def to_si(tables: dict[str, Any], model: type[BaseModel]) -> dict[str, Any]:
    """Convert the tables of a scene, or of a table of it, to SI units; model: of them.

    Raises InputError for units that are unknown.
    """
    if not has_units(tables):
        return tables
    return _convert(tables, model, {}, "")


def has_units(value: Any) -> bool:
    """Whether tables, or lists of them, have units of their own."""
    if isinstance(value, dict):
        inner = (of for key, of in value.items() if key not in NAMED)
        return isinstance(value.get(UNITS), dict | str) or any(map(has_units, inner))
    return isinstance(value, list) and any(has_units(one) for one in value if type(one) is dict)


def _convert(
    table: dict[str, Any], model: type[BaseModel], outer: UnitNames, place: str
) -> dict[str, Any]:
    """Convert a table; outer: units of the table that it is in."""
    units = {**outer, **_check_units(table.get(UNITS, {}), f"{place}{UNITS}")}
    if "exponent" in table and units.get("length", "m") != "m":
        allowed = "absent in other units of length: that of the stiffness depends on it"
        raise InputError(f"{place}exponent", table["exponent"], allowed)
    made = {}
    for key, value in table.items():
        field = model.model_fields.get(key)
        if key == UNITS:
            continue
        inner = None if field is None else _table_of(field)
        if inner is not None:
            made[key] = _convert_inner(value, inner, units, f"{place}{key}")
        elif field is not None and key not in OF_MODULE:
            made[key] = _scale(value, _units_of(model, key), units, f"{place}{key}")
        else:
            made[key] = value
    return made


def _convert_inner(value: Any, model: type[BaseModel], units: UnitNames, place: str) -> Any:
    if place in NAMED:
        return value
    if isinstance(value, dict):
        return _convert(value, model, units, f"{place}.")
    if isinstance(value, list):
        return [
            _convert(one, model, units, f"{place}[{at}].") if isinstance(one, dict) else one
            for at, one in enumerate(value)
        ]
    return value


def _check_units(given: Any, field: str) -> dict[str, str]:
    """Check units. Raises InputError."""
    if not isinstance(given, dict):
        raise InputError(field, given, 'a table such as {length = "mm", mass = "g"}')
    for kind, unit in given.items():
        if kind not in KINDS:
            allowed = f"a table of {', '.join(KINDS)}{did_you_mean(kind, KINDS)}"
            raise InputError(f"{field}.{kind}", unit, allowed)
        known = KINDS[kind][1]
        if unit not in known:
            raise InputError(f"{field}.{kind}", unit, f"one of {', '.join(known)}")
    return given


def _parts(kind: Any) -> Iterator[Any]:
    yield kind
    for one in get_args(kind):
        yield from _parts(one)


@cache
def _table_of_annotation(annotation: Any) -> type[BaseModel] | None:
    kinds = (kind for kind in _parts(annotation) if isinstance(kind, type))
    return next((kind for kind in kinds if issubclass(kind, BaseModel)), None)


def _table_of(field: FieldInfo) -> type[BaseModel] | None:
    """Class of the tables of a key; None of one that has values."""
    annotation: Any = field.annotation
    return _table_of_annotation(annotation)


@cache
def _units_of(model: type[BaseModel], key: str) -> tuple[str, ...]:
    """SI units of a key: of its row in the vocabulary, or those in its description."""
    rows = getattr(model, "term", None)
    for one in rows.parameters if rows else ():
        if one.key == key:
            return (one.unit,) if one.unit else ()
    found = BRACKET.findall(str(model.model_fields[key].description))
    return tuple(unit for unit in found if _powers(unit) is not None)


@cache
def _powers(unit: str) -> tuple[tuple[str, int], ...] | None:
    """Powers of the parts of a unit, such as N m^2 or kg/(m s); None of what is none."""
    above, _, below = unit.partition("/")
    powers = []
    for text, sign in ((above, 1), (below.strip("()"), -1)):
        for part in text.split():
            found = PART.fullmatch(part)
            if found is None:
                return None
            powers.append((found[1], sign * int(found[2] or 1)))
    return tuple(powers) or None


def _factor(unit: str, units: UnitNames) -> Decimal:
    """Factor from the chosen units of a quantity to its SI unit."""
    of_si = {base for base, _ in KINDS.values()} | {"1"}
    of_base = {base: known[units[kind]] for kind, (base, known) in KINDS.items() if kind in units}
    made, powers = Decimal(1), _powers(unit) or ()
    if unit in ALWAYS_SI or any(base not in of_si for base, _ in powers):
        return made
    for base, power in powers:
        made *= of_base.get(base, Decimal(1)) ** power
    return made


def _scale(value: Any, si: tuple[str, ...], units: UnitNames, field: str) -> Any:
    """Convert a value; of pairs that have units of their own, both."""
    factors = [_factor(unit, units) for unit in si]
    if not factors or all(one == 1 for one in factors):
        return value
    if isinstance(value, list) and len(factors) > 1 and any(isinstance(v, list) for v in value):
        return [[_times(x, by, field) for x, by in zip(v, factors, strict=False)] for v in value]
    if isinstance(value, list):
        return [_times(one, factors[0], field) for one in value]
    return _times(value, factors[0], field)


def _times(value: Any, by: Decimal, field: str) -> Any:
    """Multiply a number, or an expression; anything else is left to be refused."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(Decimal(repr(value)) * by)
        except (ArithmeticError, OverflowError):
            return value
    if not isinstance(value, str) or value in WORDS:
        return value
    if by == KINDS["angle"][1]["deg"] and "deg(" in value:
        raise InputError(field, value, 'without deg(), beside units.angle = "deg"')
    return f"({value})*{float(by)!r}"  # behind it, so that its own numbers keep their places
