"""Gravity on the mass of every link."""

from sympy import Expr, S

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from ..symbols import parameters
from .kinds import MassForce, Value

(G,) = parameters("gravity")


class Gravity(MassForce):
    """Weight, downwards (thesis 2.61)."""

    letter = "A"

    def weight(self, mass: Expr) -> Vector:
        return S.Zero, -mass * G

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        """(0, -n m g) (thesis 2.64, with gravity downwards)."""
        return 0 * value(G), -rod.total_mass * value(G)

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """-g m l (n - i - 1/2) cos phi_i (thesis 2.64)."""
        along, across = rod.first_moment(i)
        lever = along * rod.cos(rod.phi[i]) - across * rod.sin(rod.phi[i])
        return -value(G) * rod.l * lever


LOAD = Gravity()
