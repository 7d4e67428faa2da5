"""Ranges of a number, given by their ends."""

from __future__ import annotations

from rodgen.errors import InputError
from rodgen.scene.plain import is_number, plain
from rodgen.scene.tables import LARGEST

Bounds = tuple[float, float]
OpenBounds = tuple[float | None, float | None]


def bounds_of(given: object, field: str = "bounds") -> Bounds:
    """Return both ends of a range. Raises InputError for what are not two finite numbers."""
    low, high = _ends(given, field, "(a, b), two finite numbers")
    if low is None or high is None:
        raise InputError(field, given, "(a, b), two finite numbers")
    return float(low), float(high)


def open_bounds_of(given: object, field: str = "bounds") -> OpenBounds:
    """Return both ends of a range, of which each may be None. Raises InputError for others."""
    return _ends(given, field, "(a, b), each None or a finite number")


def _ends(given: object, field: str, allowed: str) -> OpenBounds:
    ends = plain(given, field)
    if not (isinstance(ends, list) and len(ends) == 2 and all(map(_can_be_end, ends))):
        raise InputError(field, given, f"{allowed}, at most {LARGEST:g} in size")
    return ends[0], ends[1]


def _can_be_end(value: object) -> bool:
    return value is None or (is_number(value) and abs(value) <= LARGEST)
