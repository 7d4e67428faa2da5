"""Distributed follower force: thrust all along the rod that turns with every link."""

from sympy import Expr, cos, sin

from ..chain import Vector
from ..closed_form import ClosedForm, Num
from ..symbols import l, parameters
from .kinds import Value
from .link_force import LinkForce

(Q,) = parameters("distributed_follower")


class DistributedFollower(LinkForce):
    """Thrust along every link, compressive for q > 0."""

    letter = "F_q"

    def force(self, angle: Expr, link: Expr) -> Vector:
        return -Q[link] * l * cos(angle), -Q[link] * l * sin(angle)

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """l^2 sum of q_j sin(phi_i - phi_j) over the links after link i."""

        def term_of(j: Num) -> Num:
            return value(Q)[j] * rod.sin(rod.phi[i] - rod.phi[j])

        return rod.l**2 * rod.arithmetic.total(term_of, i + 1, rod.n - 1)


LOAD = DistributedFollower()
