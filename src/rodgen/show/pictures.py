"""Pictures of a run, made for print."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from rodgen.integrate import Solution
from rodgen.model.terms import TERMS, words_of
from rodgen.scene import Scene
from rodgen.show.canvas import (
    ALONG,
    BED,
    CENTRE,
    CURVE,
    FAINT,
    FIXED,
    INK,
    LINE,
    PAPER,
    SERIES,
    SPECIAL,
    TAIL,
    canvas,
)
from rodgen.show.time_pictures import NAMED, acting, mark_times, moments, tail

SHAPES = 12  # rods drawn in one picture
FAR = 20.0  # lengths, beyond which a rod is a dot on its way
LONG = 25.0  # sides of its picture, beyond which a path is drawn thin
DOTS_PER_INCH = 200
SLIVER = 0.05  # width over length
DISC = 16.0  # points across: of a body that is the whole mass
SHARP, MOST_SHARP = 0.5, 0.25  # cosine of a turn of 60 degrees; share of turns beyond in a curve
DASHES = (0, (4, 2)), (0, (4, 2, 1, 2)), (0, (1, 1))  # of works
# Of a word over a curve.
BEHIND = {"boxstyle": "square,pad=0.1", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8}
LARGEST = 1e12  # of any state: beyond, nothing of the picture can be read


def save_pictures(solution: Solution, folder: Path) -> list[Path]:
    """Write every picture of a run as PNG into a folder that exists; returns the files.

    Of a run that blew up only what can be drawn is drawn.
    """
    shown = drawable(solution)
    if not len(shown.t):
        return []
    return save_figures(((name, draw(shown)) for name, draw in PICTURES.items()), folder)


def drawable(solution: Solution) -> Solution:
    """The run before it blew up, without samples where it did so at once."""
    beyond = np.flatnonzero(np.abs(solution.y).max(axis=1) > LARGEST)
    return solution.until(int(beyond[0])) if len(beyond) else solution


def save_figures(figures: Iterable[tuple[str, Figure]], folder: Path) -> list[Path]:
    """Write figures by name as PNG into a folder that exists: all of them, whole, or none."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".pictures") as making:
        made = []
        for name, figure in figures:
            made.append(Path(making) / f"{name}.png")
            figure.savefig(made[-1], dpi=DOTS_PER_INCH, bbox_inches="tight")
        return [picture.replace(folder / picture.name) for picture in made]


def shapes(solution: Solution) -> Figure:
    """The rod at several times, coloured by time; one that has flown so far that it would be a dot,
    each shape beside the one before."""
    figure, axes = _figure(6.0, 5.0)
    times = np.unique(np.linspace(0, len(solution.t) - 1, SHAPES).round().astype(int))
    every, far = solution.joints[times], solution.scene.rod.length
    way = float(np.ptp(every, axis=(0, 1)).max())
    apart = solution.scene.hold.translates and way > FAR * far
    if apart:
        centres = solution.centre_of_gravity[times][:, None]
        every = every - centres + far * np.stack((np.arange(len(times)), 0 * times), -1)[:, None]
    colours = ScalarMappable(Normalize(solution.t[0], max(solution.t[-1], 1e-300)), ALONG)
    for at, joints in zip(times, every, strict=True):
        x, y = joints.T
        colour = colours.to_rgba(solution.t[at])
        axes.plot(x, y, "-", color=colour, linewidth=LINE)
        axes.plot(x[0], y[0], "o", color=colour, markersize=3.5)
        draw_bodies(axes, solution.scene, joints, colour)
        if not apart:
            draw_anchors(axes, solution.scene, joints, colour)
    bodies = "; discs: bodies, by mass" * bool(solution.scene.bodies)
    legend = f"dot: {first_end(solution.scene)}{bodies}"
    beside = " from the centre of gravity, each shape beside the one before" * apart
    across = " from the centre of gravity" * apart
    axes.set(xlabel=f"x{beside} [m]\n{legend}", ylabel=f"y{across} [m]")
    axes.set_title(f"{solution.scene.name}: shape")
    fixed = [] if apart else [(tie.x, tie.y) for tie in solution.scene.anchors.ties]
    frame(axes, np.concatenate((every.reshape(-1, 2), np.reshape(fixed, (-1, 2)))))
    figure.colorbar(colours, ax=axes, label="t [s]")
    return figure


def first_end(scene: Scene) -> str:
    """What joint 0 is called."""
    return "nose" if scene.hold.support == "none" else "root"


def draw_anchors(axes: Axes, scene: Scene, joints: np.ndarray, colour: Any) -> None:
    """Supports as dotted lines to triangles, where they are fixed; a foundation as a broad line."""
    anchors = scene.anchors
    axes.plot(*anchors.bed.T, "-", color=BED, linewidth=6 * LINE, zorder=0)
    for tie in anchors.ties:
        axes.plot(*tie.way(joints).T, ":", color=colour, linewidth=LINE)
        axes.plot(tie.x, tie.y, "^", color=FIXED, markersize=7)


def draw_bodies(axes: Axes, scene: Scene, joints: np.ndarray, colour: Any) -> None:
    """Bodies as discs, their areas by their masses, on a rod whose joints are at (n+1, 2)."""
    for mark in scene.distribution.marks:
        place = mark.places(joints)
        axes.plot(*place, "o", color=colour, alpha=0.6, markersize=DISC * mark.size)


def trajectories(solution: Solution) -> Figure:
    """Paths of the centre of gravity and of the tail."""
    figure, axes = _figure(6.0, 5.0)
    paths = {"tail": solution.tip, "centre of gravity": solution.centre_of_gravity}
    for (name, path), line, colour in zip(paths.items(), ("--", "-"), (TAIL, CENTRE), strict=True):
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        thin = steps > LONG * np.ptp(path, axis=0).max()  # of one that goes to and fro, no dashes
        style = ("-", LINE / 4) if thin else (line, LINE)
        axes.plot(*path.T, style[0], color=colour, label=name, linewidth=style[1])
        axes.plot(*path[0], "o", color=colour, markersize=4)
    _say(axes, solution)
    axes.set(
        xlabel="x [m]", ylabel="y [m]", title=f"{solution.scene.name}: trajectories (dot: start)"
    )
    frame(axes, np.concatenate(list(paths.values())))
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _say(axes: Axes, solution: Solution) -> None:
    """Say on the path of the centre of gravity where forces begin or end to act, and what
    happened."""
    ends = (solution.t[0], solution.t[-1])
    said = [(event.t, event.name) for event in solution.events]
    for term, start, end in acting(solution):
        said += [(t, f"{term.label} {what}") for t, what in ((start, "begins"), (end, "ends"))]
    path = solution.centre_of_gravity
    for t, words in said[:NAMED]:
        if ends[0] < t < ends[1]:
            x, y = (float(np.interp(t, solution.t, part)) for part in path.T)
            axes.plot(x, y, "D", color=FAINT, markersize=4)
            style: dict[str, Any] = {"fontsize": "x-small", "color": FAINT, "bbox": BEHIND}
            axes.annotate(words, (x, y), (7, -3), textcoords="offset points", **style)


def energies(solution: Solution) -> Figure:
    """Energies and work over time; below, by how much they do not balance."""
    figure = canvas(6.0, 6.0)
    axes, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    t, energy = solution.t, solution.energy
    axes.plot(t, energy.kinetic, color=SERIES[0], label="kinetic", linewidth=LINE)
    if energy.spring.any():
        axes.plot(t, energy.spring, color=SERIES[2], label="springs", linewidth=LINE)
    if "gravity" in solution.scene.loads.terms:
        colour = TERMS["gravity"].colours[0]
        axes.plot(t, energy.gravity, color=colour, label="gravity", linewidth=LINE)
    axes.plot(t, energy.total, color=INK, label="total", linewidth=LINE)
    for (name, work), dashes in zip(solution.work.items(), cycle(DASHES), strict=False):
        label = f"work of {words_of(name)}"
        colour = TERMS[name].colours[0] if name in TERMS else FAINT
        axes.plot(t, work, linestyle=dashes, color=colour, label=label, linewidth=LINE)
    mark_times(axes, solution)
    axes.set(ylabel="energy [J]", title=f"{solution.scene.name}: energies and work")
    axes.grid(alpha=0.3)
    figure.legend(fontsize="small", loc="outside lower center", ncols=3)
    error = np.abs(solution.energy_balance)
    if np.any(error > 0):
        below.semilogy(t, np.where(error > 0, error, np.nan), color=INK, linewidth=0.8)
    below.set(xlabel="t [s]", ylabel="|balance error| [J]")
    below.grid(alpha=0.3)
    return figure


def phase_plot(solution: Solution) -> Figure:
    """How far the rod is bent against how fast it bends: tail link relative to first link."""
    figure, axes = _figure(6.0, 5.0)
    if solution.scene.rod.links > 1:
        angle = solution.phi[:, -1] - solution.phi[:, 0]
        rate = solution.omega[:, -1] - solution.omega[:, 0]
        labels = (r"$\varphi_{n-1}-\varphi_0$ [rad]", r"$\omega_{n-1}-\omega_0$ [rad/s]")
    else:
        angle, rate = solution.phi[:, 0], solution.omega[:, 0]
        labels = (r"$\varphi_0$ [rad]", r"$\omega_0$ [rad/s]")
    joined = _is_curve(angle, rate)
    axes.plot(angle, rate, "-" if joined else ".", linewidth=0.8, markersize=1.5, color=CURVE)
    axes.plot(angle[0], rate[0], "o", markersize=4, color=INK, label="start")
    axes.plot(angle[-1], rate[-1], "s", markersize=5, color=SPECIAL, label="end")
    apart = "" if joined else " (samples: too far apart for a curve)"
    axes.set(xlabel=labels[0], ylabel=labels[1], title=f"{solution.scene.name}: phase plot{apart}")
    axes.legend()
    return figure


def _is_curve(x: np.ndarray, y: np.ndarray) -> bool:
    """Whether lines between samples follow the motion: where these are too far apart, most turn
    back sharply."""
    steps = np.stack([np.diff(v) / (np.ptp(v) or 1.0) for v in (x, y)], axis=-1)
    before, after = steps[:-1], steps[1:]
    sizes = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    moving = sizes > 1e-12
    back = (before * after).sum(axis=1)[moving] < SHARP * sizes[moving]
    return not moving.any() or float(back.mean()) < MOST_SHARP


PICTURES: dict[str, Callable[[Solution], Figure]] = {
    "shape": shapes,
    "trajectory": trajectories,
    "energy": energies,
    "phase": phase_plot,
    "tail": tail,
    "moment": moments,
}


def _figure(width: float, height: float) -> tuple[Figure, Axes]:
    figure = canvas(width, height)
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
    return figure, axes


def frame(axes: Axes, points: np.ndarray) -> None:
    """Equal scales, unless the picture would be a sliver in which nothing is seen."""
    flat = points.reshape(-1, 2)
    low, high = flat.min(axis=0), flat.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    equal = half.min() > SLIVER * half.max() or half.min() < 1e-9 * half.max()
    least = half.max() * 0.4 if equal else 0.0
    half = 1.05 * np.maximum(half, max(least, 1e-9))
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    if equal:
        axes.set_aspect("equal")
    else:
        axes.set_title(axes.get_title() + ", scales differ")
