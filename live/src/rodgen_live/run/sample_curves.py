"""Curves through samples: interpolation, thinning, spectra, Poincaré sections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from rodgen.arrays import Array

Values = TypeVar("Values", float, Array)
MOST_ROWS = 5000  # of a plot
# Of spectra:
LEAST, MOST = 16, 1 << 14  # samples of the window
PADDED = 8  # times the window: between two lines a tone loses 1/400 of its amplitude at most
ROWS = 2048  # that are shown, the largest amplitudes among their neighbours
SCATTER = 1e-6  # of the sampling interval, within which samples are taken as evenly spaced
# Of Poincaré sections:
DIGITS = 9  # of the number of a value, beyond which a sample is on it
DIRECTIONS = ("rising", "falling", "either")


def lagrange(t: Sequence[Values], values: Sequence[Values], at: Values) -> Values:
    """Evaluate the polynomial through samples at a time (in Newton's form, by divided differences);
    for numbers, or for arrays (N,), of which each entry has its own samples. With n samples h
    apart, the error is of order h**n."""
    slopes = list(values)
    for order in range(1, len(slopes)):
        for i in range(len(slopes) - 1, order - 1, -1):
            slopes[i] = (slopes[i] - slopes[i - 1]) / (t[i] - t[i - order])
    found = slopes[-1]
    for i in range(len(slopes) - 2, -1, -1):
        found = found * (at - t[i]) + slopes[i]
    return found


def resample(t: Array, values: Array, times: Array) -> Array:
    """Interpolate by the cubic through the four samples around each time; t (T,) rising, values
    (T,), T at least 4, times (N,) within those of t."""
    first = np.clip(np.searchsorted(t, times, side="right") - 2, 0, len(t) - 4)
    four = [first + i for i in range(4)]
    return lagrange([t[i] for i in four], [values[i] for i in four], times)


def thin(rows: Array, most: int = MOST_ROWS) -> Array:
    """Thin rows (M, columns) to at most so many, in their order.

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


class Window:
    """Sliding window over the last seconds of a signal, (T,) at times (T,)."""

    def __init__(self, seconds: float):
        self.seconds = seconds
        self.t, self.x = np.zeros(0), np.zeros(0)

    def feed(self, t: Array, x: Array) -> None:
        """Append samples, (K,); samples earlier than those there begin the window anew."""
        if not len(t):
            return
        if not len(self.t) or t[0] >= self.t[-1]:
            t, x = np.concatenate((self.t, t)), np.concatenate((self.x, x))
        first = max(int(np.searchsorted(t, t[-1] - self.seconds)), len(t) - MOST)
        self.t, self.x = t[first:], x[first:]


def spectrum(t: Array, x: Array) -> Array:
    """Amplitude spectrum of a signal x (T,) at rising times t (T,) [s]: frequencies [Hz] and
    amplitudes, (F, 2); a sine of amplitude A is a peak of height A. Hann's window; mean and linear
    trend are removed. Samples that are not equally spaced are interpolated by cubics. (0, 2) for
    too few samples."""
    later = np.diff(t, prepend=-np.inf) > 0
    t, x = t[later], x[later]
    if len(t) < LEAST or not np.isfinite(x).all():
        return np.zeros((0, 2))
    dt, x = _resample_evenly(t, x)
    u = np.arange(len(x)) - (len(x) - 1) / 2
    hann = np.cos(np.pi * u / len(x)) ** 2
    # The line that fits best where the window weighs: a tone has next to no share in it.
    x = x - (hann @ x) / hann.sum() - u * ((hann * u) @ x) / (hann @ u**2)
    size = PADDED * len(x)
    amplitudes = 2 * np.abs(np.fft.rfft(hann * x, size)) / hann.sum()
    return _thin_peaks(np.arange(len(amplitudes)) / (size * dt), amplitudes)


def _resample_evenly(t: Array, x: Array) -> tuple[float, Array]:
    """Interval and signal at equal spacing, about as close as the closest samples."""
    gaps = np.diff(t)
    span = float(t[-1] - t[0])
    if np.ptp(gaps) <= SCATTER * gaps.mean() + 8 * np.spacing(np.abs(t).max()):
        return span / len(gaps), x
    dt = max(float(np.quantile(gaps, 0.1)), span / (MOST - 1))
    count = int(span / dt + 1e-9) + 1
    times = np.minimum(t[-1] - dt * np.arange(count)[::-1], t[-1])
    return dt, resample(t, x, np.maximum(times, t[0]))


def _thin_peaks(f: Array, amplitudes: Array) -> Array:
    """Thin the lines to at most ROWS: the largest of each group of neighbours."""
    width = -(-len(f) // ROWS)
    missing = -len(f) % width
    index = np.minimum(np.arange(len(f) + missing), len(f) - 1).reshape(-1, width)
    best = np.take_along_axis(index, amplitudes[index].argmax(axis=1)[:, None], axis=1)[:, 0]
    return np.stack((f[best], amplitudes[best]), axis=1)


class PoincareSection:
    """Poincaré section: the points at which a quantity c reaches value + k every (k whole; 0: value
    alone), rising, falling or either way, found as samples come. Every 0.5 s of "t" is a
    stroboscope. A jump of c by more than half of ``period``, where it has one, is no crossing.

    c crosses between two samples. The instant is that at which the polynomial through the
    samples around has the value, and x and y are taken from polynomials there: cubics through two
    samples on either side, an error of the fourth power of the sampling interval, as soon as the
    second sample after the crossing is there. Next to a change of a parameter or a kick, which
    samples must not be joined across, it is a parabola or a line, an error of the third or second
    power.
    """

    def __init__(self, value: float, direction: str, every: float, period: float):
        self.value, self.direction, self.every, self.period = value, direction, every, period
        self.reset()

    def reset(self) -> None:
        """Forget the samples so far."""
        self._rows = np.zeros((0, 5))  # t, x, y, c, and the number of the piece
        self._piece = 0
        self._done = 0  # intervals between these rows that have been looked at

    def feed(self, rows: Array, joined: bool) -> Array:
        """Add samples (K, 4) of t, x, y, c; returns the points (P, 3) of t, x, y found with them.
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
            levels = self._levels(c[:-1], c[1:])
        points = [
            self._crossing_point(self._done + i, float(levels[i]))
            for i in np.flatnonzero(np.isfinite(levels)).tolist()
        ]
        self._done = max(self._done, len(self._rows) - 2)
        drop = max(0, self._done - 1)  # the sample before the next interval is still needed
        self._rows, self._done = self._rows[drop:], self._done - drop
        return np.array(points).reshape(-1, 3)

    def _levels(self, before: Array, after: Array) -> Array:
        """Levels that are reached between samples and the next, (N,); not-a-number where none is. A
        sample on a level leaves it, which is no crossing."""
        (below, risen), (above, fallen) = (
            (self._level_number(before, rounded), self._level_number(after, rounded))
            for rounded in (np.floor, np.ceil)
        )
        rising = (below < risen) & (self.direction != "falling")
        falling = (above > fallen) & (self.direction != "rising")
        reached = np.where(rising, risen, np.where(falling, fallen, np.nan))
        levels = self.value + self.every * reached
        if self.period:
            levels[np.abs(after - before) > self.period / 2] = np.nan
        return np.where(np.isfinite(before) & np.isfinite(after), levels, np.nan)

    def _level_number(self, c: Array, rounded: np.ufunc) -> Array:
        """Number k of the level next to c, below or above it (np.floor or np.ceil). A sample is on
        a level that it misses by rounding: so no crossing is lost or counted twice."""
        beyond = c - self.value
        k = np.round(beyond / self.every, DIGITS) if self.every else np.sign(beyond) / 2
        number: Array = rounded(k)
        return number

    def _crossing_point(self, i: int, level: float) -> tuple[float, float, float]:
        from scipy.optimize import brentq

        low, rows = self._neighbours(i)
        # From the first of them on, lest a run of long ago be short of digits.
        start = float(rows[0, 0])
        t, x, y, c = (rows - [start, 0.0, 0.0, level]).T.tolist()
        at = t[min(low, low + 1, key=lambda k: abs(c[k]))]  # at the level but for rounding, unless
        if c[low] * c[low + 1] < 0:
            at = brentq(lambda at: lagrange(t, c, at), t[low], t[low + 1], xtol=1e-15)
        return start + at, lagrange(t, x, at), lagrange(t, y, at)

    def _neighbours(self, i: int) -> tuple[int, Array]:
        """Number of sample i among the two to four samples around the interval after it that may be
        joined, and the rows of these."""
        rows = self._rows
        joined = (np.diff(rows[:, 4]) == 0) & (np.diff(rows[:, 0]) > 0)  # to the next sample
        first = i - bool(i and joined[i - 1] and joined[i])
        last = i + 1 + bool(joined[i] and joined[i + 1])
        return i - first, rows[first : last + 1, :4]
