"""Names of numbers in expressions: those of a module, and which of others a user may give."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable

from rodgen.errors import InputError
from rodgen.model.parameter import ANY, ROWS, Parameter
from rodgen.model.quantities import QUANTITIES, parse_number
from rodgen.model.rod import MASS_PER_LENGTH
from rodgen.model.terms import PARAMETERS, TERMS
from rodgen.scene.grammar import FUNCTIONS, TABLE

LONGEST = 64  # characters
NAME = re.compile(rf"[A-Za-z][A-Za-z0-9_]{{0,{LONGEST - 1}}}")
# Names with a meaning in generated modules, and the variables of expressions.
TAKEN = {"t", "s", "d", "k", "p", "y", "np", "math", "fins", "N", "pi", TABLE, *FUNCTIONS}
# A number of an expression without a name, or a table.
MADE = re.compile(r"(.+?)_(?:knot_|value_|table_)?\d+")
OF_LOADS = ("work_", "power_", "force_")  # before the name of a load, its quantities
SENSORS = re.compile(r"(phi|omega|x|y|vx|vy)(_?\d+)?")


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
    """Name in a module of the mass of a body that changes with time, or for an empty name of that
    of the links."""
    return f"body_{body}_mass" if body else MASS_PER_LENGTH.name


def number_parameter(name: str, rule: str = ANY) -> Parameter:
    """Module parameter for a number of an expression."""
    what = "a number in an expression" + " of t" * (rule == ANY)
    return Parameter(name, name, name, "", "", what, rule=rule)


def table_parameter(name: str) -> Parameter:
    """Module parameter for a table of an expression."""
    what = "knots of a table in an expression, which ascend, and then a value for each"
    return Parameter(name, name, name, "", "", what, each=ROWS)


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
