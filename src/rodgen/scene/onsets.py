"""Times at which a load wakes up after a long rest, which steps that grew meanwhile would miss.

A method with error control sees a load at its stages alone. While nothing happens its steps grow
tenfold, and one of them may reach across a whole pulse: the run would be smooth, and wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

SAMPLES = 100_001  # over a span: a pulse that is shorter than the time between two is not seen
QUIET = 1e-3  # share of its range that counts as a change
REST = 50  # samples in which a load that is at rest changes by less than that
FELT = 10  # times that change, from which on a pulse is one


@lru_cache(maxsize=64)
def onsets(
    value: Callable[[Any], Any], start: float, end: float
) -> tuple[tuple[float, float, float], ...]:
    """Begin, peak and end of every pulse that is shorter than the rest before it, ascending.

    value: of a load at times (...,), hashable.
    """
    grid = np.linspace(start, end, SAMPLES)
    values = np.nan_to_num(np.broadcast_to(value(grid), grid.shape), posinf=0.0, neginf=0.0)
    level = QUIET * np.ptp(values)
    if not 0 < level < np.inf:
        return ()
    found, rests_since = [], 0
    levels = np.round((values - values[0]) / level)
    for first, last in _changes(levels):
        change = np.abs(levels[first : last + 1] - levels[first])
        if change.max() >= FELT and last - first <= first - rests_since:
            peak = first + int(np.argmax(change))
            found.append((float(grid[first]), float(grid[peak]), float(grid[last])))
        rests_since = last
    return tuple(found)


def _changes(levels: NDArray[np.float64]) -> Iterator[tuple[int, int]]:
    """First and last sample of every time in which levels follow each other fast."""
    jumps = np.diff(levels)
    lengths = np.diff(np.concatenate(([0], np.flatnonzero(jumps) + 1, [len(levels)])))
    calm = np.repeat(lengths >= REST, lengths)
    active = ~calm[:-1] | ~calm[1:] | (np.abs(jumps) >= FELT)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], active, [False]))))
    for first, last in edges.reshape(-1, 2):
        yield int(first), int(last)
