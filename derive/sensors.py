"""Sensors: angle, rate, position and velocity of a point that is fixed to a link.

Positions are those of the chain, velocities their derivatives by time; derivatives by coordinates
are SymPy's.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Eq, Expr, Piecewise, S

from rodgen.model.rod import Boundary

from .chain import link_step
from .link_properties import Rod
from .symbols import i, joint_vx, joint_vy, joint_x, joint_y, omega, phi

ANGLE, RATE = "phi", "omega"
AXES = {"x": 0, "y": 1, "vx": 0, "vy": 1}
STARTS = {"x": joint_x, "y": joint_y, "vx": joint_vx, "vy": joint_vy}  # of the link


@dataclass(frozen=True)
class SensorPoint:
    """A point at a share of a link of a rod, by its number; held: whether that link has no angle of
    its own; still: whether it does not move."""

    rod: Rod
    link: int
    share: Expr
    held: bool = False
    still: bool = False

    def measurement(self, what: str) -> Expr:
        """Angle, rate, a coordinate or a velocity of the point."""
        if what == ANGLE:
            return phi[self.link]
        if what == RATE:
            return omega[self.link]
        if self.still and what in ("vx", "vy"):
            return S.Zero
        return STARTS[what][self.link] + self._gain(what, self.link, self.share)

    def derivatives(self, what: str) -> tuple[Expr, Expr]:
        """Derivatives of a coordinate or a velocity by the angle and by the rate of link i, which
        is that of the point or one before it."""
        own, before = (self._gain(what, i, share) for share in (self.share, S.One))
        by_angle, by_rate = (
            Piecewise((own.diff(x), Eq(i, self.link)), (before.diff(x), True))
            for x in (phi[i], omega[i])
        )
        return by_angle, by_rate

    def _gain(self, what: str, link: Expr | int, share: Expr) -> Expr:
        """Change of a position or a velocity from the start of a link to a share of it."""
        step = link_step(link, share, self.rod.length(link))
        return dict(zip(STARTS, step, strict=True))[what]


def point_at(place: Expr, links: int, boundary: Boundary, rod: Rod) -> SensorPoint:
    """The point at a place, the number of a link and a share of it: on the link that begins at a
    joint, at the tail on the last."""
    link = min(int(place), links - 1)
    held, still = (link < first for first in (boundary.first, boundary.first_in_motion))
    return SensorPoint(rod, link, place - link, held, still)
