"""Fewer rows of a curve, with its extremes."""

from __future__ import annotations

import numpy as np

from rodgen.integrate.stepper import Array

MOST_ROWS = 5000


def thinned(rows: Array, most: int = MOST_ROWS) -> Array:
    """At most so many of the rows (M, columns), in their order.

    Half of them are evenly spread, the first and the last among them; the others are the least and
    the greatest value of every column, in as many equal stretches as there is room for.
    """
    if len(rows) <= most:
        return rows
    half = most // 2
    even = np.linspace(0, len(rows) - 1, half).round().astype(np.int64)
    stretches = max(1, half // (2 * rows.shape[1]))
    width = -(-len(rows) // stretches)
    # The last stretch is filled up with its last row.
    index = np.minimum(np.arange(stretches * width), len(rows) - 1).reshape(stretches, width)
    parts = rows[index]
    low = np.where(np.isfinite(parts), parts, np.inf).argmin(axis=1)
    high = np.where(np.isfinite(parts), parts, -np.inf).argmax(axis=1)
    picked = np.take_along_axis(index, np.concatenate((low, high), axis=1), axis=1)
    # Of more columns than there is room for, the first ones.
    chosen = np.unique(np.concatenate((even, picked.ravel()[: most - half])))
    found: Array = rows[chosen]
    return found
