"""Elastic foundation: springs and dampers all along the rod, across the straight rod."""

from typing import Any

from sympy import Expr, cos, sin

from ..chain import Vector
from ..closed_form import Num, Pair
from ..symbols import parameters
from .joint_anchor import JointAnchor
from .joint_drag import JointMotion
from .kinds import Value

AXIS = parameters("foundation")[0]


class Foundation(JointAnchor):
    """Springs of energy k w^2/2, and dampers; w: distance from an axis through the origin."""

    letter = "W"

    def spring_energy(self, joint: JointMotion) -> Expr:
        k, _ = joint.factors
        return k * (cos(AXIS) * joint.y - sin(AXIS) * joint.x) ** 2 / 2

    def damper_force(self, joint: JointMotion) -> Vector:
        _, c = joint.factors
        force = -c * (cos(AXIS) * joint.vy - sin(AXIS) * joint.vx)
        return -sin(AXIS) * force, cos(AXIS) * force

    def spring_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """-k w along the normal (-sin, cos) of the axis."""
        k, _ = joint.factors
        return self._normal_force(-k, joint.x, joint.y, value, functions)

    def damper_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """-c dw/dt along the normal of the axis."""
        _, c = joint.factors
        return self._normal_force(-c, joint.vx, joint.vy, value, functions)

    def rest_by_hand(self, joint: JointMotion, value: Value) -> Pair:
        return 0 * joint.x, 0 * joint.y

    def _normal_force(self, factor: Num, x: Num, y: Num, value: Value, functions: Any) -> Pair:
        c, s = functions.cos(value(AXIS)), functions.sin(value(AXIS))
        way = c * y - s * x
        return -s * factor * way, c * factor * way


LOAD = Foundation()
