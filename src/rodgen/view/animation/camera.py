"""From the world to the picture: a view that stands, moves along, or turns along."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.view.animation.motion import Motion

SMALLEST_ROD = 0.25  # of the picture's height: below, the view moves with the rod
MARGIN = 1.12, 1.28  # round what is seen: without arrows, and with them
FAR = 1e5  # beyond so many times what is seen, coordinates are told from a point nearby


@dataclass(frozen=True)
class Camera:
    """origin: the point of the world that is zero in the picture, (S, 2); angle: by which the
    picture is turned against the world [rad], (S,); middle and half: of what is seen, in the
    picture's metres, (2,); view: one of VIEWS."""

    view: str
    origin: Array
    angle: Array
    middle: Array
    half: Array

    def seen(self, points: Array) -> Array:
        """Points of the world (S, ..., 2) in the picture."""
        shape = len(points), *(1,) * (points.ndim - 2), 2
        return self.turned(points - self.origin.reshape(shape))

    def turned(self, vectors: Array) -> Array:
        """Vectors of the world (S, ..., 2) in the picture."""
        if self.view != "axes":
            return vectors
        shape = len(vectors), *(1,) * (vectors.ndim - 2)
        cos, sin = np.cos(self.angle).reshape(shape), np.sin(self.angle).reshape(shape)
        x, y = vectors[..., 0], vectors[..., 1]
        return np.stack((cos * x + sin * y, cos * y - sin * x), axis=-1)

    def angle_of(self, k: int) -> float:
        """By how much the picture of sample k is turned against the world [rad]."""
        return float(self.angle[k]) if self.view == "axes" else 0.0

    def seen_at(self, k: int, points: Array) -> Array:
        """Points of the world (P, 2) in the picture of sample k."""
        x, y = (points - self.origin[k]).T
        cos, sin = math.cos(self.angle_of(k)), math.sin(self.angle_of(k))
        return np.stack((cos * x + sin * y, cos * y - sin * x), axis=-1)


def camera(motion: Motion, view: str | None, aspect: float, length: float) -> Camera:
    """The camera of a view, which is chosen where it is None; aspect: width over height of what
    is seen; length: of the rod [m]."""
    if view is not None:
        return _camera(motion, view, aspect)
    fixed = _camera(motion, "fixed", aspect)
    return (
        fixed if length >= 2 * SMALLEST_ROD * fixed.half[1] else _camera(motion, "centre", aspect)
    )


def _camera(motion: Motion, view: str, aspect: float) -> Camera:
    zero = np.zeros(2)
    origin = motion.centre if view != "fixed" else np.zeros_like(motion.centre)
    rough = Camera(view, origin, motion.axis, zero, zero)
    points = rough.seen(motion.joints).reshape(-1, 2)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    if view != "fixed":  # the centre of gravity stays in the middle
        middle, half = zero, np.maximum(-low, high)
    height = max(half[1], half[0] / aspect) * MARGIN[bool(motion.loads)]
    around = np.array([aspect * height, height])
    if np.abs(middle).max() > FAR * height:
        near = _short(middle, height)
        return Camera(view, origin + near, motion.axis, middle - near, around)
    return Camera(view, origin, motion.axis, middle, around)


def _short(point: Array, size: float) -> Array:
    """A point not far from this one, for what is of this size, in round numbers."""
    unit = 10.0 ** math.ceil(math.log10(size))
    near: Array = unit * np.round(point / unit)
    return near


def ground(origin: Array, angle: float, step: float, reach: float) -> Array:
    """Lines of the ground grid, a step apart, that pass a picture with this origin and angle
    within its reach [m], as one line with gaps: (3 lines, 2) in the picture's metres."""
    count = math.ceil(reach / step) + 1
    at = step * np.arange(-count, count + 1)
    near = -np.mod(origin, step)
    ends = np.broadcast_to(step * count * np.array([-1.0, 1.0]), (len(at), 2))
    upright = np.stack((np.broadcast_to((at + near[0])[:, None], ends.shape), ends), axis=-1)
    level = np.stack((ends, np.broadcast_to((at + near[1])[:, None], ends.shape)), axis=-1)
    gapped = np.full((2 * len(at), 3, 2), np.nan)
    gapped[:, :2] = np.concatenate((upright, level))
    x, y = gapped.reshape(-1, 2).T
    cos, sin = math.cos(angle), math.sin(angle)
    return np.stack((cos * x + sin * y, cos * y - sin * x), axis=-1)
