"""Gravity on the mass of every link: downwards, or along a given acceleration of free fall."""

from sympy import Expr, S

from rodgen.model.rod import Boundary

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from .kinds import MassForce, Value


class Gravity(MassForce):
    """Weight, downwards (thesis 2.61), or along the vector of free fall that the scene has."""

    letter = "A"

    def weight(self, mass: Expr, boundary: Boundary) -> Vector:
        if len(self.parameters) == 1:
            (g,) = self.parameters
            return S.Zero, -mass * g
        x, y = self.parameters
        return mass * x, mass * y

    def _fall_by_hand(self, value: Value) -> Pair:
        """Acceleration of free fall."""
        *x, y = map(value, self.parameters)
        return (x[0], y) if x else (0 * y, -y)

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        """(0, -n m g) (thesis 2.64, with gravity downwards), or n m times the vector."""
        x, y = self._fall_by_hand(value)
        return rod.total_mass * x, rod.total_mass * y

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """-g m l (n - i - 1/2) cos phi_i (thesis 2.64), or m l (n - i - 1/2) times the part of the
        vector across the link."""
        x, y = self._fall_by_hand(value)
        along, across = rod.first_moment(i)
        cos, sin = rod.cos(rod.phi[i]), rod.sin(rod.phi[i])
        return rod.length(i) * (y * (along * cos - across * sin) - x * (along * sin + across * cos))


LOAD = Gravity()
