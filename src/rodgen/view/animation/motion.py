"""What an animation shows of a solution, as arrays over its samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rodgen.integrate import Solution
from rodgen.integrate.stepper import Array

NAMES = {"follower": "follower force", "tip_load": "tip load"}
# Where the largest bending of all is so many times that of nearly all samples, colours end there.
OUTLIER, COVERED = 3.0, 0.98


class Load(NamedTuple):
    """A force [N] and the point on which it acts [m], both (S, 2)."""

    point: Array
    force: Array


@dataclass(frozen=True)
class Motion:
    """t: times [s], (S,); joints: positions [m], (S, n+1, 2); centre: of gravity [m], (S, 2);
    axis: angle of the principal axis of the smaller moment, without jumps [rad], (S,); bending:
    in every joint, (S, n+1), and what it is called; loads: by name."""

    t: Array
    joints: Array
    centre: Array
    axis: Array
    bending: Array
    label: str
    loads: dict[str, Load]

    @property
    def bending_limit(self) -> float:
        """The bending at which the colours end: a blow-up at the end is not to hide the rest."""
        largest = np.abs(self.bending).max(axis=1)
        most, all_of_it = float(np.quantile(largest, COVERED)), float(largest.max())
        return most if 0 < most < all_of_it / OUTLIER else all_of_it or 1.0


def motion(solution: Solution) -> Motion:
    """Everything that is drawn, of every sample of a solution."""
    with np.errstate(all="ignore"):
        bending, label = _bending(solution)
        return Motion(
            solution.t,
            solution.joints,
            solution.centre_of_gravity,
            _axis(solution),
            np.nan_to_num(bending),
            label,
            _loads(solution),
        )


def _bending(solution: Solution) -> tuple[Array, str]:
    """Bending moments, or the curvature of a rod without stiffness, in every joint, (S, n+1)."""
    links = solution.scene.rod.links
    if solution.parameter("bending_stiffness").any():
        return solution.bending_moments, "bending moment [N m]"
    curvature = np.zeros((len(solution.t), links + 1))
    per_metre = links / solution.parameter("length")
    curvature[:, 1:-1] = np.diff(solution.phi, axis=1) * per_metre[:, None]
    return curvature, "curvature [1/m]"


def _axis(solution: Solution) -> Array:
    """An axis has no direction: it is followed from sample to sample, and points from tail to
    nose at the start."""
    angle: Array = np.unwrap(solution.principal_axes.angle, period=np.pi)
    rod = solution.joints[0, 0] - solution.joints[0, -1]
    along = np.array([np.cos(angle[0]), np.sin(angle[0])]) @ rod
    return angle if along >= 0 else angle + np.pi


def _loads(solution: Solution) -> dict[str, Load]:
    """Weight at the centre of gravity, and the forces on the tail."""
    found, terms = {}, solution.scene.loads.terms
    if "gravity" in terms:
        force = np.zeros_like(solution.centre_of_gravity)
        force[:, 1] = -solution.parameter("gravity") * solution.parameter("mass")
        found["weight"] = Load(solution.centre_of_gravity, force)
    for term, name in NAMES.items():
        if term in terms:
            found[name] = Load(solution.tip, solution.forces[term][:, -1])
    return found
