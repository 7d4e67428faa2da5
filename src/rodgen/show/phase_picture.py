"""Phase plot of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate import RunError, Solution
from rodgen.model.quantities import TURNS
from rodgen.show.canvas import CURVE, INK, SPECIAL, make_figure

BEND = np.cos(np.radians(12))  # of a turn from line to line, beyond which it is seen as a corner
SEEN = 0.004  # of the picture: the longer line at a corner that is seen
SHARP, MOST_SHARP = 0.5, 0.25  # cosine of a turn of 60 degrees; share of turns beyond in a curve
PARTS, ROUNDS = 4, 3  # into which a step is divided where the curve has a corner; how often
MOST = 500  # steps that are divided at a time: each costs about a millisecond


def phase_plot(solution: Solution) -> Figure:
    """How far the rod is bent over how fast it bends: tail link relative to first link. States
    between samples are computed where lines between these would have corners."""
    figure = make_figure(6.0, 5.0)
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
    if solution.scene.rod.links > 1:
        labels = (r"$\varphi_{n-1}-\varphi_0$ [rad]", r"$\omega_{n-1}-\omega_0$ [rad/s]")
    else:
        labels = (r"$\varphi_0$ less whole turns [rad]", r"$\omega_0$ [rad/s]")
    shown, smooth = _refine(solution)
    angle, rate = _angle_and_rate(shown)
    cosines, _ = _turn_cosines(angle, rate)
    sharp = float((cosines < SHARP).sum()) / max(np.isfinite(cosines).sum(), 1)
    joined = sharp < MOST_SHARP
    if solution.scene.rod.links == 1:
        angle, rate = _wrap_angle(angle, rate)
    axes.plot(angle, rate, "-" if joined else ".", linewidth=0.8, markersize=1.5, color=CURVE)
    axes.plot(angle[0], rate[0], "o", markersize=4, color=INK, label="start")
    axes.plot(angle[-1], rate[-1], "s", markersize=5, color=SPECIAL, label="end")
    words = "" if smooth else " (lines between samples)"
    words = words if joined else " (samples: too far apart for a curve)"
    axes.set(xlabel=labels[0], ylabel=labels[1], title=f"{solution.scene.name}: phase plot{words}")
    axes.legend()
    return figure


def _refine(solution: Solution) -> tuple[Solution, bool]:
    """Return the run with states between its samples where lines have corners, and whether it has
    no corners left that come from its samples."""
    shown = solution
    for _ in range(ROUNDS):
        cosines, lengths = _turn_cosines(*_angle_and_rate(shown))
        corners = np.flatnonzero((cosines < BEND) & (lengths > SEEN))
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


def _angle_and_rate(solution: Solution) -> tuple[Array, Array]:
    """Return the angle and the rate of the plot, (T,) each."""
    if solution.scene.rod.links == 1:
        return solution.phi[:, 0], solution.omega[:, 0]
    angle, rate = (values[:, -1] - values[:, 0] for values in (solution.phi, solution.omega))
    return angle, rate


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
