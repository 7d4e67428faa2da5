"""Values as Python hands them over, made those of a TOML file: tables, lists, numbers, text."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.scene.errors import SceneError

PLAIN = float, int, str  # passed over in lists, which may hold a million of them


def plain(value: Any, place: str = "scene") -> Any:
    """A value with the tuples, NumPy arrays and NumPy scalars in it as lists and numbers.

    place: where it stands, for messages. Raises SceneError for an array of what are no numbers.
    """
    if isinstance(value, np.ndarray | np.generic):
        return _numbers(value, place)
    if isinstance(value, dict):
        at = "" if place == "scene" else f"{place}."
        return {str(key): plain(inner, f"{at}{key}") for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [
            inner if type(inner) in PLAIN else plain(inner, f"{place}[{i}]")
            for i, inner in enumerate(value)
        ]
    return value


def _numbers(array: NDArray[Any] | np.generic, place: str) -> Any:
    """A number of a scalar or an array without dimensions, else lists of numbers."""
    if array.dtype.kind == "f":
        return array.astype(float).tolist()  # of a long double, too
    # Booleans are refused where they stand, as those of a file are; text of a name stays text.
    if array.dtype.kind in "iub" or (array.dtype.kind == "U" and not array.ndim):
        return array.tolist()
    raise SceneError(place, array, f"real numbers (not an array of {array.dtype})")
