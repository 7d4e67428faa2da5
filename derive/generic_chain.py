"""A chain of any number of links: sums of levers over its mass, virtual work of forces."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import prod

from sympy import Eq, Expr, Piecewise, S, Sum, expand, factor_terms, summation

from rodgen.model.rod import BOUNDARIES, Boundary

from .chain import AFTER, BEFORE, OWN, Vector, lever, side_lever
from .link_properties import Rod
from .mass_point import MassPoint, mass_point
from .symbols import eta, i, joint, n, other, phi, xi


class GenericChain:
    """A chain with n links for every n, before its loads and its equations.

    boundary, inertia, nonuniform: as in `GeneralEquations`, which has them.
    """

    boundary: str
    inertia: str
    nonuniform: tuple[str, ...]

    @property
    def rod(self) -> Rod:
        """Distribution of mass and stiffness along the rod."""
        return Rod(self.inertia, self.nonuniform)

    @cached_property
    def boundary_condition(self) -> Boundary:
        """Boundary of the rod: how its ends are held."""
        return BOUNDARIES[self.boundary]

    @cached_property
    def _generic(self) -> MassPoint:
        return mass_point(self.rod.has_offset_mass)

    def lever_moment(
        self, links: Sequence[Expr], powers: Sequence[int], sides: Sequence[int] = ()
    ) -> Expr:
        """Sum over the mass of all links of the product of levers**powers along the given links and
        levers**sides across them; links ascend."""
        sides = sides or [0] * len(links)

        def moment(places: Sequence[str], link: Expr) -> Expr:
            levers = [lever(p, xi) ** power for p, power in zip(places, powers, strict=True)]
            levers += [side_lever(p, eta) ** power for p, power in zip(places, sides, strict=True)]
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
        if (
            self.rod.has_offset_mass
        ):  # what is moved by a lever across is moved along the link, backwards
            work += self.lever_moment([i], [0], [1]) * self.angle_force((force[1], -force[0]))
        return work

    @cached_property
    def joint_lever(self) -> Expr:
        """Lever of link i at the joint that ends it, which all joints behind have in common."""
        own, beyond = (lever(place, S.One) for place in (OWN, BEFORE))
        if own != beyond:
            raise ArithmeticError(f"levers {own} and {beyond} at the joints behind a link differ")
        return own

    def piecewise_at_ends(self, start: Expr, end: Expr, inner: Expr) -> Expr:
        """Value at a joint that moves, with other values at the ends of the rod."""
        cases = [(end, Eq(joint, n)), (inner, True)]
        if self.boundary_condition.translates:
            cases.insert(0, (start, Eq(joint, 0)))
        return Piecewise(*cases)
