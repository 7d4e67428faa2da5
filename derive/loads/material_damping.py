"""Material damping: the rod resists the rate at which it bends, as a Kelvin-Voigt solid does."""

from sympy import Expr

from ..closed_form import ClosedForm, Num
from ..link_properties import Joint
from ..symbols import parameters
from .kinds import JointMoment, Value

(TAU,) = parameters("material_damping")


class MaterialDamping(JointMoment):
    """Moment in proportion to the stiffness of the spring in the joint: with l = L/n, that of a rod
    whose bending moment is EI (curvature + tau its rate), whatever n."""

    letter = "D_m"

    def moment(self, before: Expr, after: Expr, joint: Joint) -> Expr:
        return -TAU * joint.stiffness * (after - before)

    def coefficient_by_hand(self, rod: ClosedForm, value: Value, at: Num, size: int) -> Num:
        """tau k of the joint."""
        return value(TAU) * rod.spring_stiffness(at, size)


LOAD = MaterialDamping()
