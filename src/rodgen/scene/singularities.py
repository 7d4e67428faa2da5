"""Break points, poles and half-periods of functions of t or s."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from rodgen.scene.zeros import sample, zeros

FEWEST_TURNS = 3  # of what swings
COMMON = 0.2  # share of the times between turns that are shorter
TURNS = 1e-6  # of the largest value: changes from one sample to the next that are none

# Towards a pole: shares of the time scale, and how much more from each to the next. A power of
# -1/4 grows as much; what min or max bounds, and a logarithm, do not.
NEARER, LARGER = 2.0 ** np.array([-20, -32, -44]), 7.9


class RealFunction(Protocol):
    """Interface of functions of one variable that tell where they may not be smooth."""

    def __call__(self, at: Any) -> Any:
        """Values at numbers."""

    def kinks(self) -> list[Callable[[Any], Any]]:
        """Functions in whose zeros it is not smooth."""

    def knots(self) -> list[float]:
        """Other places where it is not smooth."""

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
