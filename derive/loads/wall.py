"""Wall: a half plane that no joint goes through, with dry friction along it."""

from __future__ import annotations

from typing import Any

from sympy import Expr, Min, Piecewise, S, Sum, tanh

from ..chain import Vector, direction
from ..closed_form import Pair
from ..generic_chain import GenericChain
from ..symbols import joint, n
from .contact import Contact, ContactState
from .joint_drag import JointDrag, JointMotion
from .kinds import Value


class Wall(Contact, JointDrag):
    """A force on every joint that moves, by how deep it is behind a surface and by its velocity.

    Along the line mu N tanh(v/v_s) against the motion: Coulomb's friction where v is well above
    v_s, and a viscous one, which creeps, where it is well below.
    """

    letter = "Z"
    by_position = True

    def _seen(self, of: JointMotion) -> tuple[Vector, Expr, Expr, Expr]:
        """Direction away from the wall, depth of a joint, its rate, and its speed along the wall,
        positive to the left of that direction: of the surface or, behind an edge, of the side to
        which the way out is shorter."""
        c, s = direction(self.number("normal"))
        x, y = (self.number("point", part) for part in "01")
        depth = (x - of.x) * c + (y - of.y) * s
        if (edge := self.number("edge")) is not None:
            inside = edge - (of.x - x) * s + (of.y - y) * c
            here = inside - depth >= 0
            c, s = Piecewise((c, here), (s, True)), Piecewise((s, here), (-c, True))
            depth = Min(depth, inside)
        return (c, s), depth, -(of.vx * c + of.vy * s), c * of.vy - s * of.vx

    def _friction(self, push: Expr, speed: Expr) -> Expr:
        """Force of friction along the wall [N] at a push and a speed."""
        if (mu := self.number("friction")) is None:
            return S.Zero
        return -mu * push * tanh(speed / self.number("friction_speed"))

    def force(self, of: JointMotion) -> Vector:
        (c, s), depth, rate, speed = self._seen(of)
        push = of.length * self.push(depth, rate)
        along = self._friction(push, speed)
        return push * c - along * s, push * s + along * c

    def contact(self, chain: GenericChain) -> ContactState:
        motion = self.motion(chain)
        _, depth, rate, _ = self._seen(motion)
        push = motion.length * self.push(depth, rate)
        return ContactState(depth, push, self.opening(rate), self._side(motion))

    def _side(self, of: JointMotion) -> Expr:
        """How much further it is to the edge than to the surface; one without an edge."""
        if (edge := self.number("edge")) is None:
            return S.One
        c, s = direction(self.number("normal"))
        x, y = (of.x - self.number("point", "0"), of.y - self.number("point", "1"))
        return edge - x * s + y * c + x * c + y * s

    def power(self, chain: GenericChain) -> Expr:
        motion = self.motion(chain)
        _, depth, rate, speed = self._seen(motion)
        push = motion.length * self.push(depth, rate)
        lost = motion.length * self.damping_power(depth, rate) + self._friction(push, speed) * speed
        if lost == 0:
            return S.Zero
        return Sum(lost, (joint, chain.boundary_condition.first_joint, n))

    def energy(self, chain: GenericChain) -> Expr:
        motion = self.motion(chain)
        stored = motion.length * self.stored_energy(self.contact(chain).depth)
        return Sum(stored, (joint, chain.boundary_condition.first_joint, n))

    # By hand ------------------------------------------------------------------------------------

    def _frame_by_hand(self, of: JointMotion, value: Value, functions: Any) -> tuple[Any, ...]:
        """Frame of the wall, with axes to the right along its surface and away from it: whether a
        joint leaves through the side behind the edge, its depth, its speed outwards, and along the
        wall, positive as the first axis is if the second points outwards."""
        turned = value(self.number("normal")) - functions.pi / 2
        c, s = functions.cos(turned), functions.sin(turned)
        x, y = of.x - value(self.number("point", "0")), of.y - value(self.number("point", "1"))
        right, out = c * x + s * y, c * y - s * x
        v_right, v_out = c * of.vx + s * of.vy, c * of.vy - s * of.vx
        edge = self.number("edge")
        if edge is not None and value(edge) - right < -out:
            return True, value(edge) - right, v_right, -v_out
        return False, -out, v_out, v_right

    def force_by_hand(self, of: JointMotion, value: Value, functions: Any) -> Pair:
        sideways, depth, outwards, along = self._frame_by_hand(of, value, functions)
        push = of.length * self.push_by_hand(depth, -outwards, value)
        rub = self._rub_by_hand(push, along, value, functions)
        right, out = (push, -rub) if sideways else (rub, push)
        turned = value(self.number("normal")) - functions.pi / 2
        c, s = functions.cos(turned), functions.sin(turned)
        return c * right - s * out, s * right + c * out

    def _rub_by_hand(self, push: Any, along: Any, value: Value, functions: Any) -> Any:
        """Force of friction in the sense in which the speed along the wall counts."""
        if (mu := self.number("friction")) is None:
            return 0 * push
        return -value(mu) * push * functions.tanh(along / value(self.number("friction_speed")))

    def approach_by_hand(self, of: JointMotion, value: Value, functions: Any) -> tuple[Any, ...]:
        _, depth, outwards, _ = self._frame_by_hand(of, value, functions)
        return depth, -outwards, of.length

    def lost_by_hand(self, of: JointMotion, value: Value, functions: Any) -> Any:
        _, depth, outwards, along = self._frame_by_hand(of, value, functions)
        push = of.length * self.push_by_hand(depth, -outwards, value)
        rubbed = self._rub_by_hand(push, along, value, functions) * along
        return super().lost_by_hand(of, value, functions) + rubbed


LOAD = Wall()
