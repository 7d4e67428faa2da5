"""The numbers of a table, and what they are between and beyond the knots."""

from __future__ import annotations

from functools import cached_property
from heapq import heappop, heappush
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodgen.scene.grammar.vocabulary import CORNERS, CUBIC, LINEAR, SLOPE

Array = NDArray[np.float64]
# Steps end at all knots of a table, or at so many of a longer one, at fewer where straight lines
# between these are off by no more than this share of its range. The others, which are closer than
# steps or hardly bend it, a step meets as it meets a curve.
MOST, BEND = 500, 1e-2


class TableData:
    """The numbers of a table: knots, which ascend, and a value at each; they do not change.

    knots, values: (rows,).
    """

    def __init__(self, knots: ArrayLike, values: ArrayLike):
        self.numbers: Array = np.concatenate((knots, values), dtype=float)
        self.numbers.setflags(write=False)

    @classmethod
    def of(cls, numbers: Any) -> Self:
        """A table from its knots and, after them, its values, (2 rows,), or as it is."""
        return numbers if isinstance(numbers, cls) else cls(*np.split(np.asarray(numbers), 2))

    def __reduce__(self) -> tuple[Any, ...]:
        return TableData.of, (np.array(self.numbers),)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.numbers, dtype, copy=copy)

    def __repr__(self) -> str:
        low, high = self.knots[[0, -1]]
        return f"<TableData: {len(self)} rows, from {low:g} to {high:g}>"

    def __len__(self) -> int:
        return len(self.numbers) // 2

    # Of the same numbers it is the same: scenes and expressions are remembered by what they hold.
    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TableData):
            return NotImplemented
        return self is other or np.array_equal(self.numbers, other.numbers)

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash(self.numbers.tobytes())

    @property
    def knots(self) -> Array:
        """Its knots, (rows,)."""
        return self.numbers[: len(self)]

    @property
    def values(self) -> Array:
        """Its values at them, (rows,)."""
        return self.numbers[len(self) :]

    @cached_property
    def corners(self) -> Array:
        """Knots at which steps end, the first and the last among them: of a long table those that
        tell what it is like (D. H. Douglas and T. K. Peucker 1973), which of a smooth curve are as
        many, however many rows tell of it."""
        if len(self) <= MOST:
            return self.knots
        least = BEND * np.ptp(self.values)
        kept, open_parts = {0, len(self) - 1}, [self._bend(0, len(self) - 1)]
        while open_parts and len(kept) < MOST:
            bend, first, at, last = heappop(open_parts)
            if -bend <= least:
                break
            kept.add(at)
            heappush(open_parts, self._bend(first, at))
            heappush(open_parts, self._bend(at, last))
        return self.knots[sorted(kept)]

    def _bend(self, first: int, last: int) -> tuple[float, int, int, int]:
        """How far a part of it is from a straight line, below zero, and where it is that most."""
        x, y = self.knots[first : last + 1], self.values[first : last + 1]
        off = np.abs(y - y[0] - (y[-1] - y[0]) * ((x - x[0]) / (x[-1] - x[0])))
        at = int(np.argmax(off))
        return -float(off[at]), first, first + at, last

    def at(self, x: Any, kind: str) -> Any:
        """What it is at x, of a kind of the grammar: it holds its first and last value outside of
        its knots; or its slope, or a number that changes its sign at its corners and only there."""
        knots, values = self.knots, self.values
        if kind == CORNERS:
            return _alternating(x, self.corners)
        if kind == CUBIC:
            return self._monotone_cubic(np.clip(x, knots[0], knots[-1]))
        if kind == CUBIC + SLOPE:
            slopes = self._monotone_cubic.derivative()(x)
        else:
            at = _parts(x, knots)
            slopes = (values[at + 1] - values[at]) / (knots[at + 1] - knots[at])
        if kind == LINEAR:  # np.interp copies what is not to be written to
            within = slopes * (np.clip(x, knots[0], knots[-1]) - knots[at]) + values[at]
            return np.where(x >= knots[-1], values[-1], within)
        return np.where((x > knots[0]) & (x < knots[-1]), slopes, 0.0)

    @cached_property
    def _monotone_cubic(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.knots, self.values)


def _parts(x: Any, knots: Array) -> Any:
    """Numbers of the parts between knots in which x lies, or to which it is next."""
    return np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)


def _alternating(x: Any, knots: Array) -> Any:
    """A number that is zero at knots alone and changes its sign there."""
    at = _parts(x, knots)
    u = (x - knots[at]) / (knots[at + 1] - knots[at])
    return np.where(at % 2, -1.0, 1.0) * u * (1 - u)
