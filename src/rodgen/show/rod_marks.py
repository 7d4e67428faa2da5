"""What is drawn on a rod and beside it: how it starts, its bodies, what it is fixed to; and what
these marks are called."""

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
    """The start of a rod whose joints are at (n+1, 2), its bodies, and on request its supports."""
    mark, size = ("s", 4.5) if scene.hold.clamped else ("o", 3.5)
    axes.plot(*joints[0], mark, color=colour, markersize=size)
    _draw_bodies(axes, scene, joints, colour)
    if anchors:
        _draw_anchors(axes, scene, joints, colour)


def marks_in_words(scene: Scene, anchors: bool = True) -> str:
    """What the marks that are drawn of a scene stand for."""
    start = first_end(scene)
    words = [f"square: clamped {start}" if scene.hold.clamped else f"dot: {start}"]
    if scene.bodies:
        words.append("discs: bodies, by mass")
    if anchors and scene.anchors.ties:
        words.append("triangle: where a support is fixed")
    if anchors and len(scene.anchors.bed):
        words.append("broad line: foundation")
    return "; ".join(words)


def _draw_anchors(axes: Axes, scene: Scene, joints: np.ndarray, colour: Any) -> None:
    """Supports as dotted lines to triangles, where they are fixed; a foundation as a broad line."""
    anchors = scene.anchors
    axes.plot(*anchors.bed.T, "-", color=BED, linewidth=6 * LINE, zorder=0)
    for tie in anchors.ties:
        axes.plot(*tie.way(joints).T, ":", color=colour, linewidth=LINE)
        axes.plot(tie.x, tie.y, "^", color=FIXED, markersize=7)


def _draw_bodies(axes: Axes, scene: Scene, joints: np.ndarray, colour: Any) -> None:
    """Bodies as discs, their areas by their masses, on a rod whose joints are at (n+1, 2)."""
    for mark in scene.distribution.marks:
        place = mark.places(joints)
        axes.plot(*place, "o", color=colour, alpha=0.6, markersize=DISC * mark.size)


def first_end(scene: Scene) -> str:
    """What joint 0 is called."""
    return "nose" if scene.hold.support == "none" else "root"
