"""A rod as programs for mechanisms hold it: a chain of hinges, each with a spring and a damper.

Their coordinates are the angles between neighbours, ours are those to the x axis. A clamp is the
rest angle of the first hinge.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

import numpy as np

import rodgen
from rodgen.arrays import Array
from rodgen_evidence.report.peers.chain_accelerations import KNOWN as KNOWN


@dataclass(frozen=True)
class Tree:
    """The links that move: mass [kg], length [m] and moment of inertia about the centre [kg m^2]
    of each; translates: whether joint 0 moves; base: where the first hinge is [m]; rest: its
    angle without moment [rad]; stiffness [N m], damping [N m s]: of every hinge."""

    links: int
    mass: float
    length: float
    inertia: float
    translates: bool
    base: tuple[float, float]
    rest: float
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    gravity: float

    @classmethod
    def of(cls, scene: rodgen.Scene) -> Tree:
        """The tree of a scene."""
        given, n, held = scene.parameters, scene.rod.links, scene.n_fixed_links
        m, l = given["mass"] / n, given["length"] / n
        spring, damper = given["bending_stiffness"] / l, m * given.get("internal_damping", 0.0)
        clamp = given.get("clamp_angle", 0.0)
        # The hinge before the first link that moves, and those between.
        root = scene.boundary_condition.root
        first = (spring, damper) if held else (root * spring, root * damper)
        return cls(
            links=n - held,
            mass=m,
            length=l,
            inertia=m * l**2 / (12 if scene.rod.inertia == "uniform" else 4),
            translates=scene.boundary_condition.translates,
            base=(held * l * cos(clamp), held * l * sin(clamp)),
            rest=clamp,
            stiffness=(first[0], *[spring] * (n - held - 1)),
            damping=(first[1], *[damper] * (n - held - 1)),
            gravity=given.get("gravity", 0.0),
        )

    @property
    def sliders(self) -> int:
        """Coordinates before those of the hinges."""
        return 2 if self.translates else 0

    def relative(self, half: Array) -> Array:
        """x, y, phi_0, phi_1, ... to x, y, phi_0, phi_1 - phi_0, ...; rates and accelerations."""
        at = self.sliders
        return np.concatenate([half[: at + 1], np.diff(half[at:])])

    def absolute(self, halves: Array) -> Array:
        """The inverse of `relative`, of one or of many (..., coordinates)."""
        at = self.sliders
        return np.concatenate([halves[..., :at], np.cumsum(halves[..., at:], axis=-1)], axis=-1)
