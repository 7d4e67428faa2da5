"""Masses that change with time: present parameters of the links, power of the leaving mass.

Mass that leaves a link has the velocity of its place. It takes no momentum from what stays, so the
equations keep their form, with the masses of the present. It takes its energy along: that of the
rod is linear in its masses, so its loss is the energy of the mass that leaves in a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from sympy import Add, Eq, Expr, IndexedBase, Piecewise, Rational, S, Sum, Symbol

from .energies import Quantities
from .general import GeneralEquations
from .link_properties import centre, link_mass, spread
from .symbols import HALF, PARAMETERS, i

# Of every link, without bodies: its mass and what it gains in a second.
own_mass, own_rate = (IndexedBase(name, real=True) for name in ("own_mass", "own_mass_rate"))


@dataclass(frozen=True)
class ChangingBody:
    """A body whose mass changes with time, by the names of its numbers, and its link."""

    name: str
    link: int

    def number(self, what: str) -> Symbol:
        """Symbol of one of its numbers: mass, mass_rate, along, across or spread (of its inertia,
        as a mass at a mean square of one)."""
        return Symbol(f"{self.name}_{what}", real=True)


# Mass, centre along and across, and the mean squares along and across and the mean product about
# that, times the mass.
Part = tuple[Expr, Expr, Expr, Expr, Expr, Expr]


@dataclass(frozen=True)
class VariableMasses:
    """Masses of a rod, some of which change with time. own: whether those of the links do; bodies:
    the bodies that do; potentials: loads that have a potential, which leaving mass takes along."""

    equations: GeneralEquations
    own: bool
    bodies: Sequence[ChangingBody]
    potentials: tuple[str, ...]

    @property
    def _has_bodies(self) -> bool:
        """Whether bodies or point masses are fixed to the links."""
        return not {"bodies", "points"}.isdisjoint(self.equations.nonuniform)

    @cached_property
    def masses(self) -> dict[IndexedBase, Expr]:
        """Present mass parameters of link i, by their arrays."""
        if not self._has_bodies:
            return {link_mass: own_mass[i]}
        always = [self._steady_part, *([self._link_part] if self.own else [])]
        cases = [(at, [t for t in self.bodies if t.link == at]) for at in self._links]
        found = {}
        for place, base in enumerate((link_mass, *centre, *spread)):
            with_bodies = [
                (self._combine(place, [*always, *map(self._body_part, bodies)]), Eq(i, at))
                for at, bodies in cases
            ]
            whole = self._combine(place, always)
            found[base] = Piecewise(*with_bodies, (whole, True)) if with_bodies else whole
        if "points" in self.equations.nonuniform:
            found = {base: found[base] for base in (link_mass, centre[0])}
        return found

    @property
    def _links(self) -> list[int]:
        return sorted({body.link for body in self.bodies})

    @property
    def _steady_part(self) -> Part:
        """Mass properties of the masses on link i that do not change."""
        names = ("mass", "centre_along", "centre_across", *(f"spread_{way}" for way in SPREADS))
        if "points" in self.equations.nonuniform:
            mass, along = (PARAMETERS[f"steady_{name}"][i] for name in names[:2])
            return mass, along, S.Zero, S.Zero, S.Zero, S.Zero
        mass, a, b, *squares = (PARAMETERS[f"steady_{name}"][i] for name in names)
        return mass, a, b, *(mass * square for square in squares)

    @property
    def _link_part(self) -> Part:
        """Mass properties of link i itself."""
        own = own_mass[i]
        return own, HALF, S.Zero, own * Rational(1, 12), S.Zero, S.Zero

    def _body_part(self, body: ChangingBody) -> Part:
        spread = body.number("spread")
        mass, a, b = map(body.number, ("mass", "along", "across"))
        return mass, a, b, spread, spread, S.Zero

    def _combine(self, place: int, parts: Sequence[Part]) -> Expr:
        """Mass parameter number ``place`` of a link with these parts (Steiner)."""
        if place == 0:
            return Add(*(part[0] for part in parts))
        mass = link_mass[i]
        if place < 3:
            return Add(*(part[0] * part[place] for part in parts)) / mass
        one, two = ((1, 1), (2, 2), (1, 2))[place - 3]
        about = [base[i] for base in centre]
        ways = [
            part[place] + part[0] * (part[one] - about[one - 1]) * (part[two] - about[two - 1])
            for part in parts
        ]
        return Add(*ways) / mass

    @cached_property
    def power(self) -> Expr:
        """Power [W] that the rod gains by the change of its masses."""
        quantities = Quantities(self.equations, self.potentials)
        energies = Add.make_args(quantities.kinetic_energy + quantities.weight_energy)
        total = S.Zero
        for energy in energies:
            (_, low, high), of = energy.limits[0], energy.function
            if self.own:
                total += Sum(
                    _with_mass(of, own_rate[i], HALF, S.Zero, Rational(1, 12)), (i, low, high)
                )
            for body in self.bodies:
                if body.link >= low:
                    mass, a, b = map(body.number, ("mass_rate", "along", "across"))
                    total += _with_mass(of, mass, a, b, S.Zero).subs(i, body.link)
        return total


SPREADS = ("along", "across", "mixed")


def _with_mass(of: Expr, mass: Expr, along: Expr, across: Expr, square: Expr) -> Expr:
    """Expression for link i with another mass, at another place."""
    values = (mass, along, across, square, S.Zero, S.Zero)
    bases = (link_mass, *centre, *spread)
    return of.xreplace({base[i]: value for base, value in zip(bases, values, strict=True)})
