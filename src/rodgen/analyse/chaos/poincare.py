"""Poincaré sections: states of a motion where it crosses a surface; and the 0-1 test for chaos, of
a series alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import fftconvolve

from rodgen.analyse.analysis_guard import guard_analysis
from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import Solution
from rodgen.scene import Scene
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

CROSSING = "the section"  # name of the event
WAYS = ("rising", "falling", "either")

LEAST = 100  # samples
CUT = 10  # lags go up to the length of the series over this
FREQUENCIES = np.pi / 5, 4 * np.pi / 5  # away from resonances of the sampling


def poincare_section(
    motion: System | Scene | Solution,
    where: str,
    *,
    rising: float | None = None,
    falling: float | None = None,
    either: float | None = None,
    transient: float = 0.0,
) -> xarray.Dataset:
    """Return the states of a motion where a quantity crosses a level.

    Crossings are found like events of a run, on its dense output. They do not depend on samples.

    Parameters
    ----------
    motion
        A scene or System, which is run over its span, or a `Solution`, whose run is repeated.
    where
        Name of the quantity, as in an event: phi_0, omega_3 or tip_y, for example.
    rising, falling, either
        One of these: the level, in the unit of the quantity, and the direction in which it is
        crossed.
    transient
        Time at the start whose crossings are left out [s].

    Returns
    -------
    xarray.Dataset
        One dimension of crossings: t [s], phi [rad], omega [rad/s], tip [m] and the whole state y.

    Raises
    ------
    InputError
        For a quantity that does not exist, or without exactly one level.
    RunError
        If the run fails.

    Examples
    --------
    A pendulum passes its lowest point once a period:

    >>> import numpy as np, rodgen
    >>> scene = rodgen.Scene.from_dict({
    ...     "name": "pendulum",
    ...     "rod": {"links": 1, "length": 1.0, "mass": 1.0, "bending_stiffness": 0.0,
    ...             "boundary": "pinned"},
    ...     "loads": {"gravity": {}},
    ...     "initial": {"phi": -1.5},
    ... })
    >>> found = rodgen.poincare_section(scene, "phi_0", rising=-np.pi / 2)
    >>> np.diff(found.t)[:3].round(3)
    array([1.638, 1.638, 1.638])
    """
    import xarray

    direction, level = _check_level(rising, falling, either)
    system = motion.system if isinstance(motion, Solution) else System.of(motion)
    events = [one.model_dump(exclude_none=True) for one in system.events]
    event = {"quantity": where, "value": level, "direction": direction, "name": CROSSING}
    watching = system.at({"events": [*events, event]})
    if isinstance(motion, Solution):
        span = [float(motion.t[0]), float(motion.t[-1])]
        run = simulate(watching.at(y0=motion.y[0]), model=motion.model, span=span)
    else:
        run = simulate(watching)
    start = float(run.t[0]) + _check_seconds(transient)
    met = [one for one in run.events if one.name == CROSSING and one.t >= start]
    t = np.array([one.t for one in met])
    y = np.array([one.y for one in met]).reshape(len(met), run.y.shape[1])
    piece = MotionSlice(run.model, run.system.p, y, t, timed=run.system.time_dependent_loads)
    data = {
        "t": ("crossing", t, {"units": "s"}),
        "phi": (("crossing", "link"), piece.values("phi"), {"units": "rad"}),
        "omega": (("crossing", "link"), piece.values("omega"), {"units": "rad/s"}),
        "tip": (("crossing", "axis"), piece.values("tip"), {"units": "m"}),
        "y": (("crossing", "state"), y),
    }
    said = {"where": where, "level": level, "direction": direction}
    return xarray.Dataset(data, {"axis": ["x", "y"]}, said)


def _check_level(*given: float | None) -> tuple[str, float]:
    """Check that one direction is given, and return it with its level."""
    levels = {
        way: to_plain(one, way) for way, one in zip(WAYS, given, strict=True) if one is not None
    }
    if len(levels) != 1:
        raise InputError(
            "section", list(levels) or None, f"one of {', '.join(WAYS)}, and its level"
        )
    ((direction, level),) = levels.items()
    if not (is_number(level) and np.isfinite(level)):
        raise InputError(direction, level, "a finite number, the level")
    return direction, float(level)


def _check_seconds(transient: float) -> float:
    made = to_plain(transient, "transient")
    if not (is_number(made) and 0 <= made < np.inf):
        raise InputError("transient", transient, "a time of at least 0 s")
    return float(made)


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
