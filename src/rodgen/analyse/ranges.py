"""Checks of bounds, pairs (low, high) of numbers."""

from __future__ import annotations

from rodgen.errors import InputError
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.scene.tables import LARGEST

Bounds = tuple[float, float]
OpenBounds = tuple[float | None, float | None]


def check_bounds(given: object, field: str = "bounds") -> Bounds:
    """Check bounds and return them. Raises InputError unless they are two finite numbers."""
    low, high = _check_ends(given, field, "(a, b), two finite numbers")
    if low is None or high is None:
        raise InputError(field, given, "(a, b), two finite numbers")
    return float(low), float(high)


def check_open_bounds(given: object, field: str = "bounds") -> OpenBounds:
    """Check bounds of which each may be None, and return them. Raises InputError for others."""
    return _check_ends(given, field, "(a, b), each None or a finite number")


def _check_ends(given: object, field: str, allowed: str) -> OpenBounds:
    ends = to_plain(given, field)
    if not (isinstance(ends, list) and len(ends) == 2 and all(map(_can_be_end, ends))):
        raise InputError(field, given, f"{allowed}, at most {LARGEST:g} in size")
    return ends[0], ends[1]


def _can_be_end(value: object) -> bool:
    return value is None or (is_number(value) and abs(value) <= LARGEST)
