"""Springs and dampers between the joints and places that do not move."""

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
    """A force on every joint that moves, by its position and velocity: of springs, by the energy
    that they hold, and of dampers."""

    by_position = True

    @abstractmethod
    def stored(self, joint: JointMotion) -> Expr:
        """Energy of the springs of a joint [J]."""

    @abstractmethod
    def damper(self, joint: JointMotion) -> Vector:
        """Force of the dampers of a joint [N]."""

    def force(self, joint: JointMotion) -> Vector:
        energy, (x, y) = self.stored(joint), self.damper(joint)
        return x - energy.diff(joint.x), y - energy.diff(joint.y)

    def power(self, chain: GenericChain) -> Expr:
        x, y = self.damper(self.motion(chain))
        power = x * joint_vx[joint] + y * joint_vy[joint]
        return Sum(power, (joint, chain.hold.first_joint, n))

    def energy(self, chain: GenericChain) -> Expr:
        return Sum(self.stored(self.motion(chain)), (joint, chain.hold.first_joint, n))

    def force_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        spring = self.spring_by_hand(joint, value, functions)
        damper = self.damper_by_hand(joint, value, functions)
        return spring[0] + damper[0], spring[1] + damper[1]

    @abstractmethod
    def spring_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force of the springs of a joint."""

    @abstractmethod
    def damper_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force of its dampers."""

    @abstractmethod
    def rest_by_hand(self, joint: JointMotion, value: Value) -> Pair:
        """Where its springs have no force."""
