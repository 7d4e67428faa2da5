"""The spectrum of a signal as it comes: amplitudes over frequency in a window of time."""

from __future__ import annotations

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.view.live.plots.lagrange import evened

LEAST, MOST = 16, 1 << 14  # samples of the window
PADDED = 8  # times the window: between two lines a tone loses 1/400 of its amplitude at most
ROWS = 2048  # that are shown, the largest amplitudes among their neighbours
SCATTER = 1e-6  # of the sampling interval, within which samples are taken as evenly spaced


class Window:
    """The last seconds of a signal, (T,) at times (T,)."""

    def __init__(self, seconds: float):
        self.seconds = seconds
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self.t, self.x = np.zeros(0), np.zeros(0)

    def feed(self, t: Array, x: Array) -> None:
        """Later samples, (K,); earlier ones than there are already start it anew."""
        if not len(t):
            return
        if len(self.t) and t[0] < self.t[-1]:
            self.reset()
        t, x = np.concatenate((self.t, t)), np.concatenate((self.x, x))
        first = max(int(np.searchsorted(t, t[-1] - self.seconds)), len(t) - MOST)
        self.t, self.x = t[first:], x[first:]


def spectrum(t: Array, x: Array) -> Array:
    """Frequencies [Hz] and amplitudes, (F, 2), of a signal x (T,) at rising times t (T,) [s]: a
    sine of amplitude A is a peak of height A. Hann's window; mean and linear trend are removed.
    Samples that are not evenly spaced are interpolated by cubics. (0, 2) where there is too
    little."""
    later = np.diff(t, prepend=-np.inf) > 0
    t, x = t[later], x[later]
    if len(t) < LEAST or not np.isfinite(x).all():
        return np.zeros((0, 2))
    dt, x = _even(t, x)
    u = np.arange(len(x)) - (len(x) - 1) / 2
    hann = np.cos(np.pi * u / len(x)) ** 2
    # The line that fits best where the window weighs: a tone has next to no share in it.
    x = x - (hann @ x) / hann.sum() - u * ((hann * u) @ x) / (hann @ u**2)
    size = PADDED * len(x)
    amplitudes = 2 * np.abs(np.fft.rfft(hann * x, size)) / hann.sum()
    return _largest(np.arange(len(amplitudes)) / (size * dt), amplitudes)


def _even(t: Array, x: Array) -> tuple[float, Array]:
    """Interval and signal, evenly spaced; about as close as where the samples are closest."""
    gaps = np.diff(t)
    span = float(t[-1] - t[0])
    if np.ptp(gaps) <= SCATTER * gaps.mean() + 8 * np.spacing(np.abs(t).max()):
        return span / len(gaps), x
    dt = max(float(np.quantile(gaps, 0.1)), span / (MOST - 1))
    count = int(span / dt + 1e-9) + 1
    times = np.minimum(t[-1] - dt * np.arange(count)[::-1], t[-1])
    return dt, evened(t, x, np.maximum(times, t[0]))


def _largest(f: Array, amplitudes: Array) -> Array:
    """At most ROWS of the lines: of so many neighbours each, the largest."""
    width = -(-len(f) // ROWS)
    missing = -len(f) % width
    index = np.minimum(np.arange(len(f) + missing), len(f) - 1).reshape(-1, width)
    best = np.take_along_axis(index, amplitudes[index].argmax(axis=1)[:, None], axis=1)[:, 0]
    return np.stack((f[best], amplitudes[best]), axis=1)
