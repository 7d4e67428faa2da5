"""Drag of a medium that moves: it resists the joints across and along the rod."""

from typing import Any

from sympy import S

from ..chain import Vector, direction
from ..closed_form import Pair
from .joint_drag import JointDrag, JointMotion
from .kinds import Value


class Drag(JointDrag):
    """Drag -w (c_n |v_n| v_n n + c_t |v_t| v_t e), v less the wind; e along the rod, n across it, w
    the length of rod at the joint."""

    letter = "D_w"

    @property
    def wind(self) -> Vector:
        x, y = self.parameters[2:]
        return x, y

    def force(self, joint: JointMotion) -> Vector:
        c_n, c_t, wind_x, wind_y = self.parameters
        v, e = (joint.vx - wind_x, joint.vy - wind_y), direction(joint.angle)
        normal = -e[1], e[0]
        total = [S.Zero, S.Zero]
        for c, unit in ((c_n, normal), (c_t, e)):
            part = v[0] * unit[0] + v[1] * unit[1]
            size = -joint.length * c * abs(part) * part
            total = [sum_ + size * u for sum_, u in zip(total, unit, strict=True)]
        return total[0], total[1]

    def force_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force on a joint, computed in the frame of the rod and turned back."""
        c_n, c_t, wind_x, wind_y = map(value, self.parameters)
        x, y = joint.vx - wind_x, joint.vy - wind_y
        c, s = functions.cos(joint.angle), functions.sin(joint.angle)
        along, across = c * x + s * y, c * y - s * x
        along *= -c_t * joint.length * abs(along)
        across *= -c_n * joint.length * abs(across)
        return c * along - s * across, s * along + c * across


LOAD = Drag()
