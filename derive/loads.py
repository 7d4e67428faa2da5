"""Springs and loads as local laws: potentials, forces at points, moments across joints.

What they do to the equations follows by virtual work, in explicit.py and in general.py.
"""

from dataclasses import dataclass

from sympy import Expr, Piecewise, S, cos, sin, sqrt

from .chain import Vector
from .symbols import C_EXT, C_INT, F_TIP, NU, G, P, k, m

# The terms that a scene may have, in the order in which names list them.
TERMS = ("follower", "gravity", "internal_damping", "external_damping", "tip_load")
# Those that take or give energy; gravity has a potential.
NON_CONSERVATIVE = ("follower", "internal_damping", "external_damping", "tip_load")


def spring_potential(before: Expr, after: Expr) -> Expr:
    """Energy of the rotary spring between two links at these angles [J] (thesis 2.19)."""
    return k * (after - before) ** 2 / 2


def damper_moment(before: Expr, after: Expr) -> Expr:
    """Moment of internal damping on the later link at these rates [N m] (thesis 2.50);
    the earlier link, or the clamp, gets the opposite."""
    return -C_INT * m * (after - before)


def follower_force(tail_angle: Expr) -> Vector:
    """Force at the tail [N]: thrust, compressive for P > 0 (thesis 2.46, with its sign)."""
    return -P * cos(tail_angle + NU), -P * sin(tail_angle + NU)


def tip_force() -> Vector:
    """Dead force at the tail [N]: its direction does not follow the rod."""
    return F_TIP


def weight(mass: Expr) -> Vector:
    """Gravity on a mass [N]."""
    return S.Zero, -mass * G


@dataclass(frozen=True)
class JointDrag:
    """What external damping needs to know of a joint: its velocity, the speed to divide by (see
    drag_divisor), the angle of the rod there (mean of the links that meet), the mass gathered
    there and its fin factor."""

    vx: Expr
    vy: Expr
    divisor: Expr
    angle: Expr
    mass: Expr
    fin_factor: Expr


def drag_divisor(vx: Expr, vy: Expr) -> Expr:
    """Speed of a joint; one at rest, where nothing goes across and any divisor gives no force."""
    speed = sqrt(vx**2 + vy**2)
    return Piecewise((speed, speed > 0), (1, True))


def drag_force(joint: JointDrag) -> Vector:
    """External damping at a joint [N] (thesis 2.56, 2.58): -c_ext s a m v, where
    a = |sin(angle of v - angle of the rod)| is the share of v across the rod."""
    across = abs(joint.vy * cos(joint.angle) - joint.vx * sin(joint.angle))
    factor = C_EXT * joint.fin_factor * joint.mass * across / joint.divisor
    return -factor * joint.vx, -factor * joint.vy


def joint_mass(links: int) -> Expr:
    """Mass gathered at a joint where this many links meet: half of each."""
    return links * m / 2


def joint_angle(angles: list[Expr]) -> Expr:
    """Angle of the rod at a joint: mean of the links that meet there."""
    return sum(angles[1:], angles[0]) / len(angles)
