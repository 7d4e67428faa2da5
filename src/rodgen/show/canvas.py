"""Figures for pictures, their colours, and marks on a rod and beside it: its start, its bodies, its
supports, and their names.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from itertools import pairwise
from typing import Any, Literal, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from rodgen.arrays import Array
from rodgen.model.palette import LIGHT, colours_of
from rodgen.scene import Scene

LINE = 1.2  # points
SERIES = colours_of("series")
CURVE, *_ = SERIES  # of a curve that is alone
# Text and axes; notes; what other things are seen beside; the rod, its bodies, its fixed points and
# its bed; its tail and its centre of gravity; what is special: points, failures.
INK, FAINT, GUIDE, ROD, BODY, FIXED, BED, TAIL, CENTRE, SPECIAL = (
    str(LIGHT[name])
    for name in ["ink", "faint", "axis", "link", "body", "joint", "line", "tail", "centre", "kick"]
)
EDGE, PAPER = str(LIGHT["edge"]), str(LIGHT["background"])
STEPS = 65  # of the colours below: few enough for a GIF, and one of them is the middle
# Blue below zero, red above, as the live view has it; and one that says which comes before which.
MOMENTS, ALONG = (
    LinearSegmentedColormap.from_list(name, colours_of(name), N=STEPS)
    for name in ("moments", "along")
)
# Special points of curves: marks, and what they are called.
MARKS = {
    "hopf": ("o", "Hopf point"),
    "fold": ("D", "fold"),
    "branch": ("s", "branch point"),
    "period doubling": ("^", "period doubling"),
    "torus": ("v", "torus"),
}
# Lines of what is stable, unstable, or of which neither is known: their styles and names.
Style = Literal["-", "--", ":"]
STABILITY: dict[int, tuple[Style, str]] = {
    0: ("-", "stable"),
    1: ("--", "unstable"),
    -1: (":", "stability not known"),
}
VALUES = "viridis"  # of maps, which are filled
SLIVER = 0.05  # width over length

DISC = 16.0  # points across: of a body that is the whole mass


def make_figure(width: float, height: float) -> Figure:
    """Make a figure of this size [inches], without a window; inside `draw_into`, as it was
    given."""
    given = _given.get()
    if not callable(given):
        return cast(Figure, given)  # of a part of a figure there is all that pictures ask for
    return given(figsize=(width, height), layout="constrained")


def make_axes(
    width: float, height: float, rows: int = 1, **layout: Any
) -> tuple[Figure, list[Axes]]:
    """Make a figure of this size [inches] with axes one above the other, each with a pale grid;
    layout: options of Figure.subplots."""
    figure = make_figure(width, height)
    panels: list[Axes] = figure.subplots(rows, squeeze=False, **layout)[:, 0].tolist()
    for axes in panels:
        axes.grid(alpha=0.3)
    return figure, panels


def figure_without_window(**how: Any) -> Figure:
    """Make a figure that is only written to files."""
    figure = Figure(**how)
    FigureCanvasAgg(figure)
    return figure


_given: ContextVar[Figure | SubFigure | Callable[..., Figure]] = ContextVar(
    "given", default=figure_without_window
)


@contextmanager
def draw_into(given: Figure | SubFigure | Callable[..., Figure]) -> Iterator[None]:
    """Draw the pictures made inside the block in this figure, or in what this function makes."""
    token = _given.set(given)
    try:
        yield
    finally:
        _given.reset(token)


def mark_of(kind: str) -> tuple[str, str]:
    """Return the mark and the name of a kind of special point."""
    return MARKS.get(kind, ("x", kind))


def draw_by_stability(axes: Axes, x: Array, y: Array, kinds: Array) -> None:
    """Draw a curve (points,), each of its pieces (points - 1,) in the style that its kind has in
    STABILITY."""
    changes = np.flatnonzero(np.diff(kinds)) + 1
    for first, last in pairwise(np.unique([0, *changes, len(kinds)])):
        part = slice(first, last + 1)
        axes.plot(x[part], y[part], STABILITY[kinds[first]][0], color=CURVE, linewidth=LINE)


def stability_legend(kinds: Collection[int], colour: str) -> list[Line2D]:
    """Return entries of a legend for those kinds of STABILITY that occur."""
    return [
        Line2D([], [], linestyle=style, color=colour, label=words)
        for kind, (style, words) in STABILITY.items()
        if kind in kinds
    ]


def set_height(figure: Figure, height: float) -> None:
    """Give a figure another height [inches], unless somebody else has chosen its size."""
    if callable(_given.get()):
        figure.set_figheight(height)


def set_limits(axes: Axes, points: Array) -> None:
    """Set limits that show all points (..., 2), in equal scales unless the picture would be a
    sliver in which nothing is seen."""
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


def draw_marks(axes: Axes, scene: Scene, joints: Array, colour: Any, anchors: bool = True) -> None:
    """Draw the start of a rod with joints at (n+1, 2), its bodies as discs, their areas by their
    masses, and on request its supports as dotted lines to triangles at their fixed points, its
    foundation as a broad line."""
    mark, size = ("s", 4.5) if scene.boundary_condition.is_clamped else ("o", 3.5)
    axes.plot(*joints[0], mark, color=colour, markersize=size)
    for body in scene.distribution.body_outlines:
        how = {"color": colour, "alpha": 0.6, "markersize": DISC * body.size}
        axes.plot(*body.positions(joints), "o", **how)
    if not anchors:
        return
    axes.plot(*scene.anchors.foundation_line.T, "-", color=BED, linewidth=6 * LINE, zorder=0)
    for tie in scene.anchors.support_points:
        axes.plot(*tie.segment(joints).T, ":", color=colour, linewidth=LINE)
        axes.plot(tie.x, tie.y, "^", color=FIXED, markersize=7)


def describe_marks(scene: Scene, anchors: bool = True) -> str:
    """Explain the marks that are drawn of a scene."""
    start = start_name(scene)
    words = [f"square: clamped {start}" if scene.boundary_condition.is_clamped else f"dot: {start}"]
    if scene.bodies:
        words.append("discs: bodies, by mass")
    if anchors and scene.anchors.support_points:
        words.append("triangle: where a support is fixed")
    if anchors and len(scene.anchors.foundation_line):
        words.append("broad line: foundation")
    return "; ".join(words)


def start_name(scene: Scene) -> str:
    """Return the name of joint 0: "nose" or "root"."""
    return "nose" if scene.boundary_condition.start_drawing == "none" else "root"
