"""The picture of an animation: what stands still is drawn once, the rest anew in every frame."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from rodgen.integrate.stepper import Array
from rodgen.scene import Scene
from rodgen.view.animation.arrows import Arrows
from rodgen.view.animation.camera import camera, ground
from rodgen.view.animation.motion import Motion
from rodgen.view.animation.stage import BENDING, CENTRE, GRID, INK, TAIL, Stage
from rodgen.view.animation.times import Settings

TRAIL = 5.0  # seconds of film
LEAST_LINK = 8.0  # points: the joints of shorter links would hide the rod
HOLDS = {"free": ("o", 6.5), "pinned": ("^", 11.0)}  # mark of joint 0 and its size
CLAMP = ("s", 10.0)


class Picture:
    """Frames of a film: pixels(k, t) is that of sample k at time t.

    Like all of matplotlib's figures it belongs to one thread; it shares nothing with others.
    """

    def __init__(self, motion: Motion, scene: Scene, settings: Settings, speed: float):
        self._stage = stage = Stage(settings)
        self.camera = camera(motion, settings.view, stage.aspect, scene.rod.length)
        stage.set_limits(self.camera)
        self._step = stage.grid_step
        stage.set_title(scene, speed)
        stage.add_colours(motion.label, motion.bending_limit, float(np.abs(motion.bending).max()))
        self._motion, self._trail = motion, TRAIL * speed
        self._joints = self.camera.seen(motion.joints)
        self._centre = self.camera.seen(motion.centre)
        self._arrows = Arrows(motion, self.camera, stage)
        self._hold = HOLDS.get(scene.rod.boundary, CLAMP)
        stage.add_legend(self._hold[0], self._arrows.names, self.camera.view)
        self._digits = min(max(2, math.ceil(-math.log10(speed / settings.fps))), 12)
        self._add_moving(scene)
        self._still = stage.background()

    def _add_moving(self, scene: Scene) -> None:
        """The artists that are drawn in every frame."""
        stage, n, limit = self._stage, scene.rod.links, self._motion.bending_limit
        self._ground = stage.line(**GRID)
        self._trails = [stage.line(color, linewidth=1.1, alpha=0.75) for color in (TAIL, CENTRE)]
        self._rod = stage.lines(linewidth=3.6, capstyle="round", cmap=BENDING, clim=(-limit, limit))
        self._rod.set_snap(False)  # to whole pixels, in which a bent rod has steps
        # Views of one array are drawn: new paths in every frame would take most of its time.
        self._halves = np.zeros((2 * n, 2, 2))
        self._rod.set_segments(list(self._halves))
        self._inner = stage.mark(("o", 3.6), "white", INK)
        self._start = stage.mark(self._hold, INK, INK)
        self._tail = stage.mark(("o", 6.0), TAIL, INK)
        self._middle = stage.mark(("o", 6.5), "white", CENTRE, 2.2)
        self._clock = stage.clock()
        link = scene.rod.length / n * stage.pixels_per_metre(self.camera)
        self._dotted = link * 72 / stage.figure.dpi >= LEAST_LINK

    def pixels(self, k: int, t: float) -> NDArray[np.uint8]:
        """The frame that shows sample k, with the time t [s] as text: (height, width, 4) of red,
        green, blue, alpha; overwritten by the next."""
        stage = self._stage
        stage.canvas.restore_region(self._still)
        if self.camera.view != "fixed":
            self._show_ground(k)
        self._show_trails(k)
        self._show_rod(k)
        self._arrows.draw(k)
        self._show(self._middle, self._centre[k, None])
        self._clock.set_text(f"t = {t:.{self._digits}f} s")
        stage.axes.draw_artist(self._clock)
        return np.asarray(stage.canvas.buffer_rgba())

    def _show(self, line: Line2D, points: Array) -> None:
        line.set_data(points[:, 0], points[:, 1])
        self._stage.axes.draw_artist(line)

    def _show_ground(self, k: int) -> None:
        seen = self.camera
        reach = float(np.hypot(*seen.half))
        self._show(self._ground, ground(seen.origin[k], seen.angle_of(k), self._step, reach))

    def _show_trails(self, k: int) -> None:
        t = self._motion.t
        first = int(np.searchsorted(t, t[k] - self._trail))
        for line, path in zip(
            self._trails, (self._motion.joints[:, -1], self._motion.centre), strict=True
        ):
            self._show(line, self.camera.seen_at(k, path[first : k + 1]))

    def _show_rod(self, k: int) -> None:
        joints, bending = self._joints[k], self._motion.bending[k]
        self._halves[:] = halves(joints)
        # The bending of a joint colours the halves of the links that meet there.
        self._rod.set_array(np.repeat(bending, 2)[1:-1])
        self._stage.axes.draw_artist(self._rod)
        if self._dotted:
            self._show(self._inner, joints[1:-1])
        self._show(self._start, joints[:1])
        self._show(self._tail, joints[-1:])


def halves(joints: Array) -> Array:
    """Halves of the links between joints (n+1, 2): (2n, 2, 2)."""
    points: Array = np.empty((2 * len(joints) - 1, 2))
    points[::2] = joints
    points[1::2] = (joints[:-1] + joints[1:]) / 2
    return np.stack((points[:-1], points[1:]), axis=1)
