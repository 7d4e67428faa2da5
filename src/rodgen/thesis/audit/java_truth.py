"""What the listing's methods must give: derived, never read off the thesis.

Everything comes from the explicit derivation of a free rod (Lagrange, virtual work), with its
functions of time renamed to plain symbols, which are also what the listing's members are filled
with: phi_i, omega_i, x_0, y_0, v_x0, v_y0, and for one link m, l, k.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

from sympy import Expr, S, Symbol

from rodgen.derive.calculus import TIME
from rodgen.derive.explicit import ExplicitDerivation
from rodgen.derive.loads import weight
from rodgen.derive.symbols import m, vx0, vy0, x0, y0

H = Symbol("h", positive=True)  # time step


@cache
def rod(n: int) -> ExplicitDerivation:
    """The derivation of a free rod of n uniform links."""
    return ExplicitDerivation(n)


def indexed(name: str, count: int) -> list[Expr]:
    """name_0, name_1, ..."""
    return [Symbol(f"{name}_{at}", real=True) for at in range(count)]


def phi(n: int) -> list[Expr]:
    """Angles of the links."""
    return indexed("phi", n)


def omega(n: int) -> list[Expr]:
    """Angular velocities of the links."""
    return indexed("omega", n)


def drag(n: int) -> tuple[list[Expr], list[Expr]]:
    """D_x, D_y: forces that resist at the joints."""
    x, y = zip(*rod(n).drag, strict=True)
    return list(x), list(y)


@cache
def _names(n: int) -> dict[Expr, Expr]:
    """Plain symbols by function of time: coordinates first [0], rates [1]."""
    coordinates = rod(n).coordinates
    rates = [q.diff(TIME) for q in coordinates]
    plain = [x0, y0, *phi(n), vx0, vy0, *omega(n)]
    return dict(zip([*coordinates, *rates], plain, strict=True))


def plain(n: int, poly: Any) -> Expr:
    """The expression of a polynomial of the derivation, in plain symbols."""
    return rod(n).calculus.expr(poly).xreplace(_names(n))


def vector(n: int, polys: Iterable[Any]) -> list[Expr]:
    """Expressions of a vector."""
    return [plain(n, poly) for poly in polys]


def matrix(n: int, rows: Iterable[Iterable[Any]]) -> list[list[Expr]]:
    """Expressions of a matrix."""
    return [vector(n, row) for row in rows]


def joints(n: int) -> list[Expr]:
    """x_0, y_0, x_1, y_1, ... of the joints."""
    return vector(n, (component for s in range(n + 1) for component in rod(n).joint(s)))


def joint_velocities(n: int) -> list[Expr]:
    """Their rates."""
    rates = (rod(n).rate(c) for s in range(n + 1) for c in rod(n).joint(s))
    return vector(n, rates)


def centre(n: int) -> list[Expr]:
    """Centre of gravity: the mean over the links of the mean over each."""
    derived = rod(n)
    means = [[derived.mean(component) for component in point] for point in derived.link_points]
    return [sum(vector(n, axis), start=S.Zero) / n for axis in zip(*means, strict=True)]


def kinetic_energy(n: int) -> Expr:
    """Half the mean square velocity times the mass."""
    return plain(n, rod(n).kinetic_energy)


def spring_energy(n: int) -> Expr:
    """Energy of the springs."""
    return plain(n, rod(n).spring_energy)


def gravity_energy(n: int) -> Expr:
    """Minus the work of the weights from the origin."""
    force = weight(n * m)
    return -sum((f * c for f, c in zip(force, centre(n), strict=True)), start=S.Zero)


def right_side(n: int) -> list[Expr]:
    """Q omega^2 - K phi - D_i omega + F + A - D_e."""
    derived, rates, angles = rod(n), omega(n), phi(n)
    squares = [w**2 for w in rates]
    return [
        _dot(q, squares) - _dot(k, angles) - _dot(d, rates) + f + a - e
        for q, k, d, f, a, e in zip(
            matrix(n, derived.velocity_matrix),
            matrix(n, derived.stiffness_matrix),
            matrix(n, derived.internal_damping),
            vector(n, derived.follower),
            vector(n, derived.gravity),
            vector(n, derived.external_damping),
            strict=True,
        )
    ]


def _dot(row: Sequence[Expr], column: Sequence[Expr]) -> Expr:
    total: Expr = sum((a * b for a, b in zip(row, column, strict=True)), start=S.Zero)
    return total
