"""Forces of supports, predicted by each step of Newton's method for the next.

The force of a stiff spring is its stiffness times what its point is off. A linear step leaves an
error there of second order in the rotation, which the stiffness makes a force beyond all others; it
would spoil the next step. So each step is taken with the forces that the step before has predicted.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.analyse.steady_rod import SteadyRod, Unknowns
from rodgen.arrays import Array

TINY = 1e-6  # of the weight: tensions that give a chain no direction
CLOSED = 1e-10  # of the length, by which a chain may miss its ends


class SoftSprings(NamedTuple):
    """Parameters with soft springs of supports that pull by predicted forces, and what these lack
    beside the true ones: generalised force (base + n_moving,), in N and N m, and stiffness (base +
    n_moving, base + n_moving)."""

    p: Array
    force: Array
    stiffness: Array


@dataclass(frozen=True)
class SupportSprings:
    """The springs of the supports of a system with parameters p: links (k,) that they hold, share
    (k,) of each before the point, stiffness (k, 2) [N/m] and fixed points (k, 2) [m]."""

    rod: SteadyRod
    p: Array
    links: NDArray[np.intp]
    share: Array
    stiffness: Array
    fixed: Array

    @classmethod
    def of(cls, rod: SteadyRod, p: Array) -> SupportSprings:
        """Collect the springs that pull; none of a rod without supports."""
        share, *rest = (_link_values(rod, p, name) for name in NAMES)
        stiffness, fixed = (np.stack(pair, axis=-1) for pair in (rest[:2], rest[2:]))
        pulling = np.flatnonzero(stiffness.any(axis=-1))
        return cls(rod, p, pulling, share[pulling], stiffness[pulling], fixed[pulling])

    def points(self, at: Unknowns) -> Array:
        """Positions of the supported points (k, 2) [m]."""
        joints = self.rod.model.joints(self.rod.state_at_rest(at), self.p)
        share = self.share[:, None]
        return np.asarray((1 - share) * joints[self.links] + share * joints[self.links + 1])

    def forces(self, at: Unknowns) -> Array:
        """Forces on the rod (k, 2) [N]."""
        return self.stiffness * (self.fixed - self.points(at))

    def _point_derivatives(self, at: Unknowns) -> Array:
        """Derivatives of the points by position and angles (k, 2, base + n_moving)."""
        joints = np.append(self.links, self.links + 1)
        ways = self.rod.joint_derivatives(self.rod.state_at_rest(at), self.p, joints)
        starts, ends = np.split(ways, 2)
        share = self.share[:, None, None]
        return np.asarray((1 - share) * starts + share * ends)

    def predict_forces(self, at: Unknowns, by: Unknowns, times: float) -> Array:
        """Predict forces (k, 2) [N] after ``times`` times a change of the rod, to first order."""
        change = times * np.concatenate((by.position, by.phi))
        return self.forces(at) - self.stiffness * (self._point_derivatives(at) @ change)

    def soften(self, at: Unknowns, forces: Array) -> SoftSprings:
        """Replace the springs by soft ones that pull with these forces (k, 2) [N] from about a
        rod's length away, so that rounding of a place causes no error of a force."""
        most = np.abs(forces).max(axis=-1, keepdims=True) / self.rod.scene.rod.length
        soft = np.where(most > 0, np.minimum(self.stiffness, most), self.stiffness)
        off = np.divide(forces, soft, out=np.zeros_like(forces), where=soft > 0)
        fixed = np.where(soft > 0, self.points(at) + off, self.fixed)
        p, places = self.p.copy(), self.rod.scene.structure.slices
        for name, values in zip(NAMES[1:], (*soft.T, *fixed.T), strict=True):
            p[places[name]][self.links] = values
        ways = self._point_derivatives(at)
        force = np.einsum("ka,kai->i", self.forces(at) - forces, ways)
        return SoftSprings(p, force, np.einsum("ka,kai,kaj->ij", self.stiffness - soft, ways, ways))


NAMES = (
    "support_share",
    *("support_stiffness_x", "support_stiffness_y"),
    *("support_x", "support_y"),
)


def _link_values(rod: SteadyRod, p: Array, name: str) -> Array:
    """Values of a parameter on all links; zeros where the rod has no supports."""
    places = rod.scene.structure.slices
    return p[places[name]] if name in places else np.zeros(rod.scene.rod.links)


def hanging_shape(rod: SteadyRod, p: Array, pull: Array) -> Array:
    """Angles of moving links (n_moving,) [rad] of a rod that hangs from its supports: a catenary
    from each to the next, towards the pull (2,) [N], and straight along the pull at its ends."""
    springs = SupportSprings.of(rod, p)
    held = springs.stiffness.all(axis=-1)
    mesh = rod.scene.mesh
    at, points = mesh.at(springs.links + springs.share)[held], springs.fixed[held]
    if not rod.n_base:  # held at its start too
        start = rod.model.joints(rod.state_at_rest(rod.start_unknowns(rod.unloaded_angles)), p)[0]
        at, points = np.append(0.0, at), np.vstack((start, points))
    order = np.argsort(at)
    middles = mesh.middles
    along = float(np.arctan2(pull[1], pull[0]))
    phi = np.full(len(middles), along)
    if len(at):
        phi[middles < at.min()] = along + np.pi
    for one, other in itertools.pairwise(order):
        within = (middles >= at[one]) & (middles < at[other])
        share = (middles[within] - at[one]) / (at[other] - at[one])
        phi[within] = _catenary(
            points[other] - points[one], rod.scene.rod.length * (at[other] - at[one]), pull, share
        )
    return phi[rod.scene.n_fixed_links :]


def _catenary(chord: Array, length: float, pull: Array, share: Array) -> Array:
    """Angles [rad], at these shares of its length [m], of an even chain over a chord (2,) [m];
    straight where it is too short.

    Its links lie along the tension, which falls from end to end by the weight. The tension at the
    start, over the weight, minimises a convex function, whose slope is by how much the links miss
    the chord (the dual of the chain's least energy).
    """
    if np.hypot(*chord) >= length:
        return np.full(len(share), np.arctan2(chord[1], chord[0]))
    fall = share[:, None] * pull / np.hypot(*pull)

    def gap(tension: Array) -> tuple[float, Array]:
        along = tension - fall
        sizes = np.maximum(np.hypot(*along.T), TINY)
        ends = length * (along / sizes[:, None]).mean(axis=0)
        return float(length * sizes.mean() - chord @ tension), ends - chord

    # From above the middle, a little to the side where the ends are one above the other.
    aside = np.array([pull[1], -pull[0]]) / np.hypot(*pull) * TINY
    start = fall.mean(axis=0) + chord / length + aside
    found = scipy.optimize.minimize(
        gap, start, jac=True, method="BFGS", options={"gtol": CLOSED * length}
    ).x
    along = found - fall
    return np.asarray(np.arctan2(along[:, 1], along[:, 0]))
