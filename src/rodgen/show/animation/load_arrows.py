"""Arrows of the loads in an animation: straight ones of forces, curved ones of couples."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.quiver import Quiver

from rodgen.arrays import Array
from rodgen.model.term import FORCE
from rodgen.model.terms import TERMS
from rodgen.show.animation.motion import Camera, MotionSamples
from rodgen.show.animation.stage import Stage
from rodgen.show.canvas import INK
from rodgen.show.marks import curved_arrow

LONGEST_ARROW = 0.2  # of half of the picture's shorter side: the arrow of the largest force
LEAST_ARROW = 0.02  # of the longest: shorter ones are not drawn
RADIUS = 0.1  # of half of that side: of the arrows of couples


class LoadArrows:
    """Arrows of the loads of a motion, seen by a camera; names: loads that are not always zero."""

    def __init__(self, motion: MotionSamples, camera: Camera, stage: Stage):
        self._force = {
            name: camera.rotate(load.force)
            for name, load in motion.loads.items()
            if np.any(load.force)
        }
        self.names = tuple(self._force)
        self._stage = stage
        if not self.names:
            return
        sizes = {name: np.linalg.norm(force, axis=-1) for name, force in self._force.items()}
        largest = max(float(size.max()) for size in sizes.values())
        per_metre = largest / (LONGEST_ARROW * camera.half.min())
        self._point = {name: camera.to_picture(motion.loads[name].point) for name in self.names}
        before = camera.to_picture(motion.joints[:, -2])
        for name in self.names:
            at, arrow = self._point[name], self._force[name] / per_metre
            # A force that pushes the tail ends there, so that it does not hide the rod.
            if TERMS[name].kind == FORCE:
                pushes = np.sum(arrow * (before - at), axis=-1) > 0
                self._point[name] = at - pushes[:, None] * arrow
            hidden = sizes[name][:, None] < LEAST_ARROW * largest
            self._force[name] = np.where(hidden, np.nan, self._force[name])
        self._quiver = self._draw_quiver(per_metre)
        self._add_key(largest, per_metre * 2 * camera.half[1] / stage.size[1])

    def _draw_quiver(self, per_metre: float) -> Quiver:
        point, force = self._arrows_at(0)
        return self._stage.axes.quiver(
            *point.T,
            *force.T,
            color=[TERMS[name].colours[0] for name in self.names],
            angles="xy",
            scale_units="xy",
            scale=per_metre,
            units="dots",
            width=3 * self._stage.zoom,
            animated=True,
            zorder=6,
        )

    def _add_key(self, largest: float, per_pixel: float) -> None:
        """Add an arrow of a round number of newtons, with the number."""
        stage, newtons = self._stage, _round_down(largest)
        width, height = stage.canvas.get_width_height()
        # With its label to the east, a key's place is that of its tip.
        at = (
            stage.panel_corner[0] + newtons / per_pixel / width,
            stage.panel_corner[1] + 6 * stage.zoom / height,
        )
        stage.axes.quiverkey(
            self._quiver,
            *at,
            newtons,
            f"{newtons:g} N",
            coordinates="figure",
            labelpos="E",
            color=INK,
            labelcolor=INK,
            fontproperties={"size": 9},
        )

    def _arrows_at(self, k: int) -> tuple[Array, Array]:
        points = np.array([self._point[name][k] for name in self.names])
        return points, np.array([self._force[name][k] for name in self.names])

    def draw(self, k: int) -> None:
        """Draw the arrows of sample k."""
        if self.names:
            point, force = self._arrows_at(k)
            self._quiver.set_offsets(point)
            self._quiver.set_UVC(*force.T)
            self._stage.axes.draw_artist(self._quiver)


def _round_down(largest: float) -> float:
    """Return the largest of 1, 2 or 5 times a power of ten that is not above."""
    unit = 10.0 ** math.floor(math.log10(largest))
    return unit * max(digit for digit in (1, 2, 5) if digit * unit <= largest * (1 + 1e-9))


class CoupleArrows:
    """Curved arrows of the couples of a motion, seen by a camera, each as long as it is large;
    names: couples that are not always zero."""

    def __init__(self, motion: MotionSamples, camera: Camera, stage: Stage):
        couples = {name: one for name, one in motion.couples.items() if np.any(one[:, 2])}
        self.names = tuple(couples)
        self._stage, self._radius = stage, RADIUS * float(camera.half.min())
        largest = max((float(np.abs(one[:, 2]).max()) for one in couples.values()), default=1.0)
        if couples:
            stage.add_couple_key(largest)
        self._drawn = [
            (
                camera.to_picture(one[:, :2]),
                one[:, 2] / largest,
                stage.add_line(TERMS[name].colours[0], linewidth=2.2, zorder=6),
            )
            for name, one in couples.items()
        ]

    def draw(self, k: int) -> None:
        """Draw the arrows of sample k."""
        for points, shares, line in self._drawn:
            if abs(shares[k]) >= LEAST_ARROW:
                line.set_data(*(points[k] + curved_arrow(self._radius, shares[k])).T)
                self._stage.axes.draw_artist(line)
