"""Springs and dampers between the joints and fixed points."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from sympy import Expr, Sum

from ..chain import Vector
from ..closed_form import Pair
from ..generic_chain import GenericChain
from ..symbols import joint, joint_vx, joint_vy, n
from .joint_drag import JointDrag, JointMotion
from .kinds import Value


class JointAnchor(JointDrag):
    """Springs and dampers on every joint that moves: a force by its position, from the energy of
    the springs, and one by its velocity."""

    by_position = True

    @abstractmethod
    def spring_energy(self, joint: JointMotion) -> Expr:
        """Energy of the springs of a joint [J]."""

    @abstractmethod
    def damper_force(self, joint: JointMotion) -> Vector:
        """Force of the dampers of a joint [N]."""

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

    @abstractmethod
    def spring_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force of the springs of a joint."""

    @abstractmethod
    def damper_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force of the dampers of a joint."""

    @abstractmethod
    def rest_by_hand(self, joint: JointMotion, value: Value) -> Pair:
        """Position at which the springs of a joint have no force."""
