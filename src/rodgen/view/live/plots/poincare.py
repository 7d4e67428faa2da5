"""Points at which a condition is met: a Poincaré section.

A quantity c crosses a value (or the value plus any whole number of periods: "t" every 0.5 s is a
stroboscope) between two samples. The instant is that at which the polynomial through the samples
around has the value, and x and y are taken from polynomials there: cubics through two samples on
either side, an error of the fourth power of the sampling interval, as soon as the second sample
after the crossing is there. Next to a change of a parameter or a kick, which samples must not be
joined across, it is a parabola or a line, an error of the third or second power.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.view.live.plots.lagrange import lagrange, reached

DIGITS = 9  # of the number of a value, beyond which a sample is on it
DIRECTIONS = ("rising", "falling", "either")


@dataclass(frozen=True)
class Condition:
    """c reaches value + k every (k whole; 0: value alone) rising, falling or either way; a jump of
    c by more than half of ``period``, where it has one, is none."""

    value: float
    direction: str = "rising"
    every: float = 0.0
    period: float = 0.0

    def levels(self, before: Array, after: Array) -> Array:
        """The values that are reached between samples and the next, (N,); not-a-number where none
        is. One that starts on a value leaves it, which is no crossing."""
        (below, risen), (above, fallen) = (
            (self._number(before, rounded), self._number(after, rounded))
            for rounded in (np.floor, np.ceil)
        )
        rising = (below < risen) & (self.direction != "falling")
        falling = (above > fallen) & (self.direction != "rising")
        reached = np.where(rising, risen, np.where(falling, fallen, np.nan))
        levels = self.value + self.every * reached
        if self.period:
            levels[np.abs(after - before) > self.period / 2] = np.nan
        return np.where(np.isfinite(before) & np.isfinite(after), levels, np.nan)

    def _number(self, c: Array, rounded: np.ufunc) -> Array:
        """The number k of the value next to c, below or above it. Each sample has one number of
        each, and is on a value that it misses by rounding: so none is lost or counted twice."""
        beyond = c - self.value
        k = np.round(beyond / self.every, DIGITS) if self.every else np.sign(beyond) / 2
        number: Array = rounded(k)
        return number


class Section:
    """Finds the points as samples come."""

    def __init__(self, condition: Condition):
        self.condition = condition
        self.reset()

    def reset(self) -> None:
        """Forget the samples so far."""
        self._rows = np.zeros((0, 5))  # t, x, y, c, and the number of the piece
        self._piece = 0
        self._done = 0  # intervals between these rows that have been looked at

    def feed(self, rows: Array, joined: bool) -> Array:
        """Points (P, 3) of t, x, y that have become known with more samples (K, 4) of t, x, y, c;
        joined: whether the motion is smooth from the sample before to the first of them."""
        if not len(rows):
            return np.zeros((0, 3))
        if len(self._rows) and rows[0, 0] < self._rows[-1, 0]:  # the run has started again
            self.reset()
        self._piece += not joined
        number = np.full((len(rows), 1), float(self._piece))
        self._rows = np.concatenate((self._rows, np.concatenate((rows, number), axis=1)))
        c = self._rows[self._done : len(self._rows) - 1, 3]
        with np.errstate(all="ignore"):  # of what is not finite, which crosses nothing
            levels = self.condition.levels(c[:-1], c[1:])
        points = [
            self._between(self._done + i, float(levels[i]))
            for i in np.flatnonzero(np.isfinite(levels)).tolist()
        ]
        self._done = max(self._done, len(self._rows) - 2)
        drop = max(0, self._done - 1)  # the sample before the next interval is still needed
        self._rows, self._done = self._rows[drop:], self._done - drop
        return np.array(points).reshape(-1, 3)

    def _between(self, i: int, level: float) -> tuple[float, float, float]:
        """The point between sample i and the next."""
        low, rows = self._around(i)
        # From the first of them on, lest a run of long ago be short of digits.
        start = float(rows[0, 0])
        t, x, y, c = (rows - [start, 0.0, 0.0, 0.0]).T.tolist()
        at = reached(t, c, level, low, low + 1)
        return start + at, lagrange(t, x, at), lagrange(t, y, at)

    def _around(self, i: int) -> tuple[int, Array]:
        """Two to four samples around the interval after sample i that may be joined, and which of
        them sample i is."""
        rows = self._rows
        first, last = i, i + 1
        if rows[i, 4] == rows[i + 1, 4]:
            if i and rows[i - 1, 4] == rows[i, 4] and rows[i - 1, 0] < rows[i, 0]:
                first = i - 1
            if rows[i + 2, 4] == rows[i + 1, 4] and rows[i + 2, 0] > rows[i + 1, 0]:
                last = i + 2
        return i - first, rows[first : last + 1, :4]
