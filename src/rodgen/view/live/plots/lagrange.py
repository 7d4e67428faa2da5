"""The polynomial through a few neighbouring samples, and where it reaches a value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from rodgen.integrate.stepper import Array

Values = TypeVar("Values", float, Array)
HALVINGS = 60  # more than a double has bits


def lagrange(t: Sequence[Values], values: Sequence[Values], at: Values) -> Values:
    """Value at a time of the polynomial through samples (in Newton's form, by divided
    differences); of numbers, or of arrays (N,), of which each entry has its own samples. Of n
    samples h apart, the error is of the power n of h."""
    slopes = list(values)
    for order in range(1, len(slopes)):
        for i in range(len(slopes) - 1, order - 1, -1):
            slopes[i] = (slopes[i] - slopes[i - 1]) / (t[i] - t[i - order])
    found = slopes[-1]
    for i in range(len(slopes) - 2, -1, -1):
        found = found * (at - t[i]) + slopes[i]
    return found


def evened(t: Array, values: Array, times: Array) -> Array:
    """Values at other times by the cubic through the four samples around each; t (T,) rising,
    values (T,), T at least 4, times (N,) within those of t."""
    first = np.clip(np.searchsorted(t, times, side="right") - 2, 0, len(t) - 4)
    four = [first + i for i in range(4)]
    return lagrange([t[i] for i in four], [values[i] for i in four], times)


def reached(
    t: Sequence[float], values: Sequence[float], level: float, low: int, high: int
) -> float:
    """Time between two of the samples, by their numbers, at which the polynomial through all of
    them reaches a level, by halving; these two are on either side of the level, or at it."""
    below, above = t[low], t[high]
    rises = values[low] < values[high]
    for _ in range(HALVINGS):
        middle = (below + above) / 2
        if (lagrange(t, values, middle) < level) == rises:
            below = middle
        else:
            above = middle
    return above
