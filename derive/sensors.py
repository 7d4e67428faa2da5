"""Sensors: angle, rate, position and velocity of a point that is fixed to a link.

Positions are those of the chain, velocities their derivatives by time; derivatives by coordinates
are SymPy's.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Eq, Expr, Piecewise, S
from sympy.physics.mechanics import dynamicsymbols

from rodgen.model.rod import Boundary

from .chain import BEFORE, OWN, combine, lever
from .polynomials import TIME
from .symbols import i, joint_vx, joint_vy, joint_x, joint_y, omega, phi

ANGLE, RATE = "phi", "omega"
AXES = {"x": 0, "y": 1, "vx": 0, "vy": 1}


@dataclass(frozen=True)
class SensorPoint:
    """A point at a share of a link, by its number; held: whether that link does not move."""

    link: int
    share: Expr
    held: bool = False

    def measurement(self, what: str) -> Expr:
        """Angle, rate, a coordinate or a velocity of the point."""
        if what == ANGLE:
            return phi[self.link]
        if what == RATE:
            return omega[self.link]
        at, way = (a[AXES[what]] for a in ((joint_x, joint_y), self._vector_along(self.link, OWN)))
        if what in ("vx", "vy"):
            if self.held:
                return S.Zero
            at, way = (joint_vx, joint_vy)[AXES[what]], _time_derivative(way, self.link)
        return at[self.link] + way

    def derivatives(self, what: str) -> tuple[Expr, Expr]:
        """Derivatives of a coordinate or a velocity by the angle and by the rate of link i, which
        is that of the point or one before it."""
        own, before = (self._link_derivatives(what, place) for place in (OWN, BEFORE))
        by_angle, by_rate = (
            Piecewise((a, Eq(i, self.link)), (b, True)) for a, b in zip(own, before, strict=True)
        )
        return by_angle, by_rate

    def _link_derivatives(self, what: str, place: str) -> tuple[Expr, Expr]:
        """Derivatives, by angle and by rate, of the part of link i in the vector to the point."""
        way = self._vector_along(i, place)[AXES[what]]
        if what in ("vx", "vy"):
            way = _time_derivative(way, i)
        return way.diff(phi[i]), way.diff(omega[i])

    def _vector_along(self, link: Expr | int, place: str) -> tuple[Expr, Expr]:
        """Vector along a link from its start: to the point on it (OWN), to its end (BEFORE)."""
        return combine((S.Zero, S.Zero), [lever(place, self.share)], [phi[link]])


def _time_derivative(way: Expr, link: Expr | int) -> Expr:
    """Derivative by time of an expression in the angle of a link."""
    angle = dynamicsymbols("phi", real=True)
    rate = way.subs(phi[link], angle).diff(TIME)
    return rate.subs(angle.diff(TIME), omega[link]).subs(angle, phi[link])


def point_at(at: Expr, links: int, boundary: Boundary) -> SensorPoint:
    """The point at s = at: on the link that begins at a joint, at the tail on the last."""
    link = min(int(at * links), links - 1)
    return SensorPoint(link, at * links - link, link < boundary.first)
