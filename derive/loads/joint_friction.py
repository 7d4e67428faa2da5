"""Dry friction in the joints."""

from typing import Any

from sympy import Expr, tanh

from rodgen.model.term import Parameter

from ..closed_form import Num
from .joint_law import BendMotion, JointLaw
from .kinds import Value


class JointFriction(JointLaw):
    """Moment m_f tanh(rate/omega_s) against the rate at which a joint bends: Coulomb's friction
    well above omega_s, a viscous one well below; m_f of a joint or of the length that bends in
    it."""

    letter = "D_f"

    def _size(self, motion: BendMotion, value: Value) -> Any:
        """The largest moment in a joint [N m]."""
        row: Parameter = self._rows[0]
        size = value(self.parameters[0])
        return size * motion.length if row.optional else size

    def moment(self, motion: BendMotion) -> Expr:
        return -self._size(motion, lambda of: of) * tanh(motion.rate / self.parameters[1])

    def moment_by_hand(self, motion: BendMotion, value: Value, functions: Any) -> Num:
        rate = motion.rate / value(self.parameters[1])
        return -self._size(motion, value) * functions.tanh(rate)


LOAD = JointFriction()
