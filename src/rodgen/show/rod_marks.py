"""Marks on a rod and beside it (its start, its bodies, its supports), and their names."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from rodgen.scene import Scene
from rodgen.show.canvas import BED, FIXED, LINE

DISC = 16.0  # points across: of a body that is the whole mass


def draw_marks(
    axes: Axes, scene: Scene, joints: np.ndarray, colour: Any, anchors: bool = True
) -> None:
    """Draw the start of a rod with joints at (n+1, 2), its bodies and, on request, its supports."""
    mark, size = ("s", 4.5) if scene.boundary_condition.is_clamped else ("o", 3.5)
    axes.plot(*joints[0], mark, color=colour, markersize=size)
    _draw_bodies(axes, scene, joints, colour)
    if anchors:
        _draw_anchors(axes, scene, joints, colour)


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


def _draw_anchors(axes: Axes, scene: Scene, joints: np.ndarray, colour: Any) -> None:
    """Draw supports as dotted lines to triangles at their fixed points, a foundation as a broad
    line."""
    anchors = scene.anchors
    axes.plot(*anchors.foundation_line.T, "-", color=BED, linewidth=6 * LINE, zorder=0)
    for tie in anchors.support_points:
        axes.plot(*tie.segment(joints).T, ":", color=colour, linewidth=LINE)
        axes.plot(tie.x, tie.y, "^", color=FIXED, markersize=7)


def _draw_bodies(axes: Axes, scene: Scene, joints: np.ndarray, colour: Any) -> None:
    """Draw bodies as discs, their areas by their masses, on a rod with joints at (n+1, 2)."""
    for mark in scene.distribution.body_outlines:
        place = mark.positions(joints)
        axes.plot(*place, "o", color=colour, alpha=0.6, markersize=DISC * mark.size)


def start_name(scene: Scene) -> str:
    """Return the name of joint 0: "nose" or "root"."""
    return "nose" if scene.boundary_condition.start_symbol == "none" else "root"
