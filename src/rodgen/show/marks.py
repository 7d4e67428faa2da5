"""Marks of pictures and what they are called: the start of a rod, its bodies and supports, special
points of curves, and lines of what is stable and what is not.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from typing import Any, Literal, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.transforms import ScaledTranslation

from rodgen.arrays import Array
from rodgen.model.terms import BASE_ROWS
from rodgen.scene import Scene
from rodgen.show.canvas import BED, CURVE, FIXED, LINE

# Special points of curves: marks, and what they are called.
MARKS = {
    "hopf": ("o", "Hopf point"),
    "fold": ("D", "fold"),
    "branch": ("s", "branch point"),
    "period doubling": ("^", "period doubling"),
    "torus": ("v", "torus"),
}
# Lines of what is stable, unstable, or of which neither is known: their styles and names.
LineStyle = Literal["-", "--", ":"]
STABILITY: dict[int, tuple[LineStyle, str]] = {
    0: ("-", "stable"),
    1: ("--", "unstable"),
    -1: (":", "stability not known"),
}
# Marks of the start of a rod, their sizes in points and what they say, by what holds it.
STARTS = {
    "wall": ("s", 4.5, "square: clamped "),
    "pin": ("^", 5.5, "triangle: pinned "),
    "none": ("o", 3.5, "dot: "),
}
# Of the curved arrow of a couple: the angle of the longest [rad], and its head in radii.
LONGEST_TURN, HEAD = 1.5 * np.pi, 0.45
OBSTACLE = "obstacle"
BROAD = 5.0  # points: of the pale line behind a stop or a wall
ASIDE = BROAD / 2 / 72  # inches, by which it is aside
DISC = 16.0  # points across: of a body that is the whole mass


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


def base_at(scene: Scene, t: Array | float | None = None) -> tuple[Array, Array]:
    """Return where what holds a rod has joint 0 [m], (..., 2), and the angle of its clamp [rad], 0
    without one, (...), at times [s], (...), by default the start of the span."""
    t, laws = scene.integrate.span[0] if t is None else t, scene.time_dependent_loads
    given = {} if scene.base is None else scene.base.values
    names = (one.name for one in BASE_ROWS)
    moved = (laws[name](t) if name in laws else given.get(name, 0.0) for name in names)
    x, y, turned, _ = np.broadcast_arrays(*moved, t)
    return np.stack((x, y), axis=-1), (scene.rod.clamp_angle or 0.0) + turned


def moves_root(scene: Scene) -> bool:
    """Return whether what holds the rod moves joint 0."""
    return scene.base is not None and scene.base.keys != ("angle",)


def draw_marks(
    axes: Axes,
    scene: Scene,
    joints: Array,
    colour: Any,
    anchors: bool = True,
    t: float | None = None,
) -> None:
    """Draw the start of a rod with joints at (n+1, 2), turned as its clamp is at a time (see
    `base_at`), its bodies as discs, their areas by their masses, and on request its supports as
    dotted lines to triangles at their fixed points, its foundation as a broad line."""
    mark, size, _ = STARTS[scene.boundary_condition.start_drawing]
    turned = turned_mark(mark, base_at(scene, t)[1])
    axes.plot(*joints[0], marker=turned, color=colour, markersize=size)
    for body in scene.distribution.body_outlines:
        how = {"color": colour, "alpha": 0.6, "markersize": DISC * body.size}
        axes.plot(*body.positions(joints), "o", **how)
    if not anchors:
        return
    draw_obstacles(axes, scene)
    axes.plot(*scene.anchors.foundation_line.T, "-", color=BED, linewidth=6 * LINE, zorder=0)
    for tie in scene.anchors.support_points:
        axes.plot(*tie.segment(joints).T, ":", color=colour, linewidth=LINE)
        axes.plot(tie.x, tie.y, "^", color=FIXED, markersize=7)


def draw_obstacles(axes: Axes, scene: Scene) -> None:
    """Draw the lines of stops and walls, with a broad pale one to their right: once, however many
    shapes of a rod are drawn."""
    if any(one.get_gid() == OBSTACLE for one in axes.lines):
        return
    for line in scene.obstacles:
        for start, end in pairwise(line):
            x, y = (end - start) / np.linalg.norm(end - start)
            figure = cast(Figure, axes.figure)
            aside = ScaledTranslation(y * ASIDE, -x * ASIDE, figure.dpi_scale_trans)
            how: dict[str, Any] = {"color": BED, "linewidth": BROAD, "solid_capstyle": "butt"}
            strip = np.stack((start, end))
            axes.plot(*strip.T, transform=axes.transData + aside, zorder=0, **how)
        axes.plot(*line.T, "-", color=FIXED, linewidth=LINE, zorder=0.5, gid=OBSTACLE)


def turned_mark(mark: str, angle: Array | float) -> MarkerStyle:
    """Return a mark that is turned by an angle [rad]."""
    return MarkerStyle(mark).rotated(rad=float(angle))


def curved_arrow(radius: float, share: float) -> Array:
    """Return the line of a curved arrow about zero and of its head (k, 2); share: of the longest,
    positive to the left."""
    angles = np.linspace(0.0, share * LONGEST_TURN, 41) - np.pi / 4
    arc = radius * np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    outwards = arc[-1] / radius
    back = np.sign(share) * np.array([outwards[1], -outwards[0]])
    wings = (arc[-1] + HEAD * radius * (back + side * outwards) for side in (0.5, -0.5))
    first, last = wings
    return np.concatenate((arc, [first, arc[-1], last]))


def describe_marks(scene: Scene, anchors: bool = True) -> str:
    """Explain the marks that are drawn of a scene."""
    words = [STARTS[scene.boundary_condition.start_drawing][-1] + start_name(scene)]
    if scene.bodies:
        words.append("discs: bodies, by mass")
    if anchors and scene.anchors.support_points:
        words.append("triangle: where a support is fixed")
    if anchors and len(scene.anchors.foundation_line):
        words.append("broad line: foundation")
    if anchors and scene.obstacles:
        words.append("with a pale side: stops and walls")
    return "; ".join(words)


def start_name(scene: Scene) -> str:
    """Return the name of joint 0: "nose" or "root"."""
    return "nose" if scene.boundary_condition.start_drawing == "none" else "root"
