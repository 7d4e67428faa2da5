"""Kinematics of the chain: the one place where geometry is written.

        phi_0        phi_1              phi_{n-1}
    o---------->o---------->o--- ... --->o
    joint 0     joint 1                  joint n (tail)

A point at the fraction xi of link p stands at

    r(p, xi) = r_0 + sum_q lever(q, p, xi) e(phi_q),    e(phi) = (cos phi, sin phi).

All else follows by differentiation: velocities, and what a link does to a point when it turns.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr, S, cos, sin

from .symbols import l

Vector = tuple[Expr, Expr]


@dataclass(frozen=True)
class Boundary:
    """How the start of the rod is held.

    translates: joint 0 moves freely, with coordinates x0, y0.
    first: the first link that moves; links before it are held at clamp_angle.
    root: stiffness of a spring in joint 0 that holds link 0 at clamp_angle, in springs between
    links (half a link bends there: twice as stiff), and internal damping there, in the same way.
    """

    translates: bool
    first: int
    root: int = 0

    @property
    def first_joint(self) -> int:
        """The first joint that moves."""
        return 0 if self.translates else self.first + 1

    @property
    def first_force(self) -> int:
        """The first joint that passes a force on to a moving link."""
        return 1 if self.translates else self.first

    @property
    def first_spring(self) -> int:
        """The first joint with a spring."""
        return 0 if self.root else 1

    @property
    def clamped(self) -> bool:
        """Whether a spring holds the rod at clamp_angle."""
        return bool(self.first or self.root)


BOUNDARIES: dict[str, Boundary] = {
    "free": Boundary(translates=True, first=0),
    "cantilever": Boundary(translates=False, first=1),
    "clamped": Boundary(translates=False, first=0, root=2),
    "pinned": Boundary(translates=False, first=0),
}

# Where a link stands in the chain relative to the link that carries the point.
BEFORE, OWN, AFTER = "before", "own", "after"


def lever(place: str, xi: Expr) -> Expr:
    """Length that a link contributes to the way from joint 0 to the point [m]."""
    return {BEFORE: l, OWN: xi * l, AFTER: S.Zero}[place]


def place(link: int, carrier: int) -> str:
    """Where ``link`` stands relative to the link ``carrier``."""
    return BEFORE if link < carrier else OWN if link == carrier else AFTER


def direction(angle: Expr) -> Vector:
    """Unit vector along a link."""
    return cos(angle), sin(angle)


def combine(origin: Vector, levers: Sequence[Expr], angles: Sequence[Expr]) -> Vector:
    """The point reached from ``origin`` along links of the given levers and angles."""
    ends = [
        (lever * e[0], lever * e[1])
        for lever, e in zip(levers, map(direction, angles), strict=True)
        if lever != 0
    ]
    return sum((x for x, _ in ends), origin[0]), sum((y for _, y in ends), origin[1])


def position(origin: Vector, angles: Sequence[Expr], carrier: int, xi: Expr) -> Vector:
    """r(carrier, xi) for given coordinates; joint s is (s, 0), the tail is (n-1, 1)."""
    levers = [lever(place(q, carrier), xi) for q in range(carrier + 1)]
    return combine(origin, levers, angles[: carrier + 1])
