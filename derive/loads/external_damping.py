"""External damping: the medium resists the joints that move across the rod."""

from typing import Any

from sympy import cos, sin

from ..chain import Vector
from ..closed_form import Pair
from ..symbols import parameters
from .joint_drag import JointDrag, JointMotion
from .kinds import Value

C_EXT, _ = parameters("external_damping")


class ExternalDamping(JointDrag):
    """Damping force -c_ext s a m v (thesis 2.56, 2.58), s the fin factor of the joint, and a =
    |sin(angle of v - angle of the rod)| the share of v across the rod."""

    letter = "D_e"
    array_name = "drag"

    def force(self, joint: JointMotion) -> Vector:
        across = abs(joint.vy * cos(joint.angle) - joint.vx * sin(joint.angle))
        (fin,) = joint.factors
        factor = C_EXT * fin * joint.mass * across / joint.divisor
        return -factor * joint.vx, -factor * joint.vy

    def force_by_hand(self, joint: JointMotion, value: Value, functions: Any) -> Pair:
        """Force on a joint, minus D_x and D_y of the thesis (2.56 to 2.59), by the angle of the
        velocity: D = c_ext s |sin(atan2(v_y, v_x) - angle)| m v."""
        a = abs(functions.sin(functions.atan2(joint.vy, joint.vx) - joint.angle))
        (fin,) = joint.factors
        factor = value(C_EXT) * fin * a * joint.mass
        return -factor * joint.vx, -factor * joint.vy


LOAD = ExternalDamping()
