"""The matrices of the model, assembled by hand: a second route to compare with, never emitted.

    M v' = Q omega^2 - K phi + F + A - D_i omega - D_e

Written for any arithmetic that knows cos, sin and sums: polynomials, exact rationals, symbols
with a symbolic number of links, or 50-digit numbers. Every entry has the factor m/2 of the
thesis taken inside. Sources: thesis 2.24 to 2.64, with its misprints and signs put right.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

# Any kind of number: polynomial, Fraction, SymPy expression, mpf.
Num = Any


@dataclass(frozen=True)
class ClosedForm:
    """Entries and matrices of a rod of n `uniform` links of mass m, length l, springs k.

    phi: all angles, held ones included; cos, sin: of one angle or a difference of angles;
    total: total(term, low, high) sums term(index) over low <= index <= high;
    translates, first: how the start is held (see chain.Boundary).
    """

    n: Num
    m: Num
    l: Num
    k: Num
    phi: Sequence[Num]
    cos: Callable[[Num], Num]
    sin: Callable[[Num], Num]
    half: Num
    total: Callable[[Callable[[Num], Num], Num, Num], Num]
    translates: bool = True
    first: int = 0

    # Entries -------------------------------------------------------------------------------

    def w(self, i: Num) -> Num:
        """w_i = 1 + 2 (n - i - 1): the links after link i count twice, itself once."""
        return 1 + 2 * (self.n - i - 1)

    def M_base(self) -> Num:
        return self.half * self.m * (2 * self.n)

    def M_base_link(self, i: Num) -> tuple[Num, Num]:
        factor = self.half * self.m * self.l * self.w(i)
        return -factor * self.sin(self.phi[i]), factor * self.cos(self.phi[i])

    def M_link(self, i: Num) -> Num:
        # 2 (1/3 + n - i - 1) = (2/3)(1 + 3 (n - i - 1))
        return self.half * self.m * self.l**2 * (1 + 3 * (self.n - i - 1)) * self._two_thirds

    def M_link_link(self, i: Num, j: Num, later: Num) -> Num:
        factor = self.half * self.m * self.l**2 * self.w(later)
        return factor * self.cos(self.phi[i] - self.phi[j])

    def Q_base_link(self, j: Num) -> tuple[Num, Num]:
        factor = self.half * self.m * self.l * self.w(j)
        return factor * self.cos(self.phi[j]), factor * self.sin(self.phi[j])

    def Q_link_link(self, i: Num, j: Num, later: Num) -> Num:
        factor = self.half * self.m * self.l**2 * self.w(later)
        return factor * self.sin(self.phi[j] - self.phi[i])

    def F_base(self, P: Num, nu: Num) -> tuple[Num, Num]:
        tail = self.phi[self.n - 1]
        return -P * self.cos(tail + nu), -P * self.sin(tail + nu)

    def F_link(self, i: Num, P: Num, nu: Num) -> Num:
        return P * self.l * self.sin(self.phi[i] - (self.phi[self.n - 1] + nu))

    def A_base(self, g: Num) -> tuple[Num, Num]:
        return 0 * g, -self.n * self.m * g

    def A_link(self, i: Num, g: Num) -> Num:
        return -g * self.m * self.l * self.half * self.w(i) * self.cos(self.phi[i])

    def D_e_base(self, D: tuple[Num, Num]) -> tuple[Num, Num]:
        """Sum of the resisting forces D_x, D_y at all joints."""
        x, y = D
        low, high = self.first_joint, self.n
        return self.total(x.__getitem__, low, high), self.total(y.__getitem__, low, high)

    def D_e_link(self, i: Num, D: tuple[Num, Num]) -> Num:
        x, y = (self.total(d.__getitem__, i + 1, self.n) for d in D)
        return self.l * (self.cos(self.phi[i]) * y - self.sin(self.phi[i]) * x)

    @property
    def _two_thirds(self) -> Num:
        return self.half * 4 / 3

    @property
    def first_joint(self) -> int:
        return 0 if self.translates else self.first + 1

    # Matrices: rows x0, y0 where joint 0 is free, then the moving links ----------------------

    @property
    def links(self) -> range:
        return range(self.first, self.n)

    def M(self) -> list[list[Num]]:
        rows = [
            [self.M_link(i) if i == j else self.M_link_link(i, j, max(i, j)) for j in self.links]
            for i in self.links
        ]
        if not self.translates:
            return rows
        zero = 0 * self.m
        x, y = zip(*map(self.M_base_link, self.links), strict=True)
        top = [[self.M_base(), zero, *x], [zero, self.M_base(), *y]]
        return top + [[x[r], y[r], *row] for r, row in enumerate(rows)]

    def Q(self) -> list[list[Num]]:
        rows = [
            [0 * self.m if i == j else self.Q_link_link(i, j, max(i, j)) for j in self.links]
            for i in self.links
        ]
        if not self.translates:
            return rows
        return [*map(list, zip(*map(self.Q_base_link, self.links), strict=True)), *rows]

    def K(self) -> list[list[Num]]:
        """Columns are all links: a held angle bends the first spring too."""
        return self._second_difference(self.k, range(self.n))

    def D_i(self, c_int: Num) -> list[list[Num]]:
        """Columns are the moving links: a held link has no rate."""
        return self._second_difference(c_int * self.m, self.links)

    def _second_difference(self, factor: Num, columns: range) -> list[list[Num]]:
        rows = [[0 * factor for _ in columns] for _ in range(2 * self.translates)]
        for i in self.links:
            springs = (i > 0) + (i < self.n - 1)
            entries = {i: springs * factor, i - 1: -factor, i + 1: -factor}
            rows.append([entries.get(j, 0 * factor) for j in columns])
        return rows

    def F(self, P: Num, nu: Num) -> list[Num]:
        return self._column(self.F_base(P, nu), lambda i: self.F_link(i, P, nu))

    def A(self, g: Num) -> list[Num]:
        return self._column(self.A_base(g), lambda i: self.A_link(i, g))

    def D_e(self, D: tuple[Num, Num]) -> list[Num]:
        return self._column(self.D_e_base(D), lambda i: self.D_e_link(i, D))

    def _column(self, base: tuple[Num, Num], link: Callable[[int], Num]) -> list[Num]:
        return [*(base if self.translates else ()), *map(link, self.links)]


def joint_drag(
    c_ext: Num,
    fin_factor: Num,
    mass: Num,
    v: tuple[Num, Num],
    angle: Num,
    functions: Any,
) -> tuple[Num, Num]:
    """D_x, D_y of one joint as the thesis has them (2.56 to 2.59), by the angle of the velocity:
    D = c_ext s |sin(atan2(v_y, v_x) - angle)| m v; mass is m, at both ends of the rod m/2."""
    a = abs(functions.sin(functions.atan2(v[1], v[0]) - angle))
    factor = c_ext * fin_factor * a * mass
    return factor * v[0], factor * v[1]


def joint_velocity(
    s: int, l: Num, phi: Sequence[Num], omega: Sequence[Num], v0: tuple[Num, Num], functions: Any
) -> tuple[Num, Num]:
    """Velocity of joint s: v0 + sum over the links before it of l omega (-sin, cos)."""
    vx = v0[0] - l * sum(omega[q] * functions.sin(phi[q]) for q in range(s))
    vy = v0[1] + l * sum(omega[q] * functions.cos(phi[q]) for q in range(s))
    return vx, vy
