"""Tip load: a dead force at the tail, whose direction does not follow the rod."""

from sympy import Expr

from ..chain import Vector
from ..symbols import parameters
from .point_force import PointForce

F_X, F_Y = parameters("tip_load")


class TipLoad(PointForce):
    """Dead force at the tail."""

    letter = "T"

    def force(self, angle: Expr) -> Vector:
        return F_X, F_Y


LOAD = TipLoad()
