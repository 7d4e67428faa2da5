"""The [tables] of a scene, which expressions read: interp(t, 'thrust.csv')."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import PlainSerializer, PlainValidator

from rodgen.errors import InputError
from rodgen.scene.grammar import TableData
from rodgen.scene.tables import LARGEST

MOST_ROWS = 200_000  # of all tables
KNOTS, VALUES = "knots", "values"
LookupTable = Annotated[
    TableData,
    PlainValidator(lambda given: given),  # which parse_table has made, with its name in errors
    PlainSerializer(lambda table: to_lists(table), when_used="json"),
]


def to_lists(table: TableData) -> dict[str, list[float]]:
    """Convert a table to the lists that a file has."""
    return {KNOTS: table.knots.tolist(), VALUES: table.values.tolist()}


def parse_table(name: str, given: Any) -> TableData:
    """Make the table of a name from its lists in a file. Raises InputError."""
    if isinstance(given, TableData):
        return given
    field = f"tables.{name}"
    if not isinstance(given, Mapping) or given.keys() != {KNOTS, VALUES}:
        raise InputError(field, given, f"a table of {KNOTS} and {VALUES}")
    knots, values = (_parse_numbers(f"{field}.{key}", given[key]) for key in (KNOTS, VALUES))
    if not 2 <= len(knots) <= MOST_ROWS:
        raise InputError(f"{field}.{KNOTS}", len(knots), f"2 to {MOST_ROWS} numbers")
    if len(values) != len(knots):
        allowed = f"{len(knots)} numbers, one for every knot"
        raise InputError(f"{field}.{VALUES}", len(values), allowed)
    falls = np.flatnonzero(np.diff(knots) <= 0)
    if len(falls):
        before, after = knots[falls[0] : falls[0] + 2].tolist()
        raise InputError(f"{field}.{KNOTS}", after, f"above {before:g}, the knot before it")
    return TableData(knots, values)


def _parse_numbers(field: str, given: Any) -> NDArray[np.float64]:
    """Convert a list of finite numbers to an array. Raises InputError."""
    if not isinstance(given, list) or not set(map(type, given)) <= {int, float}:
        raise InputError(field, given, "a list of numbers")
    try:
        found = np.array(given, dtype=float)
    except OverflowError:  # of a whole number of hundreds of digits
        found = np.array([one if abs(one) <= LARGEST else np.inf for one in given], dtype=float)
    wrong = ~(np.abs(found) <= LARGEST)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise InputError(f"{field}[{at}]", given[at], f"a number from {-LARGEST:g} to {LARGEST:g}")
    return found
