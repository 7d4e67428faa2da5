"""Motion of what holds the start of a rod: given functions of time in place of zero.

A clamp or a pivot that moves gives joint 0 a place, a velocity and an acceleration, and a clamp
that turns the angle of what it holds. A held link moves with it, and the first joint behind it as
the kinematics of the chain say.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from sympy import Expr, S, Symbol
from sympy.physics.mechanics import dynamicsymbols

from rodgen.model.rod import Boundary
from rodgen.model.terms import BASE_ROWS

from .chain import Vector, link_step
from .link_properties import Rod
from .polynomials import TIME
from .symbols import ALPHA, PARAMETERS, alpha, omega, phi

# A coordinate of the base, how fast it changes and how fast that changes.
ORDERS = ("", "_rate", "_acceleration")
Course = tuple[Expr, Expr, Expr]
STILL: Course = (S.Zero, S.Zero, S.Zero)


def _course(name: str) -> Course:
    """A coordinate of the base and its derivatives, by the name of its parameter."""
    derivatives = (Symbol(f"{name}{order}", real=True) for order in ORDERS[1:])
    return (PARAMETERS[name], *derivatives)


@dataclass(frozen=True)
class BaseMotion:
    """Motion of the base: x and y of joint 0, and the angle of the clamp over ``clamp_angle``, each
    with its two derivatives by time."""

    x: Course = STILL
    y: Course = STILL
    angle: Course = STILL

    @classmethod
    def of(cls, keys: str) -> BaseMotion:
        """Motion by its keys: "x+angle"; what is not among them is still."""
        given = keys.split("+")
        return cls(**{one.key: _course(one.name) for one in BASE_ROWS if one.key in given})

    def of_start(self, order: int) -> Vector:
        """Place of joint 0 or, by the order, its velocity or its acceleration."""
        return self.x[order], self.y[order]

    @property
    def clamp_angle(self) -> Expr:
        """Angle at which the clamp holds the rod."""
        return ALPHA + self.angle[0]

    def of_first_joint(self, boundary: Boundary, rod: Rod) -> Vector:
        """Acceleration of the first joint that carries a link with an angle of its own: of joint 0
        or, where that link is held, of the joint at its end."""
        x, y = self.of_start(2)
        if boundary.first:
            held = phi[0], omega[0], alpha[0]
            values = dict(zip(held, (self.clamp_angle, *self.angle[1:]), strict=True))
            growth = link_growth(0, rod.length(0))
            x, y = (a + b.xreplace(values) for a, b in zip((x, y), growth, strict=True))
        return x, y


@cache
def link_growth(link: Expr | int, length: Expr) -> Vector:
    """Derive the acceleration of the end of a link of this length over that of its start."""
    angle = dynamicsymbols("phi", real=True)
    orders = zip((alpha, omega, phi), (2, 1, 0), strict=True)
    known = {angle.diff(TIME, order) if order else angle: of[link] for of, order in orders}
    x, y = (
        e.xreplace({phi[link]: angle}).diff(TIME, 2).subs(known)
        for e in link_step(link, S.One, length)[:2]
    )
    return x, y
