"""Natural frequencies from the Fourier transform of sampled motion, between its bins."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft, rfftfreq
from scipy.signal import detrend
from scipy.signal.windows import general_cosine

from rodgen.analyse.analysis_guard import check_positive, check_whole_number
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import AnalysisError, InputError, check_type
from rodgen.integrate import Solution
from rodgen.result import Result, Row

# Windows of maximal sidelobe decay, sin^(2 H - 2): their H cosine terms.
WINDOWS = {
    "hann": (1 / 2, 1 / 2),
    "sine4": (3 / 8, 1 / 2, 1 / 8),
    "sine6": (10 / 32, 15 / 32, 6 / 32, 1 / 32),
}
WINDOW = "sine6"  # finds a lone tone to 1e-5 bins, and one of 1e-6 times its neighbour's size

SAMPLES = 2.5  # a period of the lowest asked frequency: 2 are the limit of any sampling
UNIFORM = 1e-6  # of the sampling interval, its allowed scatter
NOISE = 12.0  # times the 10 % quantile of the spectrum: white noise of 1e5 samples stays below 10
ROUNDING = 1e-13  # of the largest sample: amplitudes below are its rounding
FLOOR = 1e-6  # of the largest amplitude: below are products of small motions, not modes
LEAKAGE = 3.0  # a peak is more than this times what stronger ones leave in its place
FOLDED = 0.2  # relative, by which rates may miss 2 pi f of a peak that is not folded back


@dataclass(frozen=True, repr=False)
class Spectrum(Result, Plottable):
    """The peaks of a spectrum, and the spectrum for a picture.

    frequencies (peaks,): of the peaks, rising [Hz]; amplitudes (peaks,): their sizes in the unit of
    the signal, root of the sum of squares over its channels; resolution: H / (N dt) [Hz], the half
    width of a peak down to its first zero, for a window of H terms and N samples; bins (bins,):
    frequencies of the spectrum [Hz]; density (bins,): of the whole signal, one-sided, in the unit
    of the signal squared over Hz.

    Two equal tones closer than the resolution may be one peak. At that distance they move each
    other by up to 0.9 ("hann"), 0.45 or 0.12 ("sine6") bins of 1 / (N dt), at twice that by 1e-2,
    6e-4 or 3e-5.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("ziegler").replace({"loads.follower.force": 0.0})
    >>> found = rodgen.spectrum(rodgen.simulate(scene, span=[0.0, 200.0], progress=False))
    >>> len(found.frequencies) == len(found.amplitudes), bool(found.resolution < 0.02)
    (True, True)
    """

    frequencies: Array
    amplitudes: Array
    resolution: float
    bins: Array = field(repr=False)
    density: Array = field(repr=False)

    ROWS = (
        Row("frequencies", "frequency", "Hz", along="peak"),
        Row("amplitudes", "amplitude", format=".6g", along="peak"),
        Row("resolution", "resolution", "Hz", ".3g"),
    )

    def __repr__(self) -> str:
        strongest = float(self.frequencies[self.amplitudes.argmax()])
        peaks = f"{len(self.frequencies)} peaks, the strongest at {strongest:.6g} Hz"
        return f"<Spectrum: {peaks}; resolution {self.resolution:.3g} Hz>"


def find_peaks(
    t: Array,
    signal: Array,
    *,
    lowest: float | None = None,
    peaks: int = 10,
    window: str = WINDOW,
    floor: float = FLOOR,
) -> Spectrum:
    """Find the strongest peaks of a signal (T,) or (T, channels) sampled uniformly at t (T,) [s].

    lowest: a frequency [Hz] that must be seen: 2 H of its periods, H = 2, 3, 4 for the windows
    "hann", "sine4", "sine6", and 2.5 samples in each. The linear trend is removed. A tone between
    two bins is found by the formula for these windows from the ratio r of the larger neighbour to
    the largest bin, (H r - H + 1) / (r + 1) bins: D. Belega and D. Dallet, Measurement 42 (2009)
    420-427. Peaks are above the noise, the leakage of stronger ones and ``floor`` times the
    strongest, and at least H bins from 0. Raises InputError for bad input, AnalysisError for
    a signal too short or too coarsely sampled, or without peaks.
    """
    if window not in WINDOWS:
        raise InputError("window", window, " or ".join(f'"{name}"' for name in WINDOWS))
    peaks = check_whole_number(peaks, "peaks", 1)
    if not 0 <= floor < 1:
        raise InputError("floor", floor, "a number of at least 0 and less than 1")
    H = len(WINDOWS[window])
    dt, x = _check_samples(t, signal)
    _check_length(dt, len(x), H, lowest)
    size = amplitude_spectrum(x, window)
    least = ROUNDING * float(np.linalg.norm(np.abs(x).max(axis=0)))
    at, offset = _strongest_peaks(size, H, peaks, max(least, floor * float(size[H:].max())))
    rising = np.argsort(at + offset)
    at, offset = at[rising], offset[rising]
    width = 1 / (len(x) * dt)
    return Spectrum(
        frequencies=(at + offset) * width,
        amplitudes=size[at] / _window_transform(np.abs(offset), H),
        resolution=H * width,
        bins=rfftfreq(len(x), dt),
        density=size**2 / (2 * width * _noise_bandwidth(window)),
    )


def amplitude_spectrum(x: Array, window: str) -> Array:
    """Amplitude of a tone on each bin (bins,), of a signal (T, channels) without its trend; root of
    the sum of squares over the channels."""
    terms = WINDOWS[window]
    weight = general_cosine(len(x), terms, sym=False)
    transform = rfft(detrend(x, axis=0) * weight[:, None], axis=0)
    return np.asarray(np.linalg.norm(transform, axis=1) * 2 / (len(x) * terms[0]))


def _noise_bandwidth(window: str) -> float:
    """Equivalent noise bandwidth of a window [bins]."""
    first, *others = WINDOWS[window]
    return 1 + sum(a**2 for a in others) / (2 * first**2)


def _check_samples(t: Array, signal: Array) -> tuple[float, Array]:
    """Check a signal; return its sampling interval and its samples (T, channels)."""
    t, x = np.asarray(t, dtype=float), np.asarray(signal, dtype=float)
    if t.ndim != 1 or x.ndim not in (1, 2) or len(x) != len(t):
        shape = f"an array (T,) or (T, channels) with T = {t.size}, the number of times"
        raise InputError("signal", f"array {x.shape}", shape)
    if not (np.isfinite(t).all() and np.isfinite(x).all()):
        raise InputError("signal", "nan or inf", "finite, and its times as well")
    if len(t) < 16:
        raise AnalysisError(f"spectrum of {len(t)} samples: at least 16 are needed")
    dt = float(t[-1] - t[0]) / (len(t) - 1)
    scatter = np.abs(np.diff(t) - dt)
    if not dt > 0 or scatter.max() > UNIFORM * dt + 8 * np.finfo(float).eps * np.abs(t).max():
        worst = int(np.argmax(scatter)) + 1
        rule = f"{dt:.9g} s after the sample before, like the others on the mean: uniform"
        raise InputError(f"t[{worst}]", float(t[worst]), rule)
    return dt, x.reshape(len(x), -1)


def _check_length(dt: float, count: int, H: int, lowest: float | None) -> None:
    if lowest is None:
        return
    lowest = check_positive(lowest, "lowest", "a finite number greater than 0")
    if count * dt * lowest < 2 * H * (1 - 1e-9):
        raise AnalysisError(
            f"signal of {count * dt:.6g} s is too short for {lowest:.6g} Hz: {2 * H} periods, "
            f"{2 * H / lowest:.6g} s, are needed with this window"
        )
    if lowest * dt * SAMPLES > 1:
        raise AnalysisError(
            f"samples every {dt:.6g} s are too coarse for {lowest:.6g} Hz: {SAMPLES} in a period, "
            f"one every {1 / (SAMPLES * lowest):.6g} s, are needed"
        )


def _window_transform(distance: Array, H: int) -> Array:
    """Transform of the window at a distance from a tone [bins], 1 at the tone; beyond the main lobe
    its envelope."""
    d = np.asarray(distance, dtype=float)
    inside = d < H
    # sinc / poles is 0 / 0 at whole distances: a shift of 1e-7 is within 1e-7 of the limit.
    d = np.where(inside & (np.abs(d - np.round(d)) < 1e-7), d + 1e-7, d)
    poles = np.prod(1 - (d / np.arange(1, H)[:, None]) ** 2, axis=0)
    numerator = np.where(inside, np.sinc(d), 1 / (np.pi * np.maximum(d, 1)))
    return np.asarray(np.abs(numerator / poles))


def _strongest_peaks(
    size: Array, H: int, most: int, least: float
) -> tuple[NDArray[np.int64], Array]:
    """Find the strongest peaks above ``least``: bins, and offsets of the tones from them [bins]."""
    inner = np.arange(H, len(size) - 1)
    tops = inner[(size[inner] >= size[inner - 1]) & (size[inner] > size[inner + 1])]
    level = max(NOISE * float(np.quantile(size[H:], 0.1)), least)
    tops = tops[size[tops] > level]
    found: list[tuple[int, float]] = []
    everywhere = np.arange(len(size), dtype=float)
    leaked = size[:2].max() * _window_transform(everywhere, H)  # what the trend has left
    for k in tops[np.argsort(-size[tops])]:
        if size[k] <= LEAKAGE * leaked[k]:
            continue
        up = 1 if size[k + 1] >= size[k - 1] else -1
        r = size[k + up] / size[k]
        offset = float(np.clip((H * r - H + 1) / (r + 1), 0, 0.5)) * up
        found.append((int(k), offset))
        shape = _window_transform(np.abs(everywhere - k - offset), H)
        leaked += size[k] * shape / shape[k]
        if len(found) == most:
            break
    if not found:
        raise AnalysisError(
            f"no peak in {len(size)} bins: the largest amplitude is {size[H:].max():.3g}; peaks "
            f"are above {level:.3g}, for noise and rounding, and above the leakage of a trend"
        )
    bins, offsets = zip(*found, strict=True)
    return np.array(bins), np.array(offsets)


def spectrum(
    solution: Solution,
    *,
    lowest: float | None = None,
    peaks: int = 10,
    window: str = WINDOW,
    floor: float = FLOOR,
) -> Spectrum:
    """Return the natural frequencies in a run, from displacements across the rod's axis.

    Displacements of a free rod are taken from its principal axes of inertia through its centre of
    gravity, those of a held rod from its mean shape. The power of all joints is added, so that no
    node hides a mode.

    Parameters
    ----------
    solution
        A run with samples at equal times.
    lowest
        Lowest frequency [Hz] at which a peak is looked for.
    peaks
        Largest number of peaks.
    window
        "hann", "sine4" or "sine6".
    floor
        Amplitude of the faintest peak, as a share of the largest (dimensionless).

    Returns
    -------
    Spectrum
        Frequencies [Hz] and amplitudes [m] of the peaks, and the spectrum for a picture.

    Raises
    ------
    AnalysisError
        If the run is too short, or if the samples are so far apart that the frequency of a peak
        would be folded back.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("ziegler").replace({"loads.follower.force": 0.0})
    >>> sol = rodgen.simulate(scene, span=[0.0, 200.0], progress=False)
    >>> found, modes = rodgen.spectrum(sol), rodgen.natural_modes(scene, count=1)
    >>> bool(abs(found.frequencies[0] / modes.frequencies[0] - 1) < 1e-2)
    True
    """
    check_type("solution", solution, Solution, see="simulate")
    solution = _drop_last_if_nonuniform(solution)
    across = (
        _across_principal_axis(solution)
        if solution.scene.boundary_condition.translates
        else _across_mean_shape(solution)
    )
    found = find_peaks(solution.t, across, lowest=lowest, peaks=peaks, window=window, floor=floor)
    _check_aliasing(solution, found, window)
    return found


def _drop_last_if_nonuniform(solution: Solution) -> Solution:
    """Drop the last sample if it is that of the end of the run, between two samples."""
    t = solution.t
    if len(t) > 2 and t[-1] - t[-2] < 0.999 * (t[1] - t[0]):
        return solution.head(len(t) - 1)
    return solution


def _across_principal_axis(solution: Solution) -> Array:
    """Displacements of joints across the axis of the smaller moment of inertia, (T, n+1)."""
    angle = np.unwrap(solution.principal_axes.angle, period=np.pi)
    r = solution.joints - solution.centre_of_gravity[:, None]
    return np.asarray(np.cos(angle)[:, None] * r[..., 1] - np.sin(angle)[:, None] * r[..., 0])


def _across_mean_shape(solution: Solution) -> Array:
    """Displacements of joints across the mean shape, from their places in it, (T, n+1)."""
    links = np.unwrap(solution.phi, axis=0).mean(axis=0)
    ends = np.concatenate((links[:1], (links[1:] + links[:-1]) / 2, links[-1:]))
    r = solution.joints - solution.joints.mean(axis=0)
    return np.asarray(np.cos(ends) * r[..., 1] - np.sin(ends) * r[..., 0])


def _check_aliasing(solution: Solution, found: Spectrum, window: str) -> None:
    """Raise AnalysisError for a peak that is aliased: sampling folds a frequency f above half its
    rate back, but rates of angles stay 2 pi f times the angles, and their ratio tells f."""
    phi, omega = solution.phi, solution.omega
    if solution.scene.boundary_condition.translates:  # rigid rotation says nothing about bending
        phi, omega = np.diff(phi, axis=1), np.diff(omega, axis=1)
    size, rate = amplitude_spectrum(phi, window), amplitude_spectrum(omega, window)
    half = float(found.bins[-1])
    for f in found.frequencies:
        at = round(f / found.bins[1])
        # A tone that the angles lack comes from the geometry of others; their leak says nothing.
        if size[at] < max(size[at - 1], size[at + 1 : at + 2].max(initial=0.0)) / 2 or not size[at]:
            continue
        true = float(rate[at] / size[at]) / (2 * np.pi)
        if abs(true / f - 1) > FOLDED and true > half * (1 - FOLDED):
            raise AnalysisError(
                f"samples every {solution.t[1] - solution.t[0]:.6g} s are too coarse: the peak at "
                f"{f:.6g} Hz is one of about {true:.3g} Hz folded back; one every "
                f"{1 / (SAMPLES * true):.3g} s is needed (output_every), or a larger floor, which "
                "leaves faint peaks out"
            )
