"""Drag of a medium that moves: laws across and along the rod, by the velocity less the wind."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from sympy import S

from ..chain import Vector, direction
from ..closed_form import Num, Pair
from .joint_drag import JointDrag, JointMotion
from .kinds import Value


class MediumDrag(JointDrag):
    """Drag -w (c_n f(v_n) n + c_t f(v_t) e), v less the wind; e along the rod, n across it, w the
    length of rod at the joint, f the law of the medium."""

    @abstractmethod
    def law(self, speed: Num) -> Num:
        """The law of the medium, by the component of the velocity, in any arithmetic."""

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
            size = -joint.length * c * self.law(part)
            total = [sum_ + size * u for sum_, u in zip(total, unit, strict=True)]
        return total[0], total[1]

    def force_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force on a joint, computed in the frame of the rod and turned back."""
        c_n, c_t, wind_x, wind_y = map(value, self.parameters)
        x, y = joint.vx - wind_x, joint.vy - wind_y
        c, s = functions.cos(joint.angle), functions.sin(joint.angle)
        along = -c_t * joint.length * self.law(c * x + s * y)
        across = -c_n * joint.length * self.law(c * y - s * x)
        return c * along - s * across, s * along + c * across
