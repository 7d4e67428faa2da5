"""Sensors: angle, rate, position and velocity of a point that is fixed to a link.

Positions are those of the chain, velocities their derivatives by time; derivatives by coordinates
are SymPy's.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Eq, Expr, Piecewise, S

from rodgen.model.rod import Boundary

from .chain import link_step
from .symbols import i, joint_vx, joint_vy, joint_x, joint_y, omega, phi

ANGLE, RATE = "phi", "omega"
AXES = {"x": 0, "y": 1, "vx": 0, "vy": 1}
STARTS = {"x": joint_x, "y": joint_y, "vx": joint_vx, "vy": joint_vy}  # of the link


@dataclass(frozen=True)
class SensorPoint:
    """A point at a share of a link, by its number; held: whether that link has no angle of its own;
    still: whether it does not move."""

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
        return STARTS[what][self.link] + _gain(what, self.link, self.share)

    def derivatives(self, what: str) -> tuple[Expr, Expr]:
        """Derivatives of a coordinate or a velocity by the angle and by the rate of link i, which
        is that of the point or one before it."""
        own, before = (_gain(what, i, share) for share in (self.share, S.One))
        by_angle, by_rate = (
            Piecewise((own.diff(x), Eq(i, self.link)), (before.diff(x), True))
            for x in (phi[i], omega[i])
        )
        return by_angle, by_rate


def _gain(what: str, link: Expr | int, share: Expr) -> Expr:
    """Change of a position or a velocity from the start of a link to a share of it."""
    return dict(zip(STARTS, link_step(link, share), strict=True))[what]


def point_at(at: Expr, links: int, boundary: Boundary) -> SensorPoint:
    """The point at s = at: on the link that begins at a joint, at the tail on the last."""
    link = min(int(at * links), links - 1)
    held, still = (link < first for first in (boundary.first, boundary.first_in_motion))
    return SensorPoint(link, at * links - link, held, still)
