"""Envelope of a run: between what limits bending moments and section forces were along the rod."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodgen.arrays import Array
from rodgen.integrate import Solution
from rodgen.model.quantities import QUANTITIES, Quantity, numbers
from rodgen.model.term import typeset
from rodgen.show.canvas import (
    BEHIND,
    CURVE,
    GUIDE,
    INK,
    LINE,
    SPECIAL,
    leave_empty,
    line_or_dot,
    make_axes,
    set_title,
)
from rodgen.show.marks import start_name

SECTION_QUANTITIES = ("bending_moments", "axial_force", "shear_force")


def envelope(solution: Solution) -> Figure:
    """Least and largest bending moment, axial force and shear force along the rod, of all samples,
    with the largest of each and its time."""
    rows = {one.name: one for one in QUANTITIES if one.name in SECTION_QUANTITIES}
    there = [(rows[name], *_along(solution, rows[name])) for name in SECTION_QUANTITIES]
    there = [row for row in there if row[1].size and row[2].any()]
    figure, panels = make_axes(6.0, 1.0 + 1.8 * max(len(there), 1), max(len(there), 1), sharex=True)
    for axes, (row, s, values) in zip(panels, there, strict=False):
        _draw_limits(axes, solution.t, s, values, typeset(row.unit))
        words = row.name.removesuffix("s").replace("_", "\n")  # lines fit beside a low panel
        axes.set(ylabel=f"{words} [{typeset(row.unit)}]")
    if not there:
        leave_empty(panels[0], "none anywhere, at any time")
    start = start_name(solution.scene)
    panels[-1].set(xlabel=f"s along the rod (0: {start}, 1: tail)", xlim=(0.0, 1.0))
    set_title(figure, f"{solution.scene.name}: envelope of moments and forces")
    return figure


def _along(solution: Solution, quantity: Quantity) -> tuple[Array, Array]:
    """Return where along the rod a quantity is, (k,), and its values there, (T, k)."""
    scene = solution.scene
    found = [*numbers(quantity, scene.boundary_condition, scene.rod.links)]
    s = scene.mesh.at(np.array([one.along for one in found], dtype=float))
    if not len(found):
        return s, np.zeros((len(solution.t), 0))
    return s, solution.values(quantity.name)[:, [one.at[0] for one in found]]


def _draw_limits(axes: Axes, t: Array, s: Array, values: Array, unit: str) -> None:
    """Draw the limits of values (T, k) at places (k,), and mark the largest value with its unit."""
    low, high = np.nanmin(values, axis=0), np.nanmax(values, axis=0)
    axes.axhline(0.0, color=GUIDE, linewidth=0.8)
    axes.fill_between(s, low, high, color=CURVE, alpha=0.15, linewidth=0)
    for limit in (low, high):
        axes.plot(s, limit, line_or_dot(limit), color=CURVE, linewidth=LINE)
    time, place = np.unravel_index(int(np.nanargmax(np.abs(values))), values.shape)
    most = float(values[time, place])
    how: dict[str, Any] = {"clip_on": False, "in_layout": False, "zorder": 3}
    axes.plot(s[place], most, "o", color=SPECIAL, markersize=4, **how)
    left = s[place] < 0.5
    axes.annotate(
        f"{most:.4g} {unit} at {t[time]:.4g} s".replace("-", "\u2212"),
        (s[place], most),
        (6 if left else -6, 0),
        textcoords="offset points",
        ha="left" if left else "right",
        va="top" if most > 0 else "bottom",
        color=INK,
        bbox=BEHIND,
    )
