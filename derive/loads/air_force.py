"""Forces of the air on a point of a link, by the velocity of the point against the air."""

from __future__ import annotations

from typing import Any

from sympy import Expr, Float, S, atan2, sqrt, tanh

from ..chain import Vector, direction
from ..generic_chain import GenericChain
from ..symbols import joint_vx, joint_vy, phi
from .kinds import Value
from .point_law import PointLaw, PointMotion

# Square of a speed [m^2/s^2] that is added where one is divided by: none that counts.
LEAST = Float("1e-100")
AXES = "01"


class AirForce(PointLaw):
    """A force in proportion to the density of the air and to the reference area."""

    @property
    def _wind(self) -> Vector:
        """Velocity of the air."""
        x, y = (self.number("wind", axis) or S.Zero for axis in AXES)
        return x, y

    def against_air(self, of: PointMotion) -> tuple[Vector, Expr, Expr, Expr]:
        """Unit vector along the link, the speed of a point against the air, and its parts along the
        link and across it, to the left."""
        c, s = direction(of.angle)
        x, y = (v - w for v, w in zip(of.velocity, self._wind, strict=True))
        return (c, s), sqrt(x**2 + y**2 + LEAST), c * x + s * y, c * y - s * x

    def flow(self, chain: GenericChain) -> dict[str, Expr]:
        """Velocity of its point against the air, along the link and across it [m/s]; that may be
        one that is held."""
        moving, angle = self._moving_parts(chain.boundary_condition), phi[self.point.link]
        x, y = (sum((x * of[at] for at, x in moving), S.Zero) for of in (joint_vx, joint_vy))
        _, _, along, across = self.against_air(PointMotion((S.Zero, S.Zero), (x, y), angle))
        return {"along": along, "across": across}

    def measures(self, chain: GenericChain) -> dict[str, Expr]:
        """Speed of its point against the air [m/s], and the angle of attack from the way of its
        link towards the nose to that velocity [rad], which has no derivative at rest."""
        along, across = self.flow(chain).values()
        return {"airspeed": sqrt(along**2 + across**2), "attack": atan2(-across, -along)}

    @property
    def _half_mass(self) -> Expr:
        """Half of the density times the reference area [kg/m]."""
        density, area = self.number("density"), self.number("area")
        assert density is not None
        return density * area / 2

    def flow_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Any, Any]:
        """Velocity of a point against the air, along its link and across it, in numbers."""
        _, speed, angle = self.against_air_by_hand(motion, value, functions)
        return speed * functions.cos(angle), speed * functions.sin(angle)

    def against_air_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Any, ...]:
        """Half of the density times the area, the speed of a point against the air, and the angle
        from its link to that velocity."""
        wind = [0 if (w := self.number("wind", axis)) is None else value(w) for axis in AXES]
        x, y = (v - w for v, w in zip(motion.velocity[:2], wind, strict=True))
        half = value(self.number("area")) * value(self.number("density")) / 2
        return half, functions.hypot(x, y), functions.atan2(y, x) - motion.place[2]


class NormalForce(AirForce):
    """Force across the link, in proportion to the angle of attack until the flow stalls:
    -rho A C v^2 a tanh(v_n/(a v))/2, with C the slope of the coefficient of normal force, v the
    speed against the air, v_n its part across the link, and a the stall angle."""

    def force_at(self, of: PointMotion) -> Vector:
        (c, s), speed, _, across = self.against_air(of)
        stall = self.number("stall_angle")
        slope = self._half_mass * self.number("normal_slope")
        size = -slope * speed**2 * stall * tanh(across / (stall * speed))
        return -size * s, size * c

    def force_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Any, ...]:
        half, speed, angle = self.against_air_by_hand(motion, value, functions)
        stall, slope = value(self.number("stall_angle")), value(self.number("normal_slope"))
        coefficient = slope * stall * functions.tanh(functions.sin(angle) / stall)
        size = -half * speed**2 * coefficient
        normal = motion.place[2] + functions.pi / 2
        return size * functions.cos(normal), size * functions.sin(normal)
