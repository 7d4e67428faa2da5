"""Pictures of a run over time: the tail with its spectrum, bending moments along the rod; and marks
on the time axis: when forces act that do not always act, and events."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rodgen.analyse.spectrum import amplitude_spectrum
from rodgen.arrays import Array, even_indices
from rodgen.integrate import Solution
from rodgen.model.rod import CLAMP_ANGLE
from rodgen.model.term import FORCE, SPREAD, Term
from rodgen.model.terms import TERMS
from rodgen.show.canvas import CURVE, FAINT, MOMENTS, make_figure

WINDOW = "hann"
SHORTEST = 16  # samples of a spectrum
COLUMNS = 1200  # of moments over time: more cannot be told apart
EVEN = 1e-6  # of the time between samples, by which it may differ
NAMED = 12  # events with names


def tail_history(solution: Solution) -> Figure:
    """Distance of the tail from the line of the rod's start over time, and its spectrum below."""
    figure = make_figure(6.4, 5.6)
    above, below = figure.subplots(2, 1)
    signal = tail_deflection(solution)
    above.plot(solution.t, signal, color=CURVE, linewidth=0.8)
    start = "clamp" if solution.scene.boundary_condition.is_clamped else "first link"
    above.set(
        xlabel="t [s]",
        ylabel=f"tail across the {start} [m]",
        title=f"{solution.scene.name}: tail",
    )
    mark_times(above, solution)
    even, steps = _uniform_samples(solution)
    if len(even) >= SHORTEST and np.ptp(signal) > 0:
        found = amplitude_spectrum(signal[even][:, None], WINDOW)
        frequencies = np.fft.rfftfreq(len(even), steps)
        below.semilogy(frequencies[1:], found[1:], color=CURVE, linewidth=0.8)
        below.set(xlabel=f"frequency [Hz], {WINDOW.capitalize()} window", ylabel="amplitude [m]")
    else:
        below.text(0.5, 0.5, "no spectrum: too few samples", ha="center", va="center")
        below.set_axis_off()
    for axes in (above, below):
        axes.grid(alpha=0.3)
    return figure


def tail_deflection(solution: Solution) -> Array:
    """Return the distance of the tail from the line of the rod's start, positive to its left [m],
    (T,): of the clamp, or of the first link."""
    scene, joints = solution.scene, solution.joints
    clamp = getattr(scene.rod, CLAMP_ANGLE.key) or 0.0
    angle = (
        np.full(len(solution.t), clamp)
        if scene.boundary_condition.is_clamped
        else solution.phi[:, 0]
    )
    dx, dy = (joints[:, -1] - joints[:, 0]).T
    found: Array = dy * np.cos(angle) - dx * np.sin(angle)
    return found


def _uniform_samples(solution: Solution) -> tuple[NDArray[np.int64], float]:
    """Return the first samples at equal intervals, by number, and the interval [s]."""
    steps = np.diff(solution.t)
    if not len(steps):
        return np.arange(len(solution.t)), 1.0
    other = np.flatnonzero(np.abs(steps - steps[0]) > EVEN * steps[0])
    return np.arange(int(other[0]) + 1 if len(other) else len(solution.t)), float(steps[0])


def moment_map(solution: Solution) -> Figure:
    """Bending moment over time and along the rod."""
    figure = make_figure(6.4, 4.4)
    axes = figure.add_subplot()
    kept = even_indices(0, len(solution.t) - 1, COLUMNS)
    found = solution.bending_moments[kept]
    axes.set_title(f"{solution.scene.name}: bending moment")
    if not has_bending(solution):
        axes.text(0.5, 0.5, "none anywhere, at any time", ha="center", va="center")
        axes.set_axis_off()
        return figure
    limit = float(np.abs(found).max())
    s = np.linspace(0.0, 1.0, found.shape[1])
    mesh = axes.pcolormesh(
        solution.t[kept],
        s,
        found.T,
        cmap=MOMENTS,
        vmin=-limit,
        vmax=limit,
        shading="nearest" if len(kept) > 1 else "auto",
        rasterized=True,
    )
    axes.set(
        xlabel="t [s]",
        ylabel="s along the rod (1: tail)",
        ylim=(0.0, 1.0),
    )
    mark_times(axes, solution)
    figure.colorbar(mesh, ax=axes, label="bending moment [N m]")
    return figure


def has_bending(solution: Solution) -> bool:
    """Whether there is any bending moment: a chain has none."""
    return bool(solution.bending_moments.any())


def mark_times(axes: Axes, solution: Solution) -> None:
    """Mark on a time axis when forces act that do not always act, and when events happened."""
    for term, start, end in force_intervals(solution):
        colour = term.colours[0]
        axes.axvspan(start, end, ymax=0.03, color=colour, alpha=0.7, linewidth=0)
        axes.annotate(
            f"{term.label} acts",
            (start, 0.035),
            xycoords=("data", "axes fraction"),
            fontsize="x-small",
            color=colour,
        )
    for event in solution.events:
        axes.axvline(event.t, color=FAINT, linewidth=0.8, linestyle=":")
    for event in solution.events[:NAMED]:
        axes.annotate(
            f" {event.name}",
            (event.t, 0.99),
            xycoords=("data", "axes fraction"),
            rotation=90,
            va="top",
            ha="right",
            fontsize="x-small",
            color=FAINT,
        )


def force_intervals(solution: Solution) -> Iterator[tuple[Term, float, float]]:
    """Yield the forces that act for some of the time, with start and end of each interval [s]."""
    for name in solution.scene.loads.terms:
        term = TERMS[name]
        if term.kind not in (FORCE, SPREAD):
            continue
        acts = np.abs(solution.forces[name]).sum(axis=(1, 2)) > 0
        if acts[1:-1].all() or not acts.any():  # where it grows from zero, it acts throughout
            continue
        edges = np.flatnonzero(np.diff(np.concatenate(([0], acts, [0]))))
        for first, beyond in zip(edges[::2], edges[1::2], strict=True):
            end = min(int(beyond), len(acts) - 1)
            yield term, float(solution.t[max(int(first) - 1, 0)]), float(solution.t[end])
