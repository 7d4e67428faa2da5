"""Couple at a point of the rod."""

from sympy import Expr

from .point_moment import PointMoment


class Moment(PointMoment):
    """Couple on a link, at the tail the last."""

    letter = "C"

    @property
    def moment(self) -> Expr:
        (size,) = self.parameters
        return size


LOAD = Moment()
