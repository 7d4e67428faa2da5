"""Axial drag: the air brakes a point of the rod along its link."""

from typing import Any

from ..chain import Vector
from .air_force import AirForce
from .kinds import Value
from .point_law import PointMotion


class AxialDrag(AirForce):
    """Force along the link, -rho A C v v_t/2, with v the speed against the air and v_t its part
    along the link."""

    letter = "A_d"

    def force_at(self, of: PointMotion) -> Vector:
        (c, s), speed, along, _ = self.against_air(of)
        size = -self._half_mass * self.number("coefficient") * speed * along
        return size * c, size * s

    def force_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Any, ...]:
        half, speed, angle = self.against_air_by_hand(motion, value, functions)
        size = -half * value(self.number("coefficient")) * speed**2 * functions.cos(angle)
        link = motion.place[2]
        return size * functions.cos(link), size * functions.sin(link)


LOAD = AxialDrag()
