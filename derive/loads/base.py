"""A moving base: in the frame that moves with it, a force on all mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sympy import Expr, S, Symbol
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary

from ..base_motion import BaseMotion
from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..symbols import i, s
from .kinds import GeneralisedForces, MassForce, Value

if TYPE_CHECKING:
    from ..general import GeneralEquations


class Base(MassForce):
    """Force on a mass against the acceleration of the joint from which the links move."""

    letter = "B"
    by_momentum = False

    @property
    def motion(self) -> BaseMotion:
        """Motion of the base, by the keys that are given."""
        return BaseMotion.of(self._given)

    @property
    def parameters(self) -> tuple[Symbol, ...]:
        """Symbols of its coordinates and of their derivatives."""
        courses = (self.motion.x, self.motion.y, self.motion.angle)
        return tuple(e for course in courses for e in course if e != 0)

    def weight(self, mass: Expr, boundary: Boundary) -> Vector:
        x, y = self.motion.of_first_joint(boundary, self.rod)
        return -mass * x, -mass * y

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        return [chain.forces_by_base()]

    def power_of(
        self, chain: GeneralEquations, behind: Vector, held: tuple[Expr, Expr, Expr]
    ) -> Expr:
        """Power [W] of what holds the rod: its force times the velocity of joint 0, and its moment
        times the rate of the clamp. behind, held: `Quantities.inertia`."""
        works = [work for name, work in chain.generalised_forces.items() if name != self.term]
        rate = self.motion.angle[1]
        total = rate * self._moment(chain, works, behind, held[2]) if rate != 0 else S.Zero
        for axis, v in enumerate(self.motion.of_start(1)):
            force = behind[axis] + held[axis] - sum((work.base[axis] for work in works), S.Zero)
            total += v * force
        return total

    def _moment(
        self, chain: GeneralEquations, works: list[GeneralisedForces], behind: Vector, held: Expr
    ) -> Expr:
        """Moment of the clamp on the rod [N m]: of its spring and damper or, where it holds link 0
        itself, what that link needs besides the loads and the joint at its end."""
        inner, root, tail = chain.moments
        if not chain.boundary_condition.first:
            return root - tail
        needed = chain.joint_lever * chain.angle_force(behind)
        needed -= sum((work.link for work in works), S.Zero)
        return held + needed.subs(i, 0) + inner.subs(s, 1)

    # Assembled by hand ------------------------------------------------------------------------

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        raise NotImplementedError  # of a rod that is held it has none

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """Minus the entries of M with x0 and y0 (thesis 2.24, 2.25), times the acceleration of the
        joint from which the links move: l (-sin, cos) phi_0'' - l (cos, sin) phi_0'^2 over that of
        joint 0, at the end of a held link."""
        x, y = rod.M_base_link(i)
        ax, ay = (value(a) if a != 0 else 0 * rod.l for a in self.motion.of_start(2))
        if rod.boundary.first:
            angle, rate, growth = value(self.motion.clamp_angle), *map(value, self.motion.angle[1:])
            c, sine = rod.length(0) * rod.cos(angle), rod.length(0) * rod.sin(angle)
            ax, ay = ax - sine * growth - c * rate**2, ay + c * growth - sine * rate**2
        return -(x * ax + y * ay)


LOAD = Base()
