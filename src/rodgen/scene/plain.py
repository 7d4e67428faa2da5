"""Values as Python hands them over, made those of a TOML file: tables, lists, numbers, text."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.scene.errors import SceneError

PLAIN = float, int, str  # passed over in lists, which may hold a million of them
DEEPEST = 50  # tables and lists, each in the one before
MOST_KEYS = 10**5  # of all tables together, with what lists hold beside plain values
LONGEST = 2 * 10**6  # values of a list


def plain(value: Any, place: str = "scene") -> Any:
    """A value with the tuples, NumPy arrays and NumPy scalars in it as lists and numbers.

    place: where it stands, for messages. Raises SceneError for an array of what are no numbers,
    and for tables and lists that are larger or deeper than any scene.
    """
    return _Plain(place).made(value, place, 0)


class _Plain:
    """Counts what is in a value on the way through it."""

    def __init__(self, place: str):
        self.place, self.count = place, 0

    def made(self, value: Any, place: str, depth: int) -> Any:
        if isinstance(value, np.ndarray | np.generic):
            return _numbers(value, place)
        if not isinstance(value, dict | list | tuple):
            return value
        if depth > DEEPEST:
            raise SceneError(place, _Shown(value), f"at most {DEEPEST} tables and lists deep")
        if isinstance(value, dict):
            at = "" if place == "scene" else f"{place}."
            self._add(value, len(value))
            return {str(k): self.made(v, f"{at}{k}", depth + 1) for k, v in value.items()}
        if len(value) > LONGEST:
            raise SceneError(place, _Shown(value), f"a list of at most {LONGEST} values")
        self._add(value, sum(type(inner) not in PLAIN for inner in value))
        return [
            inner if type(inner) in PLAIN else self.made(inner, f"{place}[{i}]", depth + 1)
            for i, inner in enumerate(value)
        ]

    def _add(self, value: Any, count: int) -> None:
        self.count += count
        if self.count > MOST_KEYS:
            raise SceneError(self.place, _Shown(value), f"at most {MOST_KEYS} keys and values")


class _Shown:
    """What is too large to be shown, by its type."""

    def __init__(self, value: Any):
        self.kind = type(value).__name__

    def __repr__(self) -> str:
        return f"({self.kind})"


def _numbers(array: NDArray[Any] | np.generic, place: str) -> Any:
    """A number of a scalar or an array without dimensions, else lists of numbers."""
    if array.size > LONGEST:
        raise SceneError(place, _Shown(array), f"at most {LONGEST} numbers")
    if array.dtype.kind == "f":
        return array.astype(float).tolist()  # of a long double, too
    # Booleans are refused where they stand, as those of a file are; text of a name stays text.
    if array.dtype.kind in "iub" or (array.dtype.kind == "U" and not array.ndim):
        return array.tolist()
    raise SceneError(place, array, f"real numbers (not an array of {array.dtype})")
