"""Pictures of a run, made for print."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rodgen.arrays import Array
from rodgen.errors import EmptyPictureError, InputError
from rodgen.integrate import RunError, Solution
from rodgen.model.quantities import TURNS
from rodgen.model.term import COUPLE
from rodgen.model.terms import TERMS, describe
from rodgen.show.canvas import (
    CENTRE,
    CURVE,
    INK,
    LINE,
    PAPER,
    SERIES,
    SPECIAL,
    TAIL,
    add_legend,
    add_remark,
    leave_empty,
    line_or_dot,
    make_axes,
    set_limits,
    set_title,
    show_decades,
)
from rodgen.show.envelope import envelope
from rodgen.show.event_marks import mark_path, mark_times
from rodgen.show.marks import moves_root, start_name
from rodgen.show.picture_files import save_figures
from rodgen.show.picture_settings import FORMATS, PictureSettings
from rodgen.show.time_pictures import (
    moment_map,
    shapes,
    start_line,
    tail_history,
)

LONG = 10.0  # sides of its picture, beyond which a path goes to and fro: thin, without rings
RINGS = 10  # steps between them, at most
WORK_DASHES = (0, (4, 2)), (0, (4, 2, 1, 2)), (0, (1, 1))  # of works
LARGEST_DRAWN = 1e12  # of any state: beyond, nothing of the picture can be read

BEND = np.cos(np.radians(12))  # of a turn from line to line, beyond which it is seen as a corner
SEEN_CORNER = 0.004  # of the picture: the longer line at a corner that is seen
SHARP, MOST_SHARP = 0.5, 0.25  # cosine of a turn of 60 degrees; share of turns beyond in a curve
PARTS, ROUNDS = 4, 3  # into which a step is divided where the curve has a corner; how often
MOST = 2000  # steps that are divided at a time: each costs up to a millisecond


def phase_plot(solution: Solution) -> Figure:
    """Phase plot: how far the tail is aside over how fast it moves there; of a single link, its
    angle. States between samples are computed where lines between these would have corners."""
    figure, (axes,) = make_axes(6.0, 5.0)
    if solution.scene.rod.links > 1:
        across = f"tail across the {start_line(solution)}"
        labels = (f"{across} [m]", f"rate of the {across} [m/s]")
    else:
        labels = ("angle less whole turns [rad]", "rate of the angle [rad/s]")
    shown, smooth = _refine(solution)
    angle, rate = _position_and_rate(shown)
    cosines, _ = _turn_cosines(angle, rate)
    sharp = float((cosines < SHARP).sum()) / max(np.isfinite(cosines).sum(), 1)
    joined = sharp < MOST_SHARP
    if solution.scene.rod.links == 1:
        angle, rate = _wrap_angle(angle, rate)
    how: dict[str, Any] = {"linewidth": 0.8, "markersize": 1.5, "rasterized": not joined}
    axes.plot(angle, rate, "-" if joined else ".", color=CURVE, **how)
    axes.plot(angle[0], rate[0], "o", markersize=4, color=INK, label="start", zorder=3)
    axes.plot(angle[-1], rate[-1], "s", markersize=5, color=SPECIAL, label="end")
    words = "" if smooth else "lines between samples"
    words = words if joined else "samples, too far apart for a curve"
    axes.set(xlabel=labels[0], ylabel=labels[1])
    if words:
        add_remark(axes, words)
    set_title(figure, f"{solution.scene.name}: phase plot")
    axes.legend()
    return figure


def _refine(solution: Solution) -> tuple[Solution, bool]:
    """Return the run with states between its samples where lines have corners, and whether it has
    no corners left that come from its samples."""
    shown = solution
    for _ in range(ROUNDS):
        cosines, lengths = _turn_cosines(*_position_and_rate(shown))
        corners = np.flatnonzero((cosines < BEND) & (lengths > SEEN_CORNER))
        steps = np.union1d(corners, corners + 1)  # before and after
        if not len(steps):
            return shown, True
        if len(steps) > MOST:
            return shown, False
        starts, parts = shown.t[steps], np.diff(shown.t)[steps] / PARTS
        times = (starts[:, None] + np.arange(1, PARTS) * parts[:, None]).ravel()
        try:
            states = solution(times).T
        except (InputError, RunError):  # of a run whose values were changed while it went on
            return shown, False
        t = np.concatenate((shown.t, times))
        order = np.argsort(t, kind="stable")
        y = np.concatenate((shown.y, states))[order]
        shown = replace(
            shown, t=t[order], y=y, work={}, events=(), changes=None, model=solution.model
        )
    return shown, True


def _position_and_rate(solution: Solution) -> tuple[Array, Array]:
    """Return the deflection or the angle of the plot and its rate, (T,) each."""
    if solution.scene.rod.links == 1:
        return solution.phi[:, 0], solution.omega[:, 0]
    return solution.values("tail_deflection"), solution.values("tail_deflection_rate")


def _wrap_angle(angle: Array, rate: Array) -> tuple[Array, Array]:
    """Wrap an absolute angle to within half a turn of zero. Returns it and its rate, with
    not-a-number, where no line is drawn, between samples that are on both sides of the edge."""
    turn = TURNS["phi"]
    number = np.round(angle / turn)
    edges = np.flatnonzero(np.diff(number)) + 1
    cut = [np.insert(values, edges, np.nan) for values in (angle - turn * number, rate)]
    return cut[0], cut[1]


def _turn_cosines(x: Array, y: Array) -> tuple[Array, Array]:
    """Return for every inner sample the cosine of the turn from line to line, not-a-number where
    nothing moves, and the length of the longer line, both as in the picture."""
    lines = np.stack([np.diff(v) / (np.ptp(v) or 1.0) for v in (x, y)], axis=-1)
    sizes = np.linalg.norm(lines, axis=1)
    both = sizes[:-1] * sizes[1:]
    cosines = np.full(len(both), np.nan)
    dots = (lines[:-1] * lines[1:]).sum(axis=1)
    np.divide(dots, both, out=cosines, where=both > 1e-12)
    return cosines, np.maximum(sizes[:-1], sizes[1:])


def save_pictures(solution: Solution, folder: Path, settings: PictureSettings) -> list[Path]:
    """Write every picture of a run into a folder that exists; returns the files.

    Of a run that blew up, only the time before is drawn; moments only where there are any.
    """
    shown = drawable_part(solution)
    if not len(shown.t):
        return []
    bent = shown.bending_moments.any()
    there = {name: draw for name, draw in PICTURES.items() if name != "moment" or bent}
    made = save_figures(((name, draw(shown)) for name, draw in there.items()), folder, settings)
    every = {folder / f"{name}.{ending}" for name in PICTURES for ending in FORMATS}
    for picture in every.difference(made):  # of an earlier run
        picture.unlink(missing_ok=True)
    return made


def drawable_part(solution: Solution) -> Solution:
    """Return the run before it blew up, without samples where it did so at once."""
    beyond = np.flatnonzero(np.abs(solution.y).max(axis=1) > LARGEST_DRAWN)
    return solution.head(int(beyond[0])) if len(beyond) else solution


def trajectories(solution: Solution) -> Figure:
    """Paths of the centre of gravity and of the tail, and of a root that is moved, with rings at
    equal intervals of time where a path does not go to and fro."""
    figure, (axes,) = make_axes(6.0, 5.0)
    t = solution.t
    ticks = MaxNLocator(RINGS, steps=[1, 2, 5, 10]).tick_values(t[0], t[-1])
    times = ticks[(ticks > t[0]) & (ticks < t[-1])]
    paths = {"tail": solution.tip, "centre of gravity": solution.centre_of_gravity}
    if moves_root(solution.scene):
        paths[start_name(solution.scene)] = solution.joints[:, 0]
    ringed = False
    for (name, path), colour in zip(paths.items(), (TAIL, CENTRE, INK), strict=False):
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        long = steps > LONG * np.ptp(path, axis=0).max()
        width = LINE / 2 if long else LINE
        axes.plot(*path.T, "-", color=colour, label=name, linewidth=width)
        axes.plot(*path[0], "o", color=colour, markersize=5, zorder=3)
        axes.plot(*path[-1], "s", color=colour, markersize=5, zorder=3)
        if not long and len(times):
            rings = [np.interp(times, t, part) for part in path.T]
            axes.plot(*rings, "o", color=colour, markerfacecolor=PAPER, markersize=3.5)
            ringed = True
    every = f"; rings: every {ticks[1] - ticks[0]:.3g} s" if ringed else ""
    marks = f"dot: start; square: end, after {t[-1] - t[0]:.4g} s{every}"
    marks = marks if len(t) > 1 else f"squares: at t = {t[0]:.4g} s"
    axes.set(xlabel="x [m]", ylabel="y [m]")
    add_remark(axes, marks)
    set_title(figure, f"{solution.scene.name}: trajectories")
    set_limits(axes, np.concatenate(list(paths.values())))
    mark_path(axes, solution)
    add_legend(figure)
    return figure


def energies(solution: Solution) -> Figure:
    """Energies and work over time; that of gravity and couples from the start on, as a height far
    from zero swamps all else. Below, the error of the energy balance."""
    figure, (axes, below) = make_axes(6.0, 5.0, 2, sharex=True, height_ratios=(2, 1))
    t, energy = solution.t, solution.energy
    loads = energy.gravity - energy.gravity[0]
    kinds = (TERMS[name].kind for name in solution.scene.structure.potentials)
    named = " and ".join(dict.fromkeys("couples" if k == COUPLE else "gravity" for k in kinds))
    from_start = bool(energy.gravity.any())
    total = f"total with {named} from the start" if from_start else "total"
    rows = [
        ("kinetic", energy.kinetic, True),
        ("springs", energy.spring, energy.spring.any()),
        (f"{named} from the start", loads, from_start),
        (total, energy.kinetic + energy.spring + loads, True),
    ]
    there = [(label, values) for label, values, is_there in rows if is_there]
    # In the order, and so in the colours, of the live view.
    colours = cycle(SERIES)
    for label, values in there:
        style: dict[str, Any] = {"color": next(colours), "linewidth": LINE}
        axes.plot(t, values, line_or_dot(values), label=label, **style)
    done = [(name, work) for name, work in solution.work.items() if work.any()]
    for (name, work), dashes in zip(done, cycle(WORK_DASHES), strict=False):
        style = {"linestyle": dashes, "color": next(colours), "linewidth": LINE}
        axes.plot(t, work, label=f"work of {describe(name)}", **style)
    mark_times(axes, solution)
    axes.set(ylabel="energy [J]")
    set_title(figure, f"{solution.scene.name}: energies and work")
    add_legend(figure)
    error = np.abs(solution.energy_balance)
    shown = np.where((error > 0) & np.isfinite(error), error, np.nan)
    if np.isfinite(shown).any():
        below.semilogy(t, shown, line_or_dot(shown), color=INK, linewidth=0.8)
        show_decades(below, shown)
    else:
        leave_empty(below, "none at any time")
    below.set(xlabel="t [s]", ylabel="|error| [J]")
    return figure


PICTURES: dict[str, Callable[[Solution], Figure]] = {
    "shape": shapes,
    "trajectory": trajectories,
    "energy": energies,
    "phase": phase_plot,
    "tail": tail_history,
    "moment": moment_map,
    "envelope": envelope,
}


def _restrict_to_drawable(draw: Callable[[Solution], Figure]) -> Callable[[Solution], Figure]:
    """Limit a picture to what can be drawn of a run; it raises an error where that is nothing."""

    def draw_part(solution: Solution) -> Figure:
        shown = drawable_part(solution)
        if not len(shown.t):
            raise EmptyPictureError("solution", solution, "a run with samples that can be drawn")
        return draw(shown)

    return draw_part


PICTURES_OF = {Solution: {name: _restrict_to_drawable(draw) for name, draw in PICTURES.items()}}
