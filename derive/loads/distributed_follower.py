"""Distributed follower force: thrust all along the rod, or pressure, that turns with every link."""

from sympy import Expr, cos, sin

from ..chain import Vector
from ..closed_form import ClosedForm, Num
from ..symbols import PARAMETERS
from .kinds import Value
from .link_force import LinkForce

Q = PARAMETERS["distributed_follower"]


class DistributedFollower(LinkForce):
    """Thrust along every link, compressive for q > 0, or at an angle with it."""

    letter = "F_q"

    def force(self, angle: Expr, link: Expr) -> Vector:
        along = sum(self.angles, angle)  # with nu, where the scene has it
        pull = Q[link] * self.rod.length(link)
        return -pull * cos(along), -pull * sin(along)

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """l_i times the sum of q_j l_j sin(phi_i - phi_j - nu) over the links after link i, and
        half of that of link i itself."""
        q, nu = value(Q), [*map(value, self.angles)]

        def term_of(j: Num) -> Num:
            return q[j] * rod.length(j) * rod.sin(rod.phi[i] - sum(nu, rod.phi[j]))

        own = sum(rod.arithmetic.half * q[i] * rod.length(i) * rod.sin(angle) for angle in nu)
        return rod.length(i) * (rod.arithmetic.total(term_of, i + 1, rod.n - 1) - own)


LOAD = DistributedFollower()
