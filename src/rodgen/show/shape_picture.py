"""Picture of the rod at several times of a run."""

from __future__ import annotations

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rodgen.arrays import Array, even_indices
from rodgen.integrate import Solution
from rodgen.show.canvas import ALONG, LINE, make_figure, set_limits
from rodgen.show.rod_marks import describe_marks, draw_marks

SHAPES = 12  # rods drawn in one picture
FAR = 20.0  # lengths, beyond which a rod is a dot on its way
MISSED = 0.3  # of how far the rod moves, that shapes may leave out between them
FURTHER = 1.1  # times as far as in the second half, from which the first is drawn


def shapes(solution: Solution) -> Figure:
    """Rod at twelve times, coloured by time; side by side where it flies so far that it would be a
    dot. Where it swings too often for twelve shapes of the whole run to show that, they are of a
    part of it."""
    figure = make_figure(6.0, 5.0)
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
    scene, samples = solution.scene, _choose_samples(solution)
    t, every, far = solution.t[samples], solution.joints[samples], solution.scene.rod.length
    apart = (
        scene.boundary_condition.translates and float(np.ptp(every, axis=(0, 1)).max()) > FAR * far
    )
    if apart:
        places = far * np.arange(len(t))
        centres = solution.centre_of_gravity[samples]
        every = every - (centres - np.stack((places, 0 * places), -1))[:, None]
        axes.set_xticks(places, [f"{time:.3g}" for time in t], fontsize="small")
    colours = ScalarMappable(Normalize(t[0], max(t[-1], 1e-300)), ALONG)
    for time, joints in zip(t, every, strict=True):
        colour = colours.to_rgba(time)
        axes.plot(*joints.T, "-", color=colour, linewidth=LINE)
        draw_marks(axes, scene, joints, colour, anchors=not apart)
    across = "shapes side by side, in the scale of y, at t [s]" if apart else "x [m]"
    up = "y from the centre of gravity [m]" if apart else "y [m]"
    axes.set(xlabel=f"{across}\n{describe_marks(scene, anchors=not apart)}", ylabel=up)
    axes.set_title(f"{scene.name}: shape{_describe_times(t, solution.t)}")
    fixed = [] if apart else [(tie.x, tie.y) for tie in scene.anchors.support_points]
    set_limits(axes, np.concatenate((every.reshape(-1, 2), np.reshape(fixed, (-1, 2)))))
    # A bar beside the axes would be higher than those of a flat rod.
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
    if len(t) < 2:
        return ""
    whole = t[0] == every[0] and t[-1] == every[-1]
    part = "" if whole else f" from {t[0]:.4g} to {t[-1]:.4g} s"
    return f"{part}, every {(t[-1] - t[0]) / (len(t) - 1):.3g} s"
