"""The 0-1 test for chaos, of a series alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import fftconvolve

from rodgen.analyse.analysis_guard import guard_analysis
from rodgen.arrays import Array
from rodgen.errors import InputError

LEAST = 100  # samples
CUT = 10  # lags go up to the length of the series over this
FREQUENCIES = np.pi / 5, 4 * np.pi / 5  # away from resonances of the sampling


@guard_analysis
def zero_one_test(series: ArrayLike, *, count: int = 100, seed: int = 0) -> float:
    """Return K of a series: about 0 for regular, about 1 for chaotic motion.

    The series drives a walk in a plane, which turns by an angle c from sample to sample. If the
    motion is chaotic, the mean square displacement of the walk (less the part that oscillates)
    grows with the lag. K is the median, over ``count`` angles c, of the correlation between
    displacement and lag. Samples too close in time look regular: a few in a period are best.
    Source: G. A. Gottwald, I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129-145.

    Parameters
    ----------
    series
        Samples (T,), evenly spaced in time, in units of any kind: a multiple of the series has the
        same K.
    count
        Number of angles c.
    seed
        Seed of the random numbers that choose them.

    Returns
    -------
    float
        K, dimensionless: about 0 for regular and about 1 for chaotic motion, not-a-number for a
        series that is not finite, zero for one that does not vary.

    Raises
    ------
    InputError
        For fewer than 100 samples.

    Examples
    --------
    >>> import numpy as np, rodgen
    >>> x = [0.3]
    >>> while len(x) < 2000:
    ...     x.append(4 * x[-1] * (1 - x[-1]))  # the logistic map, chaotic
    >>> rodgen.zero_one_test(x) > 0.9, rodgen.zero_one_test(np.sin(np.arange(2000))) < 0.1
    (True, True)
    """
    phi = np.asarray(series, dtype=float)
    if phi.ndim != 1 or len(phi) < LEAST:
        raise InputError("series", f"of shape {phi.shape}", f"at least {LEAST} samples, one axis")
    if not np.isfinite(phi).all():
        return float("nan")
    scale = float(np.abs(phi - phi.mean()).max())
    if scale <= 1e-12 * float(np.abs(phi).max(initial=0.0)):
        return 0.0
    phi = phi / scale
    found = np.random.default_rng(seed).uniform(*FREQUENCIES, count)
    return float(np.median([_correlation(phi, c) for c in found]))


def _correlation(phi: Array, c: float) -> float:
    """Correlation of lag and mean square displacement, of the walk that turns by c."""
    size = len(phi)
    lags = np.arange(1, size // CUT + 1)
    walk = np.cumsum(phi * np.exp(1j * c * np.arange(1, size + 1)))
    until = size - lags[-1]
    # |a - b|^2 = |a|^2 + |b|^2 - 2 Re a b*, summed over the first samples for all lags at once.
    squares = np.append(0.0, np.cumsum(np.abs(walk) ** 2))
    both = fftconvolve(walk, walk[until - 1 :: -1].conj())[until - 1 + lags].real
    far = (squares[until + lags] - squares[lags] + squares[until] - 2 * both) / until
    far -= phi.mean() ** 2 * (1 - np.cos(lags * c)) / (1 - np.cos(c))
    return float(np.corrcoef(lags, far)[0, 1])


def decimate(series: Array) -> Array:
    """Thin out a series to its decorrelation lag, the first at which its autocorrelation falls
    below 1/e."""
    off = series - series.mean()
    spectrum = np.fft.rfft(off, 2 * len(off))
    together = np.fft.irfft(np.abs(spectrum) ** 2)[: len(off)]
    below = np.flatnonzero(together < together[0] / np.e)
    return series[:: max(1, int(below[0]))] if len(below) else series
