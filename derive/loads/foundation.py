"""Elastic foundation: springs and dampers all along the rod, across the straight rod."""

from typing import Any

from sympy import Expr, S, Sum, cos, sin

from ..chain import Vector
from ..closed_form import Num, Pair
from ..generic_chain import GenericChain
from ..symbols import PARAMETERS, joint, joint_vx, joint_vy, n, parameters
from .joint_drag import JointDrag, JointMotion
from .kinds import Value

AXIS = parameters("foundation")[0]
OFFSET = PARAMETERS["foundation_offset"]


class Foundation(JointDrag):
    """Springs and dampers on every joint that moves: a force by its position and by its velocity.

    Energy: k w^2/2; w: distance from an axis, through the origin or at an offset from it.
    """

    letter = "W"
    by_position = True

    def spring_energy(self, joint: JointMotion) -> Expr:
        """Energy of the springs of a joint [J]."""
        k, _ = joint.factors
        return k * (cos(AXIS) * joint.y - sin(AXIS) * joint.x - self._offset) ** 2 / 2

    @property
    def _offset(self) -> Expr:
        return OFFSET if OFFSET in self.parameters else S.Zero

    def damper_force(self, joint: JointMotion) -> Vector:
        """Force of the dampers of a joint [N]."""
        _, c = joint.factors
        force = -c * (cos(AXIS) * joint.vy - sin(AXIS) * joint.vx)
        return -sin(AXIS) * force, cos(AXIS) * force

    def force(self, joint: JointMotion) -> Vector:
        energy, (x, y) = self.spring_energy(joint), self.damper_force(joint)
        return x - energy.diff(joint.x), y - energy.diff(joint.y)

    def power(self, chain: GenericChain) -> Expr:
        x, y = self.damper_force(self.motion(chain))
        power = x * joint_vx[joint] + y * joint_vy[joint]
        return Sum(power, (joint, chain.boundary_condition.first_joint, n))

    def energy(self, chain: GenericChain) -> Expr:
        return Sum(
            self.spring_energy(self.motion(chain)), (joint, chain.boundary_condition.first_joint, n)
        )

    def force_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        spring = self.spring_by_hand(joint, value, functions)
        damper = self.damper_by_hand(joint, value, functions)
        return spring[0] + damper[0], spring[1] + damper[1]

    def spring_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force of the springs of a joint: -k w along the normal (-sin, cos) of the axis."""
        k, _ = joint.factors
        rest = self.rest_by_hand(joint, value, functions)
        return self._normal_force(-k, joint.x - rest[0], joint.y - rest[1], value, functions)

    def damper_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force of the dampers of a joint: -c dw/dt along the normal of the axis."""
        _, c = joint.factors
        return self._normal_force(-c, joint.vx, joint.vy, value, functions)

    def rest_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Position at which the springs of a joint have no force."""
        if self._offset == 0:
            return 0 * joint.x, 0 * joint.y
        aside = value(OFFSET)
        return -functions.sin(value(AXIS)) * aside, functions.cos(value(AXIS)) * aside

    def _normal_force(self, factor: Num, x: Num, y: Num, value: Value, functions: Any) -> Pair:
        c, s = functions.cos(value(AXIS)), functions.sin(value(AXIS))
        way = c * y - s * x
        return -s * factor * way, c * factor * way


LOAD = Foundation()
