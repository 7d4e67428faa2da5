"""Motion of a rod as an animation shows it, in arrays over its samples; and the camera."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate import Solution
from rodgen.integrate.couples import couples_of
from rodgen.integrate.weights import falls_of
from rodgen.model.term import FORCE, SPREAD
from rodgen.model.terms import TERMS
from rodgen.show.marks import base_at

# Where the largest bending of all is so many times that of nearly all samples, colours end there.
OUTLIER, COVERED = 3.0, 0.98
SMALLEST_ROD = 0.25  # of the picture's height: below, the view moves with the rod
VIEW_MARGIN = 1.12, 1.28  # round what is seen: without arrows, and with them
LEAST_FORCE = 1e-300  # N
FAR_FROM_VIEW = 1e5  # beyond so many times what is seen, coordinates are told from a point nearby


class LoadSamples(NamedTuple):
    """A force [N] and the point on which it acts [m], both (S, 2)."""

    point: Array
    force: Array


@dataclass(frozen=True)
class MotionSamples:
    """Motion at every sample. t: times [s], (S,); joints: [m], (S, n+1, 2); centre: of gravity [m],
    (S, 2); axis: angle of the principal axis of the smaller moment, without jumps [rad], (S,);
    clamp: its angle, 0 without one [rad], (S,); bending: in every joint, (S, n+1), and label, its
    name; loads, by their terms; couples: points and moments, (S, 3), likewise."""

    t: Array
    joints: Array
    centre: Array
    axis: Array
    clamp: Array
    bending: Array
    label: str
    loads: dict[str, LoadSamples]
    couples: dict[str, Array]

    @property
    def bending_limit(self) -> float:
        """Bending at which the colours end: a blow-up at the end is not to hide the rest."""
        largest = np.abs(self.bending).max(axis=1)
        most, all_of_it = float(np.quantile(largest, COVERED)), float(largest.max())
        return most if 0 < most < all_of_it / OUTLIER else all_of_it or 1.0


def sample_motion(solution: Solution) -> MotionSamples:
    """Compute everything that is drawn, at every sample of a solution."""
    with np.errstate(all="ignore"):
        bending, label = _bending(solution)
        return MotionSamples(
            solution.t,
            solution.joints,
            solution.centre_of_gravity,
            _principal_angle(solution),
            base_at(solution.scene, solution.t)[1],
            np.nan_to_num(bending),
            label,
            _loads(solution),
            couples_of(solution, solution.scene.structure.terms),
        )


def _bending(solution: Solution) -> tuple[Array, str]:
    """Return moments (curvatures without stiffness) in every joint, (S, n+1), and their label."""
    links = solution.scene.rod.links
    nonuniform = "stiffness" in solution.scene.structure.nonuniform
    if solution.parameter("joint_stiffness" if nonuniform else "bending_stiffness").any():
        return solution.bending_moments, "bending moment [N m]"
    curvature = np.zeros((len(solution.t), links + 1))
    springs = solution.scene.boundary_condition.spring_joints(links)
    if springs:
        curvature[:, springs.start : springs.stop] = solution.values("curvature")
    return curvature, "curvature [1/m]"


def _principal_angle(solution: Solution) -> Array:
    """Return the angle of the principal axis [rad], (S,). An axis has no direction: it is followed
    from sample to sample, and points from tail to nose at the start."""
    angle: Array = np.unwrap(solution.principal_axes.angle, period=np.pi)
    rod = solution.joints[0, 0] - solution.joints[0, -1]
    along = np.array([np.cos(angle[0]), np.sin(angle[0])]) @ rod
    return angle if along >= 0 else angle + np.pi


def _mass(solution: Solution) -> Array:
    """Return the mass of the rod with its bodies at every sample, (T,)."""
    if "link_mass" in solution.scene.structure.index_ranges:
        total: Array = solution.parameter("link_mass").sum(axis=1)
        return total
    scene = solution.scene
    if scene.structure.masses:
        return np.array([scene.distribution_at(t).mass for t in solution.t])
    return solution.parameter("mass")


def _loads(solution: Solution) -> dict[str, LoadSamples]:
    """Return the weight and the resultants of the forces on joints, with their points of action."""
    found, falls = {}, falls_of(solution, solution.scene.structure.terms)
    for name in solution.scene.loads.terms:
        kind = TERMS[name].kind
        if name in falls:
            force = falls[name] * _mass(solution)[:, None]
            found[name] = LoadSamples(solution.centre_of_gravity, force)
        elif kind in (FORCE, SPREAD):
            forces = solution.forces[name]
            sizes = np.linalg.norm(forces, axis=-1, keepdims=True)
            shares = sizes / np.maximum(sizes.sum(axis=1, keepdims=True), LEAST_FORCE)
            found[name] = LoadSamples((shares * solution.joints).sum(axis=1), forces.sum(axis=1))
    return found


@dataclass(frozen=True)
class Camera:
    """View of a motion. origin: the point of the world that is zero in the picture, (S, 2); angle:
    by which the picture is turned against the world [rad], (S,); middle and half: of what is seen,
    in the picture's metres, (2,); view: one of VIEWS."""

    view: str
    origin: Array
    angle: Array
    middle: Array
    half: Array

    def to_picture(self, points: Array) -> Array:
        """Transform points of the world (S, ..., 2) into the picture."""
        shape = len(points), *(1,) * (points.ndim - 2), 2
        return self.rotate(points - self.origin.reshape(shape))

    def rotate(self, vectors: Array) -> Array:
        """Rotate vectors of the world (S, ..., 2) into the picture."""
        if self.view != "axes":
            return vectors
        return _turn(vectors, self.angle.reshape(len(vectors), *(1,) * (vectors.ndim - 2)))

    def angle_of(self, k: int) -> float:
        """Return the angle by which the picture of sample k is turned against the world [rad]."""
        return float(self.angle[k]) if self.view == "axes" else 0.0

    def to_picture_at(self, k: int, points: Array) -> Array:
        """Transform points of the world (P, 2) into the picture of sample k."""
        return _turn(points - self.origin[k], self.angle_of(k))


def _turn(vectors: Array, angle: Array | float) -> Array:
    """Return vectors (..., 2) as axes see them that are turned by an angle [rad]."""
    (x, y), cos, sin = np.moveaxis(vectors, -1, 0), np.cos(angle), np.sin(angle)
    return np.stack((cos * x + sin * y, cos * y - sin * x), axis=-1)


def choose_camera(motion: MotionSamples, view: str | None, aspect: float, length: float) -> Camera:
    """Make the camera of a view, chosen where it is None; aspect: width over height of what is
    seen; length: of the rod [m]."""
    camera = _make_camera(motion, view or "fixed", aspect)
    if view is None and length < 2 * SMALLEST_ROD * camera.half[1]:
        return _make_camera(motion, "centre", aspect)
    return camera


def _make_camera(motion: MotionSamples, view: str, aspect: float) -> Camera:
    zero = np.zeros(2)
    origin = motion.centre if view != "fixed" else np.zeros_like(motion.centre)
    rough = Camera(view, origin, motion.axis, zero, zero)
    points = rough.to_picture(motion.joints).reshape(-1, 2)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    if view != "fixed":  # the centre of gravity stays in the middle
        middle, half = zero, np.maximum(-low, high)
    height = max(half[1], half[0] / aspect) * VIEW_MARGIN[bool(motion.loads or motion.couples)]
    around = np.array([aspect * height, height])
    if np.abs(middle).max() > FAR_FROM_VIEW * height:
        unit = 10.0 ** math.ceil(math.log10(height))
        near = unit * np.round(middle / unit)
        origin, middle = origin + near, middle - near
    return Camera(view, origin, motion.axis, middle, around)


def ground_grid(origin: Array, angle: float, step: float, reach: float) -> Array:
    """Return the lines of the ground grid, a step apart, that pass a picture with this origin and
    angle within its reach [m], as one line with gaps: (3 lines, 2) in the picture's metres."""
    count = math.ceil(reach / step) + 1
    at = step * np.arange(-count, count + 1)
    near = -np.mod(origin, step)
    ends = np.broadcast_to(step * count * np.array([-1.0, 1.0]), (len(at), 2))
    upright = np.stack((np.broadcast_to((at + near[0])[:, None], ends.shape), ends), axis=-1)
    level = np.stack((ends, np.broadcast_to((at + near[1])[:, None], ends.shape)), axis=-1)
    gapped = np.full((2 * len(at), 3, 2), np.nan)
    gapped[:, :2] = np.concatenate((upright, level))
    return _turn(gapped.reshape(-1, 2), angle)
