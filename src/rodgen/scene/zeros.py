"""Break points, zeros, poles and pulses of functions of one variable, t or s.

A load that changes more often than it is sampled looks like one that changes slowly, or not at all.
It is therefore sampled more and more finely, until three times as many samples show no more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache, partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array

Function = Callable[[Any], Any]
Pulse = tuple[float, float, float]  # begin, peak and end

SAMPLES = 4001  # to begin with
MOST_SAMPLES = 2_000_000
MORE = 3.01  # times as many: no whole number, for what repeats with the samples
TOGETHER = 250  # places that are looked at together, by the memory that they take
LOOKED_AT = 10  # places by which it is told how many samples are enough for all
KEPT = 1024  # of what was found, by functions that are equal
DIPS = 1000  # extrema that are looked at between samples

# A method with error control sees a load at its stages alone. While nothing happens its steps grow
# tenfold, and one of them may reach across a whole pulse: the run would be smooth, and wrong.
SEEN = 100_001  # samples over a span: a pulse that is shorter than the time between two is not seen
QUIET = 1e-3  # share of its range that counts as a change
REST = 50  # samples in which a load that is at rest changes by less than that
FELT = 10  # times that change, from which on a pulse is one

FEWEST_TURNS = 3  # of what swings
COMMON = 0.2  # share of the times between turns that are shorter
TURNS = 1e-6  # of the largest value: changes from one sample to the next that are none

# Towards a pole: shares of the time scale, and how much more from each to the next. A power of
# -1/4 grows as much; what min or max bounds, and a logarithm, do not.
NEARER, LARGER = 2.0 ** np.array([-20, -32, -44]), 7.9


def zeros(functions: Iterable[Function], start: float, end: float) -> list[float]:
    """Zeros of functions from start to end, ascending.

    Found where the sign changes between two samples, and on both sides of an extremum between
    samples that reaches beyond zero.
    """
    return sorted({at for function in functions for at in _zeros(function, start, end)})


@lru_cache(maxsize=KEPT)
def _zeros(function: Function, start: float, end: float) -> tuple[float, ...]:
    grid, values, _ = sample(function, start, end)
    points = np.concatenate((grid, _missed_extrema(function, grid, values)))
    points.sort()
    signs = np.sign(_evaluate_on(function, points))
    flat = np.zeros(len(points), bool)  # a zero with zeros on both sides is no break
    flat[1:-1] = (signs[:-2] == 0) & (signs[2:] == 0)
    at = np.flatnonzero(signs[:-1] * signs[1:] < 0)
    between = bisect(function, points[at], points[at + 1])
    return (*points[(signs == 0) & ~flat].tolist(), *between.tolist())


def sample(
    function: Function,
    start: float,
    end: float,
    counted: Callable[[Array], int] | None = None,
) -> tuple[Array, Array, bool]:
    """Sample a function finely enough; returns samples, values, and whether they are enough: three
    times as many have the same count. counted: of values, by default their sign changes."""
    counted = counted or _sign_changes
    grid = np.linspace(start, end, SAMPLES)
    values = _evaluate_on(function, grid)
    seen = counted(values)
    while True:
        finer = np.linspace(start, end, int(MORE * len(grid)))
        fine = _evaluate_on(function, finer)
        more = counted(fine)
        if more == seen:
            return (grid, values, True) if len(grid) == SAMPLES else (finer, fine, True)
        if len(finer) * MORE > MOST_SAMPLES:
            return finer, fine, False
        grid, values, seen = finer, fine, more


def crossing_times(
    function: Callable[[Array, Array], Any], places: Array, start: float, end: float
) -> list[float] | None:
    """Times from start to end at which a function of time and place is zero at one of these places,
    seen by sign changes between samples. None where they are too many for that."""
    some = places[:: -(-len(places) // LOOKED_AT)]
    grid, found = np.empty(0), list[float]()
    for place in some:
        finer, _, enough = sample(partial(_at_places, function, place), start, end)
        if not enough:
            return None
        grid = max(grid, finer, key=len)
    together = max(1, TOGETHER * SAMPLES // len(grid))
    for some in np.array_split(places, -(-len(places) // together)):
        signs = np.sign(np.broadcast_to(function(grid[:, None], some), (len(grid), len(some))))
        found += grid[np.nonzero((signs[1:-1] == 0) & (signs[:-2] * signs[2:] < 0))[0] + 1].tolist()
        at, where = np.nonzero(signs[:-1] * signs[1:] < 0)
        if len(at):
            here = partial(_at_places, function, some[where])
            found += bisect(here, grid[at], grid[at + 1]).tolist()
    return found


def _at_places(function: Callable[[Array, Array], Any], places: Any, times: Array) -> Any:
    return function(times, places)


def _evaluate_on(function: Function, grid: Array) -> Array:
    return np.broadcast_to(function(grid), grid.shape)


def _sign_changes(values: Array) -> int:
    signs = np.sign(values)
    signs = signs[signs != 0]
    return int(np.count_nonzero(signs[1:] * signs[:-1] < 0))


def _missed_extrema(function: Function, grid: Array, values: Array) -> Array:
    """Extrema between samples that reach beyond a zero which the samples miss."""
    from scipy.optimize import minimize_scalar

    size, sign = np.abs(values), np.sign(values)
    left, right = size[1:-1] - size[:-2], size[1:-1] - size[2:]
    same = (sign[1:-1] == sign[:-2]) & (sign[1:-1] == sign[2:]) & (sign[1:-1] != 0)
    dips = np.flatnonzero((left <= 0) & (right <= 0) & (left + right < 0) & same) + 1
    places = []
    for at in dips[:DIPS]:

        def signed_value(x: float, sign: float = sign[at]) -> float:
            return float(np.nan_to_num(sign * function(x), nan=np.inf))

        bounds = (grid[at - 1], grid[at + 1])
        lowest = minimize_scalar(
            signed_value, bounds=bounds, method="bounded", options={"xatol": 1e-14}
        )
        if lowest.fun < 0:
            places.append(float(lowest.x))
    return np.array(places)


def bisect(function: Function, low: Array, high: Array) -> Array:
    """Bisect brackets to the last digit; unlike Brent's method it needs signs alone."""
    low, high = low.copy(), high.copy()
    positive = _evaluate_on(function, low) > 0
    while True:
        middle = 0.5 * (low + high)
        left = (low < middle) & (middle < high)
        if not left.any():
            return high
        same = (_evaluate_on(function, middle) > 0) == positive
        low = np.where(left & same, middle, low)
        high = np.where(left & ~same, middle, high)


@lru_cache(maxsize=2)
def _sample_grid(start: float, end: float) -> Array:
    """Sample times of a span; not to be written to."""
    grid = np.linspace(start, end, SEEN)
    grid.setflags(write=False)
    return grid


@lru_cache(maxsize=KEPT)
def find_pulses(value: Function, start: float, end: float) -> tuple[Pulse, ...]:
    """Begin, peak and end of every pulse that is shorter than the rest before it, ascending.

    value: of a load at times (...,), hashable.
    """
    grid = _sample_grid(start, end)
    values = np.broadcast_to(value(grid), grid.shape)
    if not np.isfinite(values.sum()):
        values = np.nan_to_num(values, posinf=0.0, neginf=0.0)
    level = QUIET * np.ptp(values)
    if not 0 < level < np.inf:
        return ()
    found, rests_since = [], 0
    levels = np.round((values - values[0]) / level)
    changes = np.flatnonzero(levels[1:] != levels[:-1])
    if len(changes) and np.diff(changes, prepend=-1, append=len(grid) - 1).max() < REST:
        return ()  # what never rests has no pulse after a rest
    for first, last in _active_intervals(levels):
        change = np.abs(levels[first : last + 1] - levels[first])
        if change.max() >= FELT and last - first <= first - rests_since:
            peak = first + int(np.argmax(change))
            found.append((float(grid[first]), float(grid[peak]), float(grid[last])))
        rests_since = last
    return tuple(found)


def _active_intervals(levels: NDArray[np.float64]) -> Iterator[tuple[int, int]]:
    """Yield first and last sample of every interval in which levels change without a rest."""
    jumps = np.diff(levels)
    lengths = np.diff(np.concatenate(([0], np.flatnonzero(jumps) + 1, [len(levels)])))
    calm = np.repeat(lengths >= REST, lengths)
    active = ~calm[:-1] | ~calm[1:] | (np.abs(jumps) >= FELT)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], active, [False]))))
    for first, last in edges.reshape(-1, 2):
        yield int(first), int(last)


class RealFunction(Protocol):
    """Interface of functions of one variable that tell where they may not be smooth."""

    def __call__(self, at: Any) -> Any:
        """Values at numbers."""

    def kinks(self) -> list[Callable[[Any], Any]]:
        """Functions in whose zeros it is not smooth."""

    def knots(self) -> list[float]:
        """Further places where the function is not smooth."""

    def divisors(self) -> list[Callable[[Any], Any]]:
        """Functions by which it divides."""

    def split_affine(self) -> tuple[RealFunction, float, float]:
        """Split it into a*core + b: core, a, b."""


@lru_cache(maxsize=256)
def breaks(e: RealFunction, start: float, end: float) -> tuple[float, ...]:
    found = {*zeros(e.kinks(), start, end), *e.knots()}
    return tuple(sorted(x for x in found if start < x < end))


@lru_cache(maxsize=256)
def poles(e: RealFunction, start: float, end: float) -> tuple[float, ...]:
    scale = max(abs(start), abs(end))

    def is_pole(x: float, side: int) -> bool:
        points = x + side * scale * NEARER
        sizes = np.abs(np.broadcast_to(e(points), points.shape))  # of what does not change, one
        larger = bool((sizes[1:] > LARGER * sizes[:-1]).all()) or np.isinf(sizes[-1])
        return bool(start <= points[0] <= end and larger)

    found = zeros([*e.kinks(), *e.divisors()], start, end)
    return tuple(x for x in found if is_pole(x, 1) or is_pole(x, -1))


@lru_cache(maxsize=256)
def half_period(e: RealFunction, start: float, end: float) -> tuple[float, bool]:
    core, a, b = e.split_affine()

    def turning_points(values: Any) -> Any:
        finite = values[np.isfinite(values)]
        return _turning_points(values, TURNS * np.abs(a * finite + b).max(initial=0.0) / abs(a))

    grid, values, enough = sample(core, start, end, lambda values: len(turning_points(values)))
    turns = grid[turning_points(values)]
    if len(turns) < FEWEST_TURNS:
        return math.inf, enough
    return float(np.quantile(np.diff(turns), COMMON) + grid[1] - grid[0]), enough


def _turning_points(values: Any, least: float) -> Any:
    """Indices at which values turn from rising to falling or back, by more than rounding."""
    change = np.diff(values)
    moves = np.flatnonzero(np.abs(change) > least)
    return moves[1:][change[moves[1:]] * change[moves[:-1]] < 0]
