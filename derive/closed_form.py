"""The matrices of the model, assembled by hand: a second route to compare with, never emitted.

    M v' = Q omega^2 - K phi + rest + loads

The loads' own closed forms stand with them in loads/.
Written for any arithmetic that knows cos, sin and sums: polynomials, exact rationals, symbols
with a symbolic number of links, or 50-digit numbers. Every entry has the factor m/2 of the
thesis taken inside. Sources: thesis 2.24 to 2.64, with its misprints and signs put right.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any

from rodgen.model.rod import MASS_WAYS, Boundary

# Half a link bends at a clamped root: its spring is twice an inner joint's, and its damping too.
ROOT = 2

# Any kind of number: polynomial, Fraction, SymPy expression, mpf.
Num = Any
Pair = tuple[Num, Num]


@dataclass(frozen=True)
class Arithmetic:
    """Arithmetic in which the closed form is computed.

    cos, sin: of an angle or of sums of angles; half: the number 1/2; total: total(term, low,
    high) sums term(index) over low <= index <= high.
    """

    cos: Callable[[Num], Num]
    sin: Callable[[Num], Num]
    half: Num
    total: Callable[[Callable[[Num], Num], Num, Num], Num]


def link_sizes(mass: Num, length: Num, bending_stiffness: Num, n: Num) -> tuple[Num, Num, Num]:
    """Mass m and length l of a link, stiffness k of an inner joint: M/n, L/n, EI/l (thesis 2.1)."""
    l = length / n
    return mass / n, l, bending_stiffness / l


@dataclass(frozen=True)
class LinkMasses:
    """Mass properties of links by number: mass, centre of gravity along and across the link, and
    mean square distance of the mass from the start of the link, in lengths of the link."""

    mass: Callable[[Num], Num]
    along: Callable[[Num], Num]
    across: Callable[[Num], Num]
    second: Callable[[Num], Num]


def link_masses(
    nonuniform: Collection[str], of: Callable[[str], Any], lumped: bool, half: Num
) -> LinkMasses | None:
    """Mass properties of links that differ, from their parameters, else None. half: the number."""
    if MASS_WAYS.isdisjoint(nonuniform):
        return None
    mass, nothing = of("link_mass").__getitem__, 0 * half
    if "mass" in nonuniform:
        second = half if lumped else 2 * half / 3
        return LinkMasses(mass, lambda _: half, lambda _: nothing, lambda _: second)
    a = of("link_centre_along")
    if "points" in nonuniform:  # at both ends of the link
        return LinkMasses(mass, a.__getitem__, lambda _: nothing, a.__getitem__)
    b, s_aa, s_bb = map(of, ("link_centre_across", "link_spread_along", "link_spread_across"))
    return LinkMasses(
        mass,
        a.__getitem__,
        b.__getitem__,
        lambda q: a[q] ** 2 + b[q] ** 2 + s_aa[q] + s_bb[q],
    )


@dataclass(frozen=True)
class ClosedForm:
    """Entries and matrices of a rod of n links of mass m, length l, springs k.

    phi: all angles, held ones included; boundary: how the ends are held; lumped: half the mass of a
    link at each of its ends, not spread along it; stiffness: of every joint with a spring by its
    number, where they differ; links_differ: the mass of every link, where they differ; rest_angles:
    between links where the spring of a joint is at rest, by its number, where not zero; lengths: of
    every link, where they differ.
    """

    n: Num
    m: Num
    l: Num
    k: Num
    phi: Sequence[Num]
    boundary: Boundary
    arithmetic: Arithmetic
    lumped: bool = False
    stiffness: Any = None
    links_differ: LinkMasses | None = None
    rest_angles: Any = None
    lengths: Any = None

    # Entries -------------------------------------------------------------------------------

    def length(self, i: Num) -> Num:
        """Length of link i."""
        return self.l if self.lengths is None else self.lengths[i]

    def w(self, i: Num) -> Num:
        """w_i = 1 + 2 (n - i - 1): the links after link i count twice, itself once."""
        return 1 + 2 * (self.n - i - 1)

    def cos(self, angle: Num) -> Num:
        """Cosine in the arithmetic of the rod."""
        return self.arithmetic.cos(angle)

    def sin(self, angle: Num) -> Num:
        """Sine in the arithmetic of the rod."""
        return self.arithmetic.sin(angle)

    @property
    def total_mass(self) -> Num:
        """Total mass: n m, or the sum over links that differ."""
        if self.links_differ is None:
            return self.n * self.m
        return self.arithmetic.total(self.links_differ.mass, 0, self.n - 1)

    def mass_behind(self, i: Num) -> Num:
        """Mass of the links after link i, where they differ."""
        assert self.links_differ is not None
        return self.arithmetic.total(self.links_differ.mass, i + 1, self.n - 1)

    def first_moment(self, i: Num) -> Pair:
        """Integrals over all mass of its levers along and across link i, over the length of that;
        the first is (m/2) w_i and the second zero where links do not differ."""
        links = self.links_differ
        if links is None:
            return self.arithmetic.half * self.m * self.w(i), 0 * self.m
        m = links.mass(i)
        return m * links.along(i) + self.mass_behind(i), m * links.across(i)

    def M_base(self) -> Num:
        """M_00 = M_11 = (m/2) 2n (thesis 2.24, 2.25)."""
        return self.total_mass

    def M_base_link(self, i: Num) -> Pair:
        """M_0i, M_1i = (m/2) l w_i (-sin phi_i, cos phi_i) (thesis 2.24, 2.25)."""
        along, across = self.first_moment(i)
        c, s = self.cos(self.phi[i]), self.sin(self.phi[i])
        l = self.length(i)
        return -l * (along * s + across * c), l * (along * c - across * s)

    def M_link(self, i: Num) -> Num:
        """M_ii = (m/2) 2 l^2 (1/3 + n - i - 1), the third taken out (thesis 2.26); with half the
        mass of link i at its end, a half in place of the third."""
        if self.links_differ is not None:
            own = self.links_differ.mass(i) * self.links_differ.second(i)
            return self.length(i) ** 2 * (own + self.mass_behind(i))
        if self.lumped:
            return self.arithmetic.half * self.m * self.l**2 * self.w(i)
        two_thirds = self.arithmetic.half * 4 / 3
        return self.arithmetic.half * self.m * self.l**2 * (1 + 3 * (self.n - i - 1)) * two_thirds

    def M_link_link(self, i: Num, j: Num, later: Num) -> Num:
        """M_ij = (m/2) l^2 w_max(i,j) cos(phi_i - phi_j) (thesis 2.26 with all its links)."""
        along, across = self.first_moment(later)
        turned = along * self.cos(self.phi[i] - self.phi[j])
        if self.links_differ is not None:
            earlier = i if later == j else j
            turned -= across * self.sin(self.phi[later] - self.phi[earlier])
        return self.length(i) * self.length(j) * turned

    def Q_base_link(self, j: Num) -> Pair:
        """Q_0j, Q_1j = (m/2) l w_j (cos phi_j, sin phi_j) (thesis 2.27, 2.28)."""
        along, across = self.first_moment(j)
        c, s = self.cos(self.phi[j]), self.sin(self.phi[j])
        l = self.length(j)
        return l * (along * c - across * s), l * (along * s + across * c)

    def Q_link_link(self, i: Num, j: Num, later: Num) -> Num:
        """Q_ij = (m/2) l^2 w_max(i,j) sin(phi_j - phi_i) (thesis 2.44, its weights put right)."""
        along, across = self.first_moment(later)
        turned = along * self.sin(self.phi[j] - self.phi[i])
        if self.links_differ is not None:
            sign = 1 if later == j else -1
            turned += sign * across * self.cos(self.phi[i] - self.phi[j])
        return self.length(i) * self.length(j) * turned

    @property
    def root_size(self) -> int:
        """Size of the spring and damper in the root, in those of an inner joint."""
        return ROOT if self.boundary.root else 0

    @property
    def tail_size(self) -> int:
        """Size of the spring and damper in the tail, in those of an inner joint."""
        return self.boundary.tail

    def spring_stiffness(self, at: Num, size: int) -> Num:
        """Stiffness of the spring in joint ``at``; where joints do not differ, ``size`` times that
        of an inner joint."""
        if self.stiffness is None or not size:
            return size * self.k
        return self.stiffness[at]

    def bending_row(self, start: Num, end: Num) -> tuple[Num, Num, Num]:
        """Row of K or D_i of a link, from the coefficients of the joints at its start and end:
        columns of the link before (at the root the clamp), of itself, and of the link after (thesis
        2.42, 2.52)."""
        return -start, start + end, -end

    def rest_moment(self, at: Num, size: int) -> Num:
        """Moment of the spring in joint ``at`` on the link after it, where both its links are at
        the same angle: stiffness times rest angle."""
        if self.rest_angles is None or not size:
            return 0 * self.k
        return self.spring_stiffness(at, size) * self.rest_angles[at]

    def force_moment(self, i: Num, force: Pair) -> Num:
        """Generalised force on the angle of link i by a force at its end or behind it: l (cos phi_i
        F_y - sin phi_i F_x)."""
        c, s = self.cos(self.phi[i]), self.sin(self.phi[i])
        return self.length(i) * (c * force[1] - s * force[0])

    def lever_share(self, i: Num, link: Num, share: Num) -> Num:
        """Share of link i that lies before a point: 1 for links before that of the point, ``share``
        for its own link, else 0."""
        return 1 if i < link else share if i == link else 0

    def total(self, of: Any, low: Num, high: Num) -> Num:
        """Sum of the elements of ``of`` from low to high."""
        return self.arithmetic.total(of.__getitem__, low, high)

    def joint_step(self, i: Num) -> Pair:
        """Vector from joint i to joint i + 1: l (cos phi_i, sin phi_i)."""
        return self.length(i) * self.cos(self.phi[i]), self.length(i) * self.sin(self.phi[i])

    def velocity_step(self, i: Num, omega: Num) -> Pair:
        """Velocity of joint i + 1 less that of joint i: l omega_i (-sin, cos)(phi_i)
        (thesis 2.14)."""
        speed = self.length(i) * omega
        return -speed * self.sin(self.phi[i]), speed * self.cos(self.phi[i])

    # Matrices: rows x0, y0 where joint 0 is free, then the moving links ----------------------

    @property
    def links(self) -> range:
        """The links that move."""
        return range(self.boundary.first, self.n)

    def M(self) -> list[list[Num]]:
        """Mass matrix; columns as rows."""
        rows = [
            [self.M_link(i) if i == j else self.M_link_link(i, j, max(i, j)) for j in self.links]
            for i in self.links
        ]
        if not self.boundary.translates:
            return rows
        zero = 0 * self.m
        x, y = zip(*map(self.M_base_link, self.links), strict=True)
        top = [[self.M_base(), zero, *x], [zero, self.M_base(), *y]]
        return top + [[x[r], y[r], *row] for r, row in enumerate(rows)]

    def Q(self) -> list[list[Num]]:
        """Matrix of factors of the squared rates; columns are the moving links."""
        rows = [
            [0 * self.m if i == j else self.Q_link_link(i, j, max(i, j)) for j in self.links]
            for i in self.links
        ]
        if not self.boundary.translates:
            return rows
        return [*map(list, zip(*map(self.Q_base_link, self.links), strict=True)), *rows]

    def K(self) -> list[list[Num]]:
        """Stiffness matrix; columns are all links, a held one too, and clamp_angle before and
        behind them where a spring in the root or in the tail holds a link at it."""
        return self._bending_rows(
            self.spring_stiffness, range(-1 if self.root_size else 0, self.n + bool(self.tail_size))
        )

    def rest(self) -> list[Num]:
        """Moments on the links by springs that are bent at rest: what the springs do beside K."""
        rows = [0 * self.k for _ in range(2 * self.boundary.translates)]
        for i in self.links:
            start, end = self.joint_sizes(i)
            rows.append(self.rest_moment(i, start) - self.rest_moment(i + 1, end))
        return rows

    def joint_sizes(self, i: Num) -> tuple[int, int]:
        """Sizes of the springs at the start and the end of link i, in those of an inner joint."""
        return 1 if i else self.root_size, 1 if i < self.n - 1 else self.tail_size

    def damping(self, factor: Callable[[Num, int], Num]) -> list[list[Num]]:
        """Matrix D_i, from the coefficient of each joint by number and size; columns are the moving
        links, since a held link and a clamp have no rate."""
        return self._bending_rows(factor, self.links)

    def _bending_rows(self, of: Callable[[Num, int], Num], columns: range) -> list[list[Num]]:
        """Rows of K or D_i, from the coefficient of each joint by number and size."""
        zero = 0 * self.k
        rows = [[zero for _ in columns] for _ in range(2 * self.boundary.translates)]
        for i in self.links:
            start, end = self.joint_sizes(i)
            row = self.bending_row(of(i, start), of(i + 1, end))
            entries = dict(zip((i - 1, i, i + 1), row, strict=True))
            rows.append([entries.get(j, zero) for j in columns])
        return rows
