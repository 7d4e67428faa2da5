"""Internal damping: a moment across every joint that opposes its opening."""

from sympy import Expr

from ..closed_form import ClosedForm, Num
from ..link_properties import Joint
from ..symbols import m, parameters
from .kinds import JointMoment, Value

(C_INT,) = parameters("internal_damping")


class InternalDamping(JointMoment):
    """Moment in proportion to the mass of a link (thesis 2.50)."""

    letter = "D_i"

    def moment(self, before: Expr, after: Expr, joint: Joint) -> Expr:
        return -C_INT * m * joint.size * (after - before)

    def coefficient_by_hand(self, rod: ClosedForm, value: Value, at: Num, size: int) -> Num:
        """c_int m (thesis 2.52), and twice that in the root."""
        return size * value(C_INT) * rod.m


LOAD = InternalDamping()
