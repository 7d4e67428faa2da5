"""A chain of any number of links: sums of levers over its mass, virtual work of forces."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import prod

from sympy import Eq, Expr, Piecewise, S, Sum, expand, factor_terms, summation

from rodgen.model.rod import BOUNDARIES, Boundary

from .chain import AFTER, BEFORE, OWN, Vector, lever, side
from .mass_point import MassPoint, mass_point
from .rod import Rod
from .symbols import eta, i, joint, n, other, phi, xi


class GenericChain:
    """A chain with n links for every n, before its loads and its equations.

    boundary, inertia, uneven: as in `Equations`, which has them.
    """

    boundary: str
    inertia: str
    uneven: tuple[str, ...]

    @property
    def rod(self) -> Rod:
        """How mass and stiffness lie along the rod."""
        return Rod(self.inertia, self.uneven)

    @cached_property
    def hold(self) -> Boundary:
        """How the start of the rod is held."""
        return BOUNDARIES[self.boundary]

    @cached_property
    def _generic(self) -> MassPoint:
        return mass_point(self.rod.sided)

    def lever_mass(
        self, links: Sequence[Expr], powers: Sequence[int], sides: Sequence[int] = ()
    ) -> Expr:
        """Sum over the mass of all links of the product of levers**powers, along the links, and
        of those across them**sides; links ascend."""
        sides = sides or [0] * len(links)

        def moment(places: Sequence[str], link: Expr) -> Expr:
            levers = [lever(p, xi) ** power for p, power in zip(places, powers, strict=True)]
            levers += [side(p, eta) ** power for p, power in zip(places, sides, strict=True)]
            return self.rod.mass(link) * self.rod.mean(prod(levers, start=S.One), link)

        total = S.Zero
        for at in range(len(links) + 1):
            passed, ahead = [BEFORE] * at, [AFTER] * (len(links) - at)
            low = links[at - 1] + 1 if at else S.Zero
            high = links[at] - 1 if at < len(links) else n - 1
            total += self._over_links(moment([*passed, *ahead], other), low, high)
            if ahead:
                total += moment([*passed, OWN, *ahead[1:]], links[at])
        return factor_terms(expand(total))

    def _over_links(self, moment: Expr, low: Expr, high: Expr) -> Expr:
        """Sum over links that all have a moment, but for their mass."""
        if not self.rod.heavy:
            return summation(moment, (other, low, high))
        mass = self.rod.mass(other)
        return moment / mass * Sum(mass, (other, low, high)) if moment != 0 else S.Zero

    def lean(self, force: Vector) -> Expr:
        """Virtual work of a force on the angle of link i, for a lever of one."""
        generic = mass_point()
        (a_i, _), (dx, dy) = generic.a, generic.partial[0]
        work = (dx * force[0] + dy * force[1]).subs(a_i, 1)
        return work.xreplace({generic.angles[0]: phi[i]})

    def lean_of_mass(self, force: Vector) -> Expr:
        """Virtual work of a force on every unit of mass on the angle of link i."""
        work = self.lever_mass([i], [1]) * self.lean(force)
        if self.rod.sided:  # what is moved by a lever across is moved along the link, backwards
            work += self.lever_mass([i], [0], [1]) * self.lean((force[1], -force[0]))
        return work

    @cached_property
    def reach(self) -> Expr:
        """Lever of link i at the joint that ends it and at every joint behind: one and the same."""
        own, beyond = (lever(place, S.One) for place in (OWN, BEFORE))
        if own != beyond:
            raise ArithmeticError(f"levers {own} and {beyond} at the joints behind a link differ")
        return own

    def at_ends(self, start: Expr, end: Expr, inner: Expr) -> Expr:
        """What has other values at the ends of the rod, for a joint that moves."""
        cases = [(end, Eq(joint, n)), (inner, True)]
        if self.hold.translates:
            cases.insert(0, (start, Eq(joint, 0)))
        return Piecewise(*cases)
