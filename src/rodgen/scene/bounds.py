"""Where a function of time and place is not finite, or smaller than it may be.

It is looked at on a grid with the points at which it is not smooth; where the grid shows a valley
that may reach too low, its bottom is searched. What is narrower than the grid can be missed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.scene.zeros import bisected

Field = Callable[[Array, Array], Any]  # of times and places, which broadcast
SIDES = 16  # roundings to either side of a point where it is not smooth
DEEPER = 4.0  # times what neighbours differ by: how far below a sample a valley may reach
APART = 1e-12  # of an axis: points that are closer are sides of one
VALLEYS = 200  # searched, the deepest first
SWEEPS, SECTIONS = 4, 40  # over time and place; each narrows a bracket to 4e-9 of it
GOLDEN = (5**0.5 - 1) / 2


def sides(points: Iterable[float], start: float, end: float) -> Array:
    """Points between two ends with what lies on either side of them; none that is outside."""
    at = np.array(sorted(points), dtype=float)
    off = SIDES * np.spacing(np.maximum(np.abs(at), np.finfo(float).tiny))
    found = np.concatenate((at - off, at, at + off))
    return found[(start <= found) & (found <= end)]


def between(functions: Iterable[Callable[[Array], Any]], grid: Array) -> list[float]:
    """Where functions change their sign between two points of a grid, or are zero at one."""
    found: list[float] = []
    for function in functions:
        signs = np.sign(np.broadcast_to(function(grid), grid.shape))
        found += grid[(signs == 0) & (np.abs(signs).sum() > 0)].tolist()
        at = np.flatnonzero(signs[:-1] * signs[1:] < 0)
        found += bisected(function, grid[at], grid[at + 1]).tolist()
    return found


def outside(f: Field, times: Array, places: Array, least: float) -> tuple[float, ...] | None:
    """A time, a place and the value there that is not finite or smaller than the least; None where
    there is none. times, places: ascending."""
    values = np.broadcast_to(f(times[:, None], places), (len(times), len(places)))
    found = _first(values, times[:, None], places, least)
    if found:
        return found
    axes = [times, places]
    at = _valleys(values, axes, least)
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
                point[axis] = _lowest(f, point, axis, *bracket)
    t, s = point
    return _first(np.asarray(f(t, s)), t, s, least)


def _first(values: Array, t: Array, s: Array, least: float) -> tuple[float, ...] | None:
    wrong = ~(np.isfinite(values) & (values >= least))
    if not wrong.any():
        return None
    first = int(np.argmax(wrong))
    return tuple(float(np.broadcast_to(part, wrong.shape).flat[first]) for part in (t, s, values))


def _valleys(values: Array, axes: list[Array], least: float) -> tuple[NDArray[np.int_], ...]:
    """Samples that no neighbour is below, and that may lie beside something too small."""
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


def _lowest(f: Field, point: list[Array], axis: int, low: Array, high: Array) -> Array:
    """Where f is lowest along an axis, in brackets, by golden sections; or the point itself."""

    def height(at: Array) -> Array:
        values = np.asarray(f(*(at if i == axis else x for i, x in enumerate(point))))
        return np.where(np.isnan(values), -np.inf, values)

    start = point[axis]
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    for _ in range(SECTIONS):
        lower = height(left) < height(right)
        low, high = np.where(lower, low, left), np.where(lower, right, high)
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    middle = (low + high) / 2
    return np.where(height(middle) <= height(start), middle, start)
