"""Tables of numbers: interpolation, slopes, and the knots at which steps end."""

from __future__ import annotations

from functools import cached_property
from heapq import heappop, heappush
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodgen.arrays import Array
from rodgen.scene.grammar.vocabulary import CUBIC, LINEAR, SLOPE

# Steps end at all knots of a table of at most MOST rows. Of a longer one they end at up to so many,
# fewer where chords between these miss it by at most BEND of its range: its other knots are closer
# than steps, or hardly bend it, and a step crosses them as it does a curve.
MOST, BEND = 500, 1e-3


class TableData:
    """A table of numbers: knots, which ascend, and a value at each. It does not change.

    knots, values: (rows,).
    """

    def __init__(self, knots: ArrayLike, values: ArrayLike):
        self.numbers: Array = np.concatenate((knots, values), dtype=float)
        self.numbers.setflags(write=False)

    @classmethod
    def of(cls, numbers: Any) -> Self:
        """Make a table from its knots and then its values, (2 rows,); return a table as it is."""
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
        """Places of the values, (rows,)."""
        return self.numbers[: len(self)]

    @property
    def values(self) -> Array:
        """Values at the knots, (rows,)."""
        return self.numbers[len(self) :]

    @cached_property
    def corners(self) -> Array:
        """Knots at which steps end, the first and the last included.

        Of a long table they are chosen by D. H. Douglas and T. K. Peucker (1973): a smooth curve
        has as many, however many rows it is sampled in.
        """
        if len(self) <= MOST:
            return self.knots
        least = BEND * np.ptp(self.values)
        kept, open_parts = {0, len(self) - 1}, [self._farthest_row(0, len(self) - 1)]
        while open_parts and len(kept) < MOST:
            bend, first, at, last = heappop(open_parts)
            if -bend <= least:
                break
            kept.add(at)
            heappush(open_parts, self._farthest_row(first, at))
            heappush(open_parts, self._farthest_row(at, last))
        return self.knots[sorted(kept)]

    def _farthest_row(self, first: int, last: int) -> tuple[float, int, int, int]:
        """Return the largest distance of rows from their chord, negative for a heap, and where it
        is."""
        x, y = self.knots[first : last + 1], self.values[first : last + 1]
        off = np.abs(y - y[0] - (y[-1] - y[0]) * ((x - x[0]) / (x[-1] - x[0])))
        at = int(np.argmax(off))
        return -float(off[at]), first, first + at, last

    def at(self, x: Any, kind: str) -> Any:
        """Evaluate the table or a derivative at x, by the kind of interpolation. Outside of its
        knots it keeps its first and last value."""
        knots, values = self.knots, self.values
        if kind == CUBIC:
            return self._monotone_cubic(np.clip(x, knots[0], knots[-1]))
        if kind.startswith(CUBIC):
            slopes = self._monotone_cubic.derivative(kind.count(SLOPE))(x)
        else:
            at = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
            slopes = (values[at + 1] - values[at]) / (knots[at + 1] - knots[at])
        if kind == LINEAR:  # np.interp copies what is not to be written to
            within = slopes * (np.clip(x, knots[0], knots[-1]) - knots[at]) + values[at]
            return np.where(x >= knots[-1], values[-1], within)
        return np.where((x > knots[0]) & (x < knots[-1]), slopes, 0.0)

    @cached_property
    def _monotone_cubic(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.knots, self.values)
