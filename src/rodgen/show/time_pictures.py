"""Pictures of a run over time (tail with its spectrum, bending moments along the rod) and of the
rod at several times."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rodgen.analyse.spectrum import UNIFORM, amplitude_spectrum
from rodgen.arrays import Array, even_indices
from rodgen.integrate import Solution
from rodgen.show.canvas import (
    ALONG,
    CURVE,
    LINE,
    MOMENTS,
    ROOMY,
    add_legend,
    add_remark,
    label_ordinate,
    leave_empty,
    line_or_dot,
    make_axes,
    make_pair,
    moment_norm,
    set_limits,
    set_title,
    width_of,
)
from rodgen.show.event_marks import mark_times
from rodgen.show.marks import describe_marks, draw_marks, moves_root, start_name

WINDOW = "hann"
FEWEST_SAMPLES = 16  # samples of a spectrum
MAP_COLUMNS = 1200  # of moments over time: more cannot be told apart

SHAPES = 12  # rods drawn in one picture
FAR_FLIGHT = 20.0  # lengths, beyond which a rod is a dot on its way
MISSED = 0.3  # of how far the rod moves, that shapes may leave out between them
FURTHER = 1.1  # times as far as in the second half, from which the first is drawn


def tail_history(solution: Solution) -> Figure:
    """Distance of the tail from the line of the rod's start over time, and its spectrum."""
    figure, (first, second) = make_pair(7.4, 3.4)
    signal = solution.values("tail_deflection")
    first.plot(solution.t, signal, line_or_dot(signal), color=CURVE, linewidth=0.8)
    first.set(xlabel="t [s]")
    stacked = 1 + (width_of(figure) < ROOMY)
    label_ordinate(first, f"tail across the {start_line(solution)} [m]", stacked)
    set_title(figure, f"{solution.scene.name}: tail")
    mark_times(first, solution)
    even, steps = _uniform_samples(solution)
    if len(even) >= FEWEST_SAMPLES and np.ptp(signal) > 0:
        found = amplitude_spectrum(signal[even][:, None], WINDOW)
        frequencies = np.fft.rfftfreq(len(even), steps)
        second.semilogy(frequencies[1:], found[1:], color=CURVE, linewidth=0.8)
        second.set(xlabel=f"frequency [Hz], {WINDOW.capitalize()} window", ylabel="amplitude [m]")
    else:
        leave_empty(second, "no spectrum: too few samples")
        second.set_axis_off()
    add_legend(figure)
    return figure


def start_line(solution: Solution) -> str:
    """Return what the line is from which the deflection of the tail is measured."""
    return "clamp" if solution.scene.boundary_condition.is_clamped else "first link"


def _uniform_samples(solution: Solution) -> tuple[NDArray[np.int64], float]:
    """Return the first samples at equal intervals, by number, and the interval [s]."""
    steps = np.diff(solution.t)
    if not len(steps):
        return np.arange(len(solution.t)), 1.0
    other = np.flatnonzero(np.abs(steps - steps[0]) > UNIFORM * steps[0])
    return np.arange(int(other[0]) + 1 if len(other) else len(solution.t)), float(steps[0])


def moment_map(solution: Solution) -> Figure:
    """Bending moment over time and along the rod."""
    figure, (axes,) = make_axes(6.4, 4.4)
    kept = even_indices(0, len(solution.t) - 1, MAP_COLUMNS)
    found = solution.bending_moments[kept]
    set_title(figure, f"{solution.scene.name}: bending moment")
    if not solution.bending_moments.any():  # of a chain
        leave_empty(axes, "none anywhere, at any time")
        axes.set_axis_off()
        return figure
    limit = float(np.abs(found).max())
    s = solution.scene.mesh.places
    t = solution.t[kept]
    how: dict[str, Any] = {"cmap": MOMENTS, "norm": moment_norm(limit), "rasterized": True}
    coloured: ScalarMappable
    if len(t) > 1:
        coloured = axes.pcolormesh(t, s, found.T, shading="nearest", **how)
    else:  # there is no time between samples that an area could have
        coloured = axes.scatter(np.full(len(s), t[0]), s, c=found[0], clip_on=False, **how)
    along = f"s along the rod (0: {start_name(solution.scene)}, 1: tail)"
    axes.set(xlabel="t [s]", ylabel=along, ylim=(0.0, 1.0))
    figure.colorbar(coloured, ax=axes, label="bending moment [N m]")
    mark_times(axes, solution)
    add_legend(figure)
    return figure


def shapes(solution: Solution) -> Figure:
    """Rod at twelve times, coloured by time; side by side where it flies so far that it would be a
    dot. Where it swings too often for twelve shapes of the whole run to show that, they are of a
    part of it."""
    figure, (axes,) = make_axes(6.0, 5.0)
    scene, samples = solution.scene, _choose_samples(solution)
    t, every, far = solution.t[samples], solution.joints[samples], solution.scene.rod.length
    goes = scene.boundary_condition.translates or moves_root(scene)
    apart = goes and float(np.ptp(every, axis=(0, 1)).max()) > FAR_FLIGHT * far
    if apart:
        places = far * np.arange(len(t))
        centres = solution.centre_of_gravity[samples]
        every = every - (centres - np.stack((places, 0 * places), -1))[:, None]
    colours = ScalarMappable(Normalize(t[0], max(t[-1], 1e-300)), ALONG)
    for time, joints in zip(t, every, strict=True):
        colour = colours.to_rgba(time)
        axes.plot(*joints.T, "-", color=colour, linewidth=LINE)
        draw_marks(axes, scene, joints, colour, not apart, time)
    across = "shapes side by side, in the scale of y, at t [s]" if apart else "x [m]"
    up = "y from the centre of gravity [m]" if apart else "y [m]"
    axes.set(xlabel=across)
    add_remark(axes, describe_marks(scene, anchors=not apart))
    set_title(figure, f"{scene.name}: shapes")
    add_remark(axes, _describe_times(t, solution.t))
    fixed = [] if apart else [(tie.x, tie.y) for tie in scene.anchors.support_points]
    set_limits(axes, np.concatenate((every.reshape(-1, 2), np.reshape(fixed, (-1, 2)))))
    label_ordinate(axes, up)
    if apart:  # as many times as there is room for
        some = slice(None, None, -(-len(t) // int(3 * width_of(figure))))
        axes.set_xticks(places[some], [f"{time:.3g}" for time in t[some]])
    if len(t) > 1:  # a bar beside the axes would be higher than those of a flat rod
        figure.colorbar(colours, cax=axes.inset_axes((1.03, 0.0, 0.03, 1.0)), label="t [s]")
    return figure


def _choose_samples(solution: Solution) -> NDArray[np.int_]:
    """Choose the samples that are drawn: of the whole run; where more happens between them than
    they show, of the half in which the rod moves further, or of a half of that, and so on."""
    way = solution.joints[:, [solution.joints.shape[1] // 2, -1]].reshape(len(solution.t), -1)
    whole = first, last = 0, len(way) - 1
    while last - first >= 2 * SHAPES:
        samples = even_indices(first, last, SHAPES)
        if _interpolation_error(way, samples) <= MISSED:
            return samples
        middle = (first + last) // 2
        before, after = _path_length(way[first : middle + 1]), _path_length(way[middle : last + 1])
        first, last = (first, middle) if before > FURTHER * after else (middle, last)
    return even_indices(*whole, SHAPES)


def _path_length(way: Array) -> float:
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


def _interpolation_error(way: Array, samples: NDArray[np.int_]) -> float:
    """Return the error of points of the rod (T, coordinates) interpolated between samples, over
    their distance from their mean: both are root mean squares."""
    every = np.arange(samples[0], samples[-1] + 1)
    seen = np.stack([np.interp(every, samples, part[samples]) for part in way.T], -1)
    there = way[every]
    moved = float(np.linalg.norm(there - there.mean(axis=0)))
    return float(np.linalg.norm(there - seen)) / (moved or 1.0)


def _describe_times(t: Array, every: Array) -> str:
    """Describe the time between shapes, and the part of the run that they are of."""
    if len(t) == 1:
        return f"at t = {t[0]:.4g} s"
    whole = t[0] == every[0] and t[-1] == every[-1]
    part = "" if whole else f"from {t[0]:.4g} to {t[-1]:.4g} s, "
    return f"{part}every {(t[-1] - t[0]) / (len(t) - 1):.3g} s"
