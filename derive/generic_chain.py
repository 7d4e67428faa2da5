"""A chain of any number of links: one mass point carried by two of them, from which all entries of
derivation 2 come; sums of levers over its mass, virtual work of forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import prod
from typing import NamedTuple

from sympy import (
    Eq,
    Expr,
    IndexedBase,
    Matrix,
    Piecewise,
    Poly,
    S,
    Sum,
    Symbol,
    expand,
    factor_terms,
    simplify,
    summation,
    symbols,
    trigsimp,
)
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from rodgen.model.rod import Boundary
from rodgen.model.terms import MOVING_BASE, boundary_of, load_places

from .base_motion import BaseMotion
from .chain import AFTER, BEFORE, OWN, Vector, combine, lever, normal_angle, side_lever
from .link_properties import Joint, Rod
from .polynomials import TIME
from .symbols import eta, i, joint, n, other, phi, s, xi


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


class AtSprings(NamedTuple):
    """Values for the springs in joint s between two links, in the root and in the tail."""

    inner: Expr
    root: Expr
    tail: Expr


class GenericChain:
    """A chain with n links for every n, before its loads and its equations.

    boundary, inertia, nonuniform, terms: as in `GeneralEquations`, which has them.
    """

    boundary: str
    inertia: str
    nonuniform: tuple[str, ...]
    terms: tuple[str, ...]

    @property
    def rod(self) -> Rod:
        """Distribution of mass and stiffness along the rod."""
        return Rod(self.inertia, self.nonuniform)

    @cached_property
    def boundary_condition(self) -> Boundary:
        """Boundary of the rod: how its ends are held."""
        return boundary_of(self.boundary, self.terms)

    @cached_property
    def base_motion(self) -> BaseMotion:
        """Motion of what holds the start of the rod."""
        return BaseMotion.of(load_places(self.terms).get(MOVING_BASE, ""))

    @cached_property
    def _generic(self) -> MassPoint:
        return mass_point(self.rod.has_offset_mass)

    def at_springs(
        self,
        of: Callable[[Expr, Expr, Joint], Expr],
        numbers: IndexedBase,
        at: Symbol = s,
    ) -> AtSprings:
        """Values of a function of the angles or rates of the links before and after a joint, or of
        the clamp there, and of the spring in the joint. at: index of an inner joint."""
        boundary, joint = self.boundary_condition, self.rod.joint
        clamp = self.base_motion.clamp_angle if numbers == phi else self.base_motion.angle[1]
        return AtSprings(
            of(numbers[at - 1], numbers[at], joint(at)),
            of(clamp, numbers[0], joint(0, boundary.root)),
            of(numbers[n - 1], clamp, joint(n, boundary.tail)),
        )

    def lever_moment(
        self, links: Sequence[Expr], powers: Sequence[int], sides: Sequence[int] = ()
    ) -> Expr:
        """Sum over the mass of all links of the product of levers**powers along the given links and
        levers**sides across them; links ascend."""
        sides = sides or [0] * len(links)
        lengths = [*map(self.rod.length, links)]

        def along(places: Sequence[str], share: Expr = xi) -> list[tuple[str, Expr, Expr]]:
            return [(place, share, length) for place, length in zip(places, lengths, strict=True)]

        def moment(places: Sequence[str], link: Expr) -> Expr:
            levers = [lever(*at) ** power for at, power in zip(along(places), powers, strict=True)]
            beside = zip(along(places, eta), sides, strict=True)
            levers += [side_lever(*at) ** power for at, power in beside]
            return self.rod.mass(link) * self.rod.mean(prod(levers, start=S.One), link)

        total = S.Zero
        for at in range(len(links) + 1):
            passed, ahead = [BEFORE] * at, [AFTER] * (len(links) - at)
            low = links[at - 1] + 1 if at else S.Zero
            high = links[at] - 1 if at < len(links) else n - 1
            total += self._sum_over_links(moment([*passed, *ahead], other), low, high)
            if ahead:
                total += moment([*passed, OWN, *ahead[1:]], links[at])
        return factor_terms(expand(total))

    def _sum_over_links(self, moment: Expr, low: Expr, high: Expr) -> Expr:
        """Sum over a range of links of a moment that differs by their mass alone."""
        if not self.rod.has_link_masses:
            return summation(moment, (other, low, high))
        mass = self.rod.mass(other)
        return moment / mass * Sum(mass, (other, low, high)) if moment != 0 else S.Zero

    def angle_force(self, force: Vector) -> Expr:
        """Generalised force on the angle of link i by a force at a lever of one."""
        generic = mass_point()
        (a_i, _), (dx, dy) = generic.a, generic.partial[0]
        work = (dx * force[0] + dy * force[1]).subs(a_i, 1)
        return work.xreplace({generic.angles[0]: phi[i]})

    def angle_force_of_mass(self, force: Vector) -> Expr:
        """Generalised force on the angle of link i by a force on every unit of mass."""
        work = self.lever_moment([i], [1]) * self.angle_force(force)
        if self.rod.has_offset_mass:
            # What is moved by a lever across is moved along the link, backwards.
            work += self.lever_moment([i], [0], [1]) * self.angle_force((force[1], -force[0]))
        return work

    @cached_property
    def joint_lever(self) -> Expr:
        """Lever of link i at the joint that ends it, which all joints behind have in common."""
        own, beyond = (lever(place, S.One, self.rod.length(i)) for place in (OWN, BEFORE))
        if own != beyond:
            raise ArithmeticError(f"levers {own} and {beyond} at the joints behind a link differ")
        return own

    def piecewise_at_ends(self, start: Expr, end: Expr, inner: Expr) -> Expr:
        """Value at a joint that moves, with other values at the ends of the rod."""
        cases = [(end, Eq(joint, n)), (inner, True)]
        if not self.boundary_condition.first_joint:
            cases.insert(0, (start, Eq(joint, 0)))
        return Piecewise(*cases)
