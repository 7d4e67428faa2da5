"""Mass of the links and stiffness of the joints of a rod, uniform or differing along it.

Of the mass along a link only means over the fraction xi in [0, 1] enter the equations, so a
distribution is its moments <1>, <xi>, <xi^2>.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache

from sympy import Expr, Poly, S, integrate, sympify

from rodgen.model import rod as rows
from rodgen.model.term import LINKS

from .symbols import HALF, PARAMETERS, eta, k, l, m, xi

joint_stiffness, link_mass = PARAMETERS["joint_stiffness"], PARAMETERS["link_mass"]
link_length, bent_length = PARAMETERS["link_length"], PARAMETERS["bent_length"]
rest_angle = PARAMETERS["rest_angle"]
centre = tuple(PARAMETERS[row.name] for row in rows.CENTRE)
spread = tuple(PARAMETERS[row.name] for row in rows.SPREAD)

INERTIAS: dict[str, Callable[[Expr], Expr]] = {
    # spread evenly: <f> is the integral of f, which gives m l^2/12 about the centre
    "uniform": lambda f: integrate(f, (xi, 0, 1)),
    # half of it at each end of a massless link, so that m gathers at every inner joint
    "lumped": lambda f: (f.subs(xi, 0) + f.subs(xi, 1)) / 2,
}


def mass_mean(inertia: str, expression: Expr) -> Expr:
    """Mean of a polynomial in xi over the mass of one link."""
    powers = Poly(expression, xi).all_coeffs()[::-1]
    weigh = INERTIAS[inertia]
    return sum((c * _moment(weigh, power) for power, c in enumerate(powers)), start=S.Zero)


@cache
def _moment(weigh: Callable[[Expr], Expr], power: int) -> Expr:
    """<xi**power>: SymPy takes as long for it as for the rest of an entry."""
    return weigh(xi**power)


def link_parameters(nonuniform: Iterable[str]) -> list[str]:
    """Names of the parameters with a number for every link."""
    ways = (rows.NONUNIFORM[what].parameters for what in nonuniform)
    return [one.name for way in ways for one in way if one.each == LINKS]


@dataclass(frozen=True)
class Joint:
    """Spring in a joint, zero where there is none: its size, in springs between links of an even
    rod, its stiffness [N m/rad], the angle between the links in which it is at rest [rad], and the
    length of the rod that bends there [m]."""

    size: Expr
    stiffness: Expr
    rest: Expr
    length: Expr

    def bend(self, before: Expr, after: Expr) -> Expr:
        """Angle by which the spring is bent between links at these angles [rad]."""
        return after - before - self.rest


@dataclass(frozen=True)
class Rod:
    """Distribution of mass and stiffness. inertia: how the mass of a link lies along it;
    nonuniform: what differs along the rod, of model.rod.NONUNIFORM."""

    inertia: str = "uniform"
    nonuniform: tuple[str, ...] = ()

    def stiffness(self, at: Expr | int, size: int = 1) -> Expr:
        """Stiffness of the spring in a joint [N m/rad], zero where there is none; size: of an even
        rod, in springs between links."""
        if "stiffness" in self.nonuniform:
            return joint_stiffness[at] if size else S.Zero
        return sympify(size) * k

    def joint(self, at: Expr | int, size: int = 1) -> Joint:
        """The spring in a joint."""
        rests = size and "rest" in self.nonuniform
        rest = rest_angle[at] if rests else S.Zero
        return Joint(sympify(size), self.stiffness(at, size), rest, self._bent_length(at, size))

    def _bent_length(self, at: Expr | int, size: int) -> Expr:
        """Length of the rod that bends in a joint [m], of an even one half a link to each side."""
        if not size:
            return S.Infinity  # where nothing bends
        return l / size if {"lengths", "ends"}.isdisjoint(self.nonuniform) else bent_length[at]

    def length(self, link: Expr | int) -> Expr:
        """Length of a link [m]."""
        return link_length[link] if self.has_link_lengths else l

    def length_at(self, at: Expr | int, inside: bool = True) -> Expr:
        """Length of the rod that is gathered in a joint [m]: half of each link that meets there."""
        if not self.has_link_lengths:
            return l if inside else l / 2
        ends = [at - 1, at] if inside else [at if at == 0 else at - 1]
        return sum((HALF * self.length(link) for link in ends), S.Zero)

    def share_after(self, at: Expr | int) -> Expr:
        """Share of the rod gathered in an inner joint that is of the link which begins there."""
        if not self.has_link_lengths:
            return HALF
        return self.length(at) / (self.length(at - 1) + self.length(at))

    def mean_angle(self, before: Expr | None, after: Expr | None, at: Expr | int) -> Expr:
        """Angle of the rod at a joint [rad]: mean of those of the links that meet there, by their
        lengths; None for no link."""
        if before is None or after is None:
            return after if before is None else before
        if not self.has_link_lengths:
            return (before + after) / 2
        ends = self.length(at - 1), self.length(at)
        return (ends[0] * before + ends[1] * after) / (ends[0] + ends[1])

    @property
    def has_link_lengths(self) -> bool:
        """Whether links differ in their length."""
        return "lengths" in self.nonuniform

    @property
    def has_link_masses(self) -> bool:
        """Whether links differ in their mass."""
        return not rows.MASS_WAYS.isdisjoint(self.nonuniform)

    @property
    def has_offset_mass(self) -> bool:
        """Whether there is mass beside the links."""
        return "bodies" in self.nonuniform

    def mass(self, link: Expr | int) -> Expr:
        """Mass of a link with all that is fixed to it [kg]."""
        return link_mass[link] if self.has_link_masses else m

    def mean(self, expression: Expr, link: Expr | int) -> Expr:
        """Mean over the mass of a link of a polynomial in xi and, beside it, eta."""
        if not {"bodies", "points"} & {*self.nonuniform}:
            return mass_mean(self.inertia, expression)
        terms = Poly(expression, xi, eta).terms()
        return sum((c * self.mass_moment(a, b, link) for (a, b), c in terms), start=S.Zero)

    def mass_moment(self, along: int, beside: int, link: Expr | int) -> Expr:
        """Mean of xi**along eta**beside over the mass of a link with its bodies."""
        a, b = (base[link] for base in centre)
        if "points" in self.nonuniform:  # all mass stands at xi = 0 or 1
            return S.Zero if beside else a if along else S.One
        s_aa, s_bb, s_ab = (base[link] for base in spread)
        known = {(0, 0): S.One, (1, 0): a, (0, 1): b}
        known |= {(2, 0): a**2 + s_aa, (0, 2): b**2 + s_bb, (1, 1): a * b + s_ab}
        return known[along, beside]
