"""Search for a time and place at which a function is not finite, or below a limit.

The function is sampled on a grid with its break points; where the samples show a valley that may
reach too low, its bottom is searched. A valley narrower than the grid can be missed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.scene.zeros import bisect

Field = Callable[[Any, Any], Any]  # of times and places, which broadcast
SIDES = 16  # roundings to either side of a point where it is not smooth
DEEPER = 4.0  # times what neighbours differ by: how far below a sample a valley may reach
APART = 1e-12  # of an axis: points that are closer are sides of one
VALLEYS = 200  # searched, the deepest first
SWEEPS, SECTIONS = 4, 40  # over time and place; each narrows a bracket to 4e-9 of it
GOLDEN = (5**0.5 - 1) / 2


def with_neighbours(points: Iterable[float], start: float, end: float) -> Array:
    """Points and their neighbours SIDES roundings away, without those outside the two ends."""
    at = np.array(sorted(points), dtype=float)
    off = SIDES * np.spacing(np.maximum(np.abs(at), np.finfo(float).tiny))
    found = np.concatenate((at - off, at, at + off))
    return found[(start <= found) & (found <= end)]


def zeros_on_grid(functions: Iterable[Callable[[Array], Any]], grid: Array) -> list[float]:
    """Zeros of functions: between points of a grid where the sign changes, or at one."""
    found: list[float] = []
    for function in functions:
        signs = np.sign(np.broadcast_to(function(grid), grid.shape))
        found += grid[(signs == 0) & (np.abs(signs).sum() > 0)].tolist()
        at = np.flatnonzero(signs[:-1] * signs[1:] < 0)
        found += bisect(function, grid[at], grid[at + 1]).tolist()
    return found


def find_out_of_bounds(
    f: Field, times: Array, places: Array, least: float
) -> tuple[float, ...] | None:
    """Find a time and a place at which f is not finite or below `least`; returns them with the
    value there, or None. times, places: ascending."""
    values = np.broadcast_to(f(times[:, None], places), (len(times), len(places)))
    found = _first_out_of_bounds(values, times[:, None], places, least)
    if found:
        return found
    axes = [times, places]
    at = _local_minima(values, axes, least)
    if not len(at[0]):
        return None
    point = [axis[i] for axis, i in zip(axes, at, strict=True)]
    brackets = [
        (axis[np.maximum(i - 1, 0)], axis[np.minimum(i + 1, len(axis) - 1)])
        for axis, i in zip(axes, at, strict=True)
    ]
    for _ in range(SWEEPS):
        for axis, bracket in enumerate(brackets):
            if len(axes[axis]) > 1:
                point[axis] = _minimise_along(f, point, axis, *bracket)
    t, s = point
    return _first_out_of_bounds(np.asarray(f(t, s)), t, s, least)


def _first_out_of_bounds(
    values: Array, t: Array, s: Array, least: float
) -> tuple[float, ...] | None:
    wrong = ~(np.isfinite(values) & (values >= least))
    if not wrong.any():
        return None
    first = int(np.argmax(wrong))
    return tuple(float(np.broadcast_to(part, wrong.shape).flat[first]) for part in (t, s, values))


def _local_minima(values: Array, axes: list[Array], least: float) -> tuple[NDArray[np.int_], ...]:
    """Indices of local minima of samples beside which values may fall below `least`."""
    inner, reach = np.ones(values.shape, bool), np.zeros(values.shape)
    for axis, points in enumerate(axes):
        edges = [(int(axis == i), int(axis == i)) for i in range(len(axes))]
        around = np.pad(values, edges, constant_values=np.inf)
        # What jumps between the two sides of a point says nothing of a valley beside it.
        gaps = np.pad(np.diff(points), 1) > APART * np.ptp(points)
        for first, last, gap in ((0, -2, gaps[:-1]), (2, None, gaps[1:])):
            here = tuple(slice(first, last) if i == axis else slice(None) for i in range(len(axes)))
            rise = around[here] - values
            inner &= rise >= 0
            wide = np.isfinite(rise) & np.moveaxis(gap[..., None], 0, axis)
            reach = np.maximum(reach, np.where(wide, rise, 0.0))
    deep = values - DEEPER * reach
    found = np.flatnonzero(inner & (deep < least) & (reach > 0))
    kept = found[np.argsort(deep.flat[found], kind="stable")[:VALLEYS]]
    return np.unravel_index(kept, values.shape)


def _minimise_along(f: Field, point: list[Array], axis: int, low: Array, high: Array) -> Array:
    """Minimise f along an axis in brackets, by golden section; no worse than the point itself."""

    def evaluate(at: Array) -> Array:
        values = np.asarray(f(*(at if i == axis else x for i, x in enumerate(point))))
        return np.where(np.isnan(values), -np.inf, values)

    start = point[axis]
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    for _ in range(SECTIONS):
        lower = evaluate(left) < evaluate(right)
        low, high = np.where(lower, low, left), np.where(lower, right, high)
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    middle = (low + high) / 2
    return np.where(evaluate(middle) <= evaluate(start), middle, start)
