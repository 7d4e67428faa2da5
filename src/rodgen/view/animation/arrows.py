"""Loads as arrows, all to one scale."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.quiver import Quiver

from rodgen.integrate.stepper import Array
from rodgen.view.animation.camera import Camera
from rodgen.view.animation.motion import Load, Motion
from rodgen.view.animation.stage import INK, LOADS, Stage

LONGEST = 0.2  # of half of the picture's shorter side: the arrow of the largest force
LEAST = 0.02  # of the longest: shorter ones are not drawn


class Arrows:
    """The loads of a motion, seen by a camera; names: those that are somewhere not zero."""

    def __init__(self, motion: Motion, camera: Camera, stage: Stage):
        self._force = {
            name: camera.turned(load.force) for name, load in motion.loads.items() if _any(load)
        }
        self.names = tuple(self._force)
        self._stage = stage
        if not self.names:
            return
        sizes = {name: np.linalg.norm(force, axis=-1) for name, force in self._force.items()}
        largest = max(float(size.max()) for size in sizes.values())
        per_metre = largest / (LONGEST * camera.half.min())
        self._point = {name: camera.seen(motion.loads[name].point) for name in self.names}
        before = camera.seen(motion.joints[:, -2])
        for name in self.names:
            at, arrow = self._point[name], self._force[name] / per_metre
            # A force that pushes the tail ends there, so that it does not hide the rod.
            if name != "weight":
                pushes = np.sum(arrow * (before - at), axis=-1) > 0
                self._point[name] = at - pushes[:, None] * arrow
            hidden = sizes[name][:, None] < LEAST * largest
            self._force[name] = np.where(hidden, np.nan, self._force[name])
        self._quiver = self._drawn(per_metre)
        self._key(largest, per_metre * 2 * camera.half[1] / stage.size[1])

    def _drawn(self, per_metre: float) -> Quiver:
        point, force = self._at(0)
        return self._stage.axes.quiver(
            *point.T,
            *force.T,
            color=[LOADS[name] for name in self.names],
            angles="xy",
            scale_units="xy",
            scale=per_metre,
            units="dots",
            width=3 * self._stage.zoom,
            animated=True,
            zorder=6,
        )

    def _key(self, largest: float, per_pixel: float) -> None:
        """An arrow of a round number of newtons, with the number."""
        stage, newtons = self._stage, _round(largest)
        width, height = stage.canvas.get_width_height()
        # With its label to the east, a key's place is that of its tip.
        at = stage.panel[0] + newtons / per_pixel / width, stage.panel[1] + 6 * stage.zoom / height
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

    def _at(self, k: int) -> tuple[Array, Array]:
        points = np.array([self._point[name][k] for name in self.names])
        return points, np.array([self._force[name][k] for name in self.names])

    def draw(self, k: int) -> None:
        """Draw those of sample k."""
        if self.names:
            point, force = self._at(k)
            self._quiver.set_offsets(point)
            self._quiver.set_UVC(*force.T)
            self._stage.axes.draw_artist(self._quiver)


def _any(load: Load) -> bool:
    return bool(np.any(load.force))


def _round(largest: float) -> float:
    """1, 2 or 5 times a power of ten: the largest that is not above."""
    unit = 10.0 ** math.floor(math.log10(largest))
    return unit * max(digit for digit in (1, 2, 5) if digit * unit <= largest * (1 + 1e-9))
