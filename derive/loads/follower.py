"""Follower force: thrust that turns with its link, at the tail the last."""

from sympy import Expr, cos, sin

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from .kinds import Value
from .point_force import PointForce


class Follower(PointForce):
    """Thrust, compressive for P > 0 (thesis 2.46, with its sign, at the tail)."""

    letter = "F"

    def force(self, angle: Expr) -> Vector:
        P, nu = self.parameters
        return -P * cos(angle + nu), -P * sin(angle + nu)

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        """-P (cos, sin)(phi_{n-1} + nu) (thesis 2.46, for thrust)."""
        if self.is_inside:
            return super().base_by_hand(rod, value)
        P, nu = map(value, self.parameters)
        along = rod.phi[rod.n - 1] + nu
        return -P * rod.cos(along), -P * rod.sin(along)

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """P l sin(phi_i - phi_{n-1} - nu) (thesis 2.47, for thrust)."""
        if self.is_inside:
            return super().link_by_hand(rod, i, value)
        P, nu = map(value, self.parameters)
        return P * rod.length(i) * rod.sin(rod.phi[i] - (rod.phi[rod.n - 1] + nu))


LOAD = Follower()
