"""Kinematics of the chain, the one place where geometry is written, and its springs.

        phi_0        phi_1              phi_{n-1}
    o---------->o---------->o--- ... --->o
    joint 0     joint 1                  joint n (tail)

A point at the fraction xi of link p stands at

    r(p, xi) = r_0 + sum_q lever(q, p, xi) e(phi_q),    e(phi) = (cos phi, sin phi).

All else follows by differentiation: velocities, and what a link does to a point when it turns.
"""

from collections.abc import Callable, Sequence
from functools import cache

from sympy import Expr, S, cos, integrate, pi, sin
from sympy.physics.mechanics import dynamicsymbols

from .polynomials import TIME
from .symbols import bend, k, omega, phi

Vector = tuple[Expr, Expr]


# Where a link stands in the chain relative to the link that carries the point.
BEFORE, OWN, AFTER = "before", "own", "after"


# Moment of a spring of stiffness k that is bent by d: Hooke's law.
LINEAR = k * bend


@cache
def spring_energy(law: Expr) -> Expr:
    """Energy [J] of a spring bent by d: the integral of its moment's law over d, left as an
    Integral where SymPy has no rule."""
    found = integrate(law, bend, manual=True)
    return found - found.subs(bend, 0)


def spring_moment(bent: Expr, stiffness: Expr, law: Expr = LINEAR) -> Expr:
    """Moment [N m] of a rotary spring that is bent by this angle on the link before it; the link
    after gets the opposite."""
    return law.xreplace({bend: bent, k: stiffness}) if stiffness != 0 else S.Zero


def spring_potential(bent: Expr, stiffness: Expr = k, law: Expr = LINEAR) -> Expr:
    """Energy [J] of a rotary spring that is bent by this angle (thesis 2.19)."""
    return spring_moment(bent, stiffness, spring_energy(law))


def lever(place: str, xi: Expr, length: Expr) -> Expr:
    """Length [m] along a link of this length that the path from joint 0 to a point covers."""
    return {BEFORE: length, OWN: xi * length, AFTER: S.Zero}[place]


def side_lever(place: str, eta: Expr, length: Expr) -> Expr:
    """Length [m] across a link of this length that the path from joint 0 to a point covers."""
    return eta * length if place == OWN else S.Zero


def normal_angle(angle: Expr) -> Expr:
    """Angle of the normal to a link at this angle."""
    return angle + pi / 2


def relative_place(link: int, carrier: int) -> str:
    """Place of ``link`` relative to the link ``carrier``."""
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


def link_step(link: Expr | int, share: Expr, length: Expr) -> tuple[Expr, Expr, Expr, Expr]:
    """Derive the vector along a link of this length from its start to a share of it, and how fast
    it changes."""
    angle = dynamicsymbols("phi", real=True)
    way = combine((S.Zero, S.Zero), [lever(OWN, share, length)], [angle])
    known = {angle.diff(TIME): omega[link]}
    vx, vy = (e.diff(TIME).subs(known).subs(angle, phi[link]) for e in way)
    x, y = (e.subs(angle, phi[link]) for e in way)
    return x, y, vx, vy


def position(
    origin: Vector,
    angles: Sequence[Expr],
    length: Callable[[int], Expr],
    carrier: int,
    xi: Expr,
    eta: Expr = S.Zero,
) -> Vector:
    """Position of the point at xi of link ``carrier`` and, beside it, at eta of its length; joint s
    is (s, 0), the tail is (n-1, 1). length: of a link by its number."""
    levers = [lever(relative_place(q, carrier), xi, length(q)) for q in range(carrier + 1)]
    ways = [*levers, side_lever(OWN, eta, length(carrier))]
    return combine(origin, ways, [*angles[: carrier + 1], normal_angle(angles[carrier])])
