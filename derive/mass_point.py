"""One mass point carried by two generic links: the source of all entries of derivation 2."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import prod

from sympy import Expr, Matrix, Poly, S, Symbol, expand, simplify, symbols, trigsimp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from .chain import Vector, combine, normal_angle
from .polynomials import TIME


@dataclass(frozen=True)
class MassPoint:
    """Equations of a mass point mu carried by links i < j at the levers a_i, a_j along them and,
    where there is mass beside the links, b_i, b_j across them."""

    a: tuple[Symbol, ...]
    b: tuple[Symbol, ...]
    mu: Symbol
    angles: tuple[Expr, Expr]
    mass: list[list[Expr]]
    velocity: list[list[Expr]]
    partial: list[Vector]


@cache
def mass_point(sided: bool = False) -> MassPoint:
    """Derive the mass point; sided: with levers across its links as well."""
    a = symbols("a_i a_j", positive=True)
    b = symbols("b_i b_j", real=True) if sided else ()
    mu = Symbol("mu", positive=True)
    x, y, phi_i, phi_j = q = dynamicsymbols("x y phi_i phi_j", real=True)
    ways = [phi_i, phi_j, normal_angle(phi_i), normal_angle(phi_j)]
    r = combine((x, y), (*a, *b), ways[: len(a) + len(b)])
    v = [c.diff(TIME) for c in r]
    method = LagrangesMethod(mu / 2 * (v[0] ** 2 + v[1] ** 2), q)
    method.form_lagranges_equations()
    rates = [phi_i.diff(TIME), phi_j.diff(TIME)]
    forcing = [expand(e) for e in method.forcing]
    velocity = [[e.coeff(rate, 2) for rate in rates] for e in forcing]
    left = [
        simplify(e - sum(c * u**2 for c, u in zip(row, rates, strict=True)))
        for e, row in zip(forcing, velocity, strict=True)
    ]
    mass = [[_by_lever(e, (*a, *b)) for e in row] for row in method.mass_matrix.tolist()]
    partial = [(r[0].diff(p), r[1].diff(p)) for p in (phi_i, phi_j)]
    # What the blocks of M and Q below take for granted.
    nothing = [*left, mass[0][1], mass[0][0] - mass[1][1], velocity[2][0], velocity[3][1]]
    if any(nothing) or Matrix(mass) != Matrix(mass).T:
        raise ArithmeticError(
            f"M or Q of a mass point is not of the form assumed: {mass}, {nothing}"
        )
    return MassPoint(a, b, mu, (phi_i, phi_j), mass, velocity, partial)


def _by_lever(entry: Expr, levers: Sequence[Symbol]) -> Expr:
    """Entry with its factor of every product of levers in its shortest form."""
    if len(levers) == 2:
        return trigsimp(entry)
    terms = Poly(expand(entry), *levers).terms()
    products = (
        trigsimp(c) * prod(x**p for x, p in zip(levers, at, strict=True)) for at, c in terms
    )
    return sum(products, start=S.Zero)
