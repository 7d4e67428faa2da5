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

from .chain import Boundary

# Half a link bends at a clamped root: its spring is twice an inner joint's, and its damping too.
ROOT = 2

# Any kind of number: polynomial, Fraction, SymPy expression, mpf.
Num = Any
Pair = tuple[Num, Num]


@dataclass(frozen=True)
class Arithmetic:
    """What the closed form is computed with.

    cos, sin: of an angle or of sums of angles; half: the number 1/2; total: total(term, low,
    high) sums term(index) over low <= index <= high.
    """

    cos: Callable[[Num], Num]
    sin: Callable[[Num], Num]
    half: Num
    total: Callable[[Callable[[Num], Num], Num, Num], Num]


@dataclass(frozen=True)
class ClosedForm:
    """Entries and matrices of a rod of n links of mass m, length l, springs k.

    phi: all angles, held ones included; hold: how the start is held; lumped: half the mass of a
    link at each of its ends, not spread along it.
    """

    n: Num
    m: Num
    l: Num
    k: Num
    phi: Sequence[Num]
    hold: Boundary
    arithmetic: Arithmetic
    lumped: bool = False

    # Entries -------------------------------------------------------------------------------

    def w(self, i: Num) -> Num:
        """w_i = 1 + 2 (n - i - 1): the links after link i count twice, itself once."""
        return 1 + 2 * (self.n - i - 1)

    def _cos(self, angle: Num) -> Num:
        return self.arithmetic.cos(angle)

    def _sin(self, angle: Num) -> Num:
        return self.arithmetic.sin(angle)

    def M_base(self) -> Num:
        """M_00 = M_11 = (m/2) 2n (thesis 2.24, 2.25)."""
        return self.arithmetic.half * self.m * (2 * self.n)

    def M_base_link(self, i: Num) -> Pair:
        """M_0i, M_1i = (m/2) l w_i (-sin phi_i, cos phi_i) (thesis 2.24, 2.25)."""
        factor = self.arithmetic.half * self.m * self.l * self.w(i)
        return -factor * self._sin(self.phi[i]), factor * self._cos(self.phi[i])

    def M_link(self, i: Num) -> Num:
        """M_ii = (m/2) 2 l^2 (1/3 + n - i - 1), the third taken out (thesis 2.26); with half the
        mass of link i at its end, a half in place of the third."""
        if self.lumped:
            return self.arithmetic.half * self.m * self.l**2 * self.w(i)
        two_thirds = self.arithmetic.half * 4 / 3
        return self.arithmetic.half * self.m * self.l**2 * (1 + 3 * (self.n - i - 1)) * two_thirds

    def M_link_link(self, i: Num, j: Num, later: Num) -> Num:
        """M_ij = (m/2) l^2 w_max(i,j) cos(phi_i - phi_j) (thesis 2.26 with all its links)."""
        factor = self.arithmetic.half * self.m * self.l**2 * self.w(later)
        return factor * self._cos(self.phi[i] - self.phi[j])

    def Q_base_link(self, j: Num) -> Pair:
        """Q_0j, Q_1j = (m/2) l w_j (cos phi_j, sin phi_j) (thesis 2.27, 2.28)."""
        factor = self.arithmetic.half * self.m * self.l * self.w(j)
        return factor * self._cos(self.phi[j]), factor * self._sin(self.phi[j])

    def Q_link_link(self, i: Num, j: Num, later: Num) -> Num:
        """Q_ij = (m/2) l^2 w_max(i,j) sin(phi_j - phi_i) (thesis 2.44, its weights put right)."""
        factor = self.arithmetic.half * self.m * self.l**2 * self.w(later)
        return factor * self._sin(self.phi[j] - self.phi[i])

    @property
    def root(self) -> int:
        """How many inner joints the root is as stiff and as damped as."""
        return ROOT if self.hold.root else 0

    def bending_row(self, factor: Num, start: int, end: int) -> tuple[Num, Num, Num]:
        """Row of K or D_i of a link that starts and ends in as much as so many inner joints:
        coefficients of the link before (at the root the clamp), of itself, and of the link after
        (thesis 2.42, 2.52)."""
        return -start * factor, (start + end) * factor, -end * factor

    def F_base(self, P: Num, nu: Num) -> Pair:
        """-P (cos, sin)(phi_{n-1} + nu) (thesis 2.46, for thrust)."""
        tail = self.phi[self.n - 1]
        return -P * self._cos(tail + nu), -P * self._sin(tail + nu)

    def F_link(self, i: Num, P: Num, nu: Num) -> Num:
        """P l sin(phi_i - phi_{n-1} - nu) (thesis 2.47, for thrust)."""
        return P * self.l * self._sin(self.phi[i] - (self.phi[self.n - 1] + nu))

    def T_base(self, force: Pair) -> Pair:
        """The tip load."""
        return force

    def T_link(self, i: Num, force: Pair) -> Num:
        """l (cos phi_i F_y - sin phi_i F_x)."""
        return self.l * (self._cos(self.phi[i]) * force[1] - self._sin(self.phi[i]) * force[0])

    def A_base(self, g: Num) -> Pair:
        """(0, -n m g) (thesis 2.64, with gravity downwards)."""
        return 0 * g, -self.n * self.m * g

    def A_link(self, i: Num, g: Num) -> Num:
        """-g m l (n - i - 1/2) cos phi_i (thesis 2.64)."""
        factor = g * self.m * self.l * self.arithmetic.half * self.w(i)
        return -factor * self._cos(self.phi[i])

    def D_e_base(self, D: Pair) -> Pair:
        """Sum of the resisting forces D_x, D_y at all joints that move (thesis 2.60)."""
        x, y = D
        low, high = self.hold.first_joint, self.n
        total = self.arithmetic.total
        return total(x.__getitem__, low, high), total(y.__getitem__, low, high)

    def D_e_link(self, i: Num, D: Pair) -> Num:
        """l (cos phi_i sum D_y - sin phi_i sum D_x) over the joints after link i (thesis 2.60)."""
        x, y = (self.arithmetic.total(d.__getitem__, i + 1, self.n) for d in D)
        return self.l * (self._cos(self.phi[i]) * y - self._sin(self.phi[i]) * x)

    def joint_step(self, i: Num) -> Pair:
        """From joint i to joint i + 1: l (cos phi_i, sin phi_i)."""
        return self.l * self._cos(self.phi[i]), self.l * self._sin(self.phi[i])

    def velocity_step(self, i: Num, omega: Num) -> Pair:
        """Velocity of joint i + 1 less that of joint i: l omega_i (-sin, cos)(phi_i)
        (thesis 2.14)."""
        speed = self.l * omega
        return -speed * self._sin(self.phi[i]), speed * self._cos(self.phi[i])

    # Matrices: rows x0, y0 where joint 0 is free, then the moving links ----------------------

    @property
    def links(self) -> range:
        """The links that move."""
        return range(self.hold.first, self.n)

    def M(self) -> list[list[Num]]:
        """Mass matrix; columns as rows."""
        rows = [
            [self.M_link(i) if i == j else self.M_link_link(i, j, max(i, j)) for j in self.links]
            for i in self.links
        ]
        if not self.hold.translates:
            return rows
        zero = 0 * self.m
        x, y = zip(*map(self.M_base_link, self.links), strict=True)
        top = [[self.M_base(), zero, *x], [zero, self.M_base(), *y]]
        return top + [[x[r], y[r], *row] for r, row in enumerate(rows)]

    def Q(self) -> list[list[Num]]:
        """Factors of the squared rates; columns are the moving links."""
        rows = [
            [0 * self.m if i == j else self.Q_link_link(i, j, max(i, j)) for j in self.links]
            for i in self.links
        ]
        if not self.hold.translates:
            return rows
        return [*map(list, zip(*map(self.Q_base_link, self.links), strict=True)), *rows]

    def K(self) -> list[list[Num]]:
        """Columns are all links, a held one too; before them clamp_angle, where a root spring
        holds link 0 at it."""
        return self._bending(self.k, range(-1 if self.root else 0, self.n))

    def D_i(self, c_int: Num) -> list[list[Num]]:
        """Columns are the moving links: a held link and a clamp have no rate."""
        return self._bending(c_int * self.m, self.links)

    def _bending(self, factor: Num, columns: range) -> list[list[Num]]:
        zero = 0 * factor
        rows = [[zero for _ in columns] for _ in range(2 * self.hold.translates)]
        for i in self.links:
            row = self.bending_row(factor, 1 if i else self.root, int(i < self.n - 1))
            entries = dict(zip((i - 1, i, i + 1), row, strict=True))
            rows.append([entries.get(j, zero) for j in columns])
        return rows

    def F(self, P: Num, nu: Num) -> list[Num]:
        """Follower force."""
        return self._column(self.F_base(P, nu), lambda i: self.F_link(i, P, nu))

    def T(self, force: Pair) -> list[Num]:
        """Tip load."""
        return self._column(self.T_base(force), lambda i: self.T_link(i, force))

    def A(self, g: Num) -> list[Num]:
        """Gravity."""
        return self._column(self.A_base(g), lambda i: self.A_link(i, g))

    def D_e(self, D: Pair) -> list[Num]:
        """External damping, from the resisting forces at the joints."""
        return self._column(self.D_e_base(D), lambda i: self.D_e_link(i, D))

    def _column(self, base: Pair, link: Callable[[int], Num]) -> list[Num]:
        return [*(base if self.hold.translates else ()), *map(link, self.links)]


def joint_drag(c_ext: Num, fin_factor: Num, mass: Num, v: Pair, angle: Num, functions: Any) -> Pair:
    """D_x, D_y of one joint as the thesis has them (2.56 to 2.59), by the angle of the velocity:
    D = c_ext s |sin(atan2(v_y, v_x) - angle)| m v; mass is m, at both ends of the rod m/2."""
    a = abs(functions.sin(functions.atan2(v[1], v[0]) - angle))
    factor = c_ext * fin_factor * a * mass
    return factor * v[0], factor * v[1]
