"""Wall: a half plane that no joint goes through, with dry friction along it."""

from __future__ import annotations

from typing import Any

import sympy
from sympy import Expr, Min, Piecewise, S, Sum, tanh

from ..chain import Vector
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

    def _seen(self, of: JointMotion, functions: Any, value: Value) -> Any:
        """Direction away from the wall, depth of a joint, its rate, and its speed along the wall,
        positive to the left of that direction: of the surface or, behind an edge, of the side to
        which the way out is shorter."""
        angle = value(self.number("normal"))
        c, s = functions.cos(angle), functions.sin(angle)
        x, y = (value(self.number("point", part)) for part in "01")
        depth = (x - of.x) * c + (y - of.y) * s
        if (edge := self.number("edge")) is not None:
            inside = value(edge) - (of.x - x) * s + (of.y - y) * c
            at_surface = inside - depth
            c, s = self._choose(at_surface, (c, s), (s, -c))
            depth = (Min if isinstance(depth, Expr) else min)(depth, inside)
        return (c, s), depth, -(of.vx * c + of.vy * s), c * of.vy - s * of.vx

    @staticmethod
    def _choose(by: Any, first: Any, second: Any) -> Any:
        """The first numbers, or symbols, where another is not negative, else the second ones."""
        if isinstance(by, Expr):
            pairs = zip(first, second, strict=True)
            return [Piecewise((a, by >= 0), (b, True)) for a, b in pairs]
        return first if by >= 0 else second

    def _friction(self, push: Expr, speed: Expr) -> Expr:
        """Force of friction along the wall [N] at a push and a speed."""
        if (mu := self.number("friction")) is None:
            return S.Zero
        return -mu * push * tanh(speed / self.number("friction_speed"))

    def force(self, of: JointMotion) -> Vector:
        (c, s), depth, rate, speed = self._seen(of, sympy, lambda e: e)
        push = of.length * self.push(depth, rate)
        along = self._friction(push, speed)
        return push * c - along * s, push * s + along * c

    def contact(self, chain: GenericChain) -> ContactState:
        motion = self.motion(chain)
        _, depth, rate, _ = self._seen(motion, sympy, lambda e: e)
        push = motion.length * self.push(depth, rate)
        return ContactState(depth, push, self.opening(rate), self._side(motion))

    def _side(self, of: JointMotion) -> Expr:
        """How much further it is to the edge than to the surface; one without an edge."""
        if (edge := self.number("edge")) is None:
            return S.One
        angle = self.number("normal")
        c, s = sympy.cos(angle), sympy.sin(angle)
        x, y = (of.x - self.number("point", "0"), of.y - self.number("point", "1"))
        return edge - x * s + y * c + x * c + y * s

    def power(self, chain: GenericChain) -> Expr:
        motion = self.motion(chain)
        _, depth, rate, speed = self._seen(motion, sympy, lambda e: e)
        push = motion.length * self.push(depth, rate)
        lost = motion.length * self.damping_power(depth, rate) + self._friction(push, speed) * speed
        return Sum(lost, (joint, chain.boundary_condition.first_joint, n))

    def energy(self, chain: GenericChain) -> Expr:
        motion = self.motion(chain)
        stored = motion.length * self.stored_energy(self.contact(chain).depth)
        return Sum(stored, (joint, chain.boundary_condition.first_joint, n))

    # By hand ------------------------------------------------------------------------------------

    def force_by_hand(self, of: JointMotion, value: Value, functions: Any) -> Pair:
        (c, s), depth, rate, speed = self._seen(of, functions, value)
        push = of.length * self.push_by_hand(depth, rate, value)
        along = self._friction_by_hand(push, speed, value, functions)
        return push * c - along * s, push * s + along * c

    def _friction_by_hand(self, push: Any, speed: Any, value: Value, functions: Any) -> Any:
        if (mu := self.number("friction")) is None:
            return 0 * push
        return -value(mu) * push * functions.tanh(speed / value(self.number("friction_speed")))

    def approach_by_hand(self, of: JointMotion, value: Value, functions: Any) -> tuple[Any, ...]:
        _, depth, rate, _ = self._seen(of, functions, value)
        return depth, rate, of.length

    def lost_by_hand(self, of: JointMotion, value: Value, functions: Any) -> Any:
        _, depth, rate, speed = self._seen(of, functions, value)
        push = of.length * self.push_by_hand(depth, rate, value)
        rubbed = self._friction_by_hand(push, speed, value, functions) * speed
        return super().lost_by_hand(of, value, functions) + rubbed


LOAD = Wall()
