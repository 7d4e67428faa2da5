"""Natural frequencies from a simulation, by the Fourier transform of its motion."""

from __future__ import annotations

import numpy as np

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.tones import FLOOR, SAMPLES, WINDOW, Spectrum, amplitudes_of, peaks_of
from rodgen.integrate import Solution
from rodgen.integrate.stepper import Array
from rodgen.scene.errors import check_type

__all__ = ["Spectrum", "peaks_of", "spectrum"]

FOLDED = 0.2  # relative, by which rates may miss 2 pi f of a peak that is not folded back


def spectrum(
    solution: Solution,
    *,
    lowest: float | None = None,
    peaks: int = 10,
    window: str = WINDOW,
    floor: float = FLOOR,
) -> Spectrum:
    """Natural frequencies of a rod from the motion of its joints across its axis [m].

    A free rod is seen from its principal axes of inertia through its centre of gravity, a held one
    from its mean shape; the power of all joints is added, so that no node hides a mode. Keywords
    and errors are those of peaks_of; AnalysisError too where the rates of the links show that the
    samples are too far apart for a peak, so that its frequency would be folded back.
    """
    check_type("solution", solution, Solution, see="simulate")
    solution = _even(solution)
    across = _local(solution) if solution.scene.hold.translates else _from_mean(solution)
    found = peaks_of(solution.t, across, lowest=lowest, peaks=peaks, window=window, floor=floor)
    _must_not_fold(solution, found, window)
    return found


def _even(solution: Solution) -> Solution:
    """Without the last sample where the end of the run, between two samples, has made it."""
    t = solution.t
    if len(t) > 2 and t[-1] - t[-2] < 0.999 * (t[1] - t[0]):
        return solution.until(len(t) - 1)
    return solution


def _local(solution: Solution) -> Array:
    """Joints across the axis of the smaller moment of inertia, (T, n+1)."""
    angle = np.unwrap(solution.principal_axes.angle, period=np.pi)
    r = solution.joints - solution.centre_of_gravity[:, None]
    return np.asarray(np.cos(angle)[:, None] * r[..., 1] - np.sin(angle)[:, None] * r[..., 0])


def _from_mean(solution: Solution) -> Array:
    """Joints across the mean shape, from where they are in it, (T, n+1)."""
    links = np.unwrap(solution.phi, axis=0).mean(axis=0)
    ends = np.concatenate((links[:1], (links[1:] + links[:-1]) / 2, links[-1:]))
    r = solution.joints - solution.joints.mean(axis=0)
    return np.asarray(np.cos(ends) * r[..., 1] - np.sin(ends) * r[..., 0])


def _must_not_fold(solution: Solution, found: Spectrum, window: str) -> None:
    """Sampling folds a frequency f above half its rate back, but rates of angles stay 2 pi f times
    the angles: at each peak their ratio must tell the peak's own frequency."""
    phi, omega = solution.phi, solution.omega
    if solution.scene.hold.translates:  # rigid rotation says nothing about bending
        phi, omega = np.diff(phi, axis=1), np.diff(omega, axis=1)
    size, rate = amplitudes_of(phi, window), amplitudes_of(omega, window)
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
