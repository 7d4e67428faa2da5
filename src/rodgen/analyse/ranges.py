"""Checks of numbers that users give, and of bounds, pairs (low, high) of them."""

from __future__ import annotations

import math
import sys

from rodgen.errors import InputError
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.scene.tables import LARGEST

Bounds = tuple[float, float]
OpenBounds = tuple[float | None, float | None]


def check_whole_number(
    given: object, field: str, low: int, high: float = math.inf, allowed: str = ""
) -> int:
    """Check a whole number from low to high, and return it. allowed: what the message says, by
    default the range. Raises InputError for anything else."""
    number = to_plain(given, field)
    if isinstance(number, int) and not isinstance(number, bool) and low <= number <= high:
        return number
    ends = f"of at least {low}" if high == math.inf else f"from {low} to {high}"
    raise InputError(field, given, allowed or f"a whole number {ends}")


def check_positive(
    given: object, field: str, allowed: str, most: float = sys.float_info.max
) -> float:
    """Check a number above 0 and up to the most, and return it. allowed: what the message says.
    Raises InputError for anything else."""
    number = to_plain(given, field)
    if is_number(number) and 0 < number <= most:
        return float(number)
    raise InputError(field, given, allowed)


def check_inside(given: object, field: str, bounds: Bounds, more: str = "") -> float:
    """Check a number within bounds, in any order, and return it. more: for the message. Raises
    InputError for anything else."""
    number, (low, high) = to_plain(given, field), sorted(bounds)
    if is_number(number) and low <= number <= high:
        return float(number)
    raise InputError(field, given, f"a number in the range, {low:g} to {high:g}{more}")


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
