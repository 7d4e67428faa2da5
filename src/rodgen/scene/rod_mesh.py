"""Joints and links along a rod: where they are, and on which link a point lies."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.scene.expression import parse_expression
from rodgen.scene.expression_text import Numbers

FIELD = "rod.joints"
JOINED = Fraction(1, 10**9)  # of a link, within which a point is that of a joint
SHORTEST = 1e-9  # of the rod, a link: below, rounding of s is seen in its length
DENOMINATOR = 10**15  # largest, of the share of a link that is unlike the others
GAUSS = 5
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(GAUSS)
POINTS, WEIGHTS = (POINTS + 1) / 2, WEIGHTS / 2  # of an interval from 0 to 1


@dataclass(frozen=True)
class RodMesh:
    """Links of a rod, and where along it its joints are.

    links: their number; joints: s of every joint, links + 1 numbers from 0 at the start to 1 at the
    tail; () for equal links.
    """

    links: int
    joints: tuple[float, ...] = ()

    @classmethod
    def parse(cls, links: int, joints: Sequence[float] | str | None, numbers: Numbers) -> RodMesh:
        """Read the key `joints` of a rod: s of every joint, an expression in i and n, or None for
        equal links; numbers: values of the names in expressions. Raises InputError."""
        if joints is None:
            return cls(links)
        return _parse(links, joints if isinstance(joints, str) else tuple(joints), numbers)

    @classmethod
    def of_lengths(cls, lengths: Sequence[float]) -> RodMesh:
        """Mesh of links of these lengths [m]."""
        ends = np.cumsum([0.0, *lengths])
        return cls(len(lengths), tuple((ends / ends[-1]).tolist()))

    @property
    def is_even(self) -> bool:
        """Whether all links have the same length."""
        return not self.joints

    def at(self, places: ArrayLike) -> Array:
        """Places s of numbers from 0 at the start to `links` at the tail: of joints whole ones."""
        places = np.asarray(places, dtype=float)
        if self.is_even:
            return places / self.links
        found: Array = np.interp(places, np.arange(self.links + 1), self.joints)
        return found

    @property
    def places(self) -> Array:
        """Places s of the joints, (links + 1,)."""
        return self.at(np.arange(self.links + 1))

    @property
    def middles(self) -> Array:
        """Places s of the middles of the links, (links,)."""
        return self.at(np.arange(self.links) + 0.5)

    def lengths(self, length: float) -> Array:
        """Lengths of the links (links,) [m] of a rod of this length."""
        if self.is_even:
            return np.full(self.links, length / self.links)
        return length * np.diff(self.places)

    def lengths_at_joints(self, length: float) -> Array:
        """Lengths (links + 1,) [m] of a rod of this length that are gathered in the joints: half of
        each link that meets there."""
        halves = np.pad(np.repeat(self.lengths(length) / 2, 2), 1)
        found: Array = halves[::2] + halves[1::2]
        return found

    def gauss_points(self) -> Array:
        """Places s of the Gauss points of the links, (links, GAUSS)."""
        return self.at(np.arange(self.links)[:, None] + POINTS)

    def gauss_points_of_halves(self) -> Array:
        """Places s of the Gauss points of the halves of the links, (2 links, GAUSS)."""
        return self.at((np.arange(2 * self.links)[:, None] + POINTS) / 2)

    def link_and_share(self, s: float) -> tuple[int, float]:
        """The link on which s lies and the share of that before it: the link that begins at a
        joint, at the tail the last."""
        link, share = self._exact_link_and_share(s)
        return link, float(share)

    def place_text(self, s: float) -> str:
        """A point as a structure names it, 6+1/10; "" at the tail."""
        link, share = self._exact_link_and_share(s)
        if share == 1:
            return ""
        return f"{link}+{share}" if share else str(link)

    def _exact_link_and_share(self, s: float) -> tuple[int, Fraction]:
        at = Fraction(repr(float(s))) * self.links if self.is_even else self._exact_place(s)
        joint = round(at)
        at = Fraction(joint) if abs(at - joint) < JOINED else at
        link = min(int(at), self.links - 1)
        return link, at - link

    def _exact_place(self, s: float) -> Fraction:
        """Number of the link of s, and the share of that before it, as their sum."""
        link = min(max(bisect_right(self.joints, s) - 1, 0), self.links - 1)
        start, end, there = (Fraction(repr(x)) for x in (*self.joints[link : link + 2], float(s)))
        return link + ((there - start) / (end - start)).limit_denominator(DENOMINATOR)


def parse_place(text: str, links: int) -> tuple[int, float]:
    """Link and share of a point as a structure names it."""
    link, _, share = text.partition("+")
    return (int(link), float(Fraction(share or 0))) if text else (links - 1, 1.0)


def cell_means(values: Array) -> Array:
    """Means over cells from values at their Gauss points."""
    means: Array = values @ WEIGHTS
    return means


@lru_cache(maxsize=64)
def _parse(links: int, joints: tuple[float, ...] | str, numbers: Numbers) -> RodMesh:
    """Parse joints; scenes ask for them again and again."""
    given: object = joints if isinstance(joints, str) else [*joints]
    if isinstance(joints, str):
        for name, value in numbers:
            if name in ("i", "n"):
                allowed = f"another name: {FIELD} has i and n of its own"
                raise InputError(f"parameters.{name}", value, allowed)
        e = parse_expression(joints, "i", FIELD, (*numbers, ("n", float(links))))
        places = np.broadcast_to(np.asarray(e(np.arange(links + 1.0)), float), (links + 1,))
    else:
        places = np.array(joints, dtype=float)
        if len(places) != links + 1:
            allowed = f"a list of {links + 1} values, one for every joint"
            raise InputError(FIELD, given, allowed)
    ends = np.abs(places[[0, -1]] - (0.0, 1.0)).max()
    steps = np.diff(places)
    if not (ends <= SHORTEST and (steps >= SHORTEST).all()):
        off = np.flatnonzero(~(steps >= SHORTEST))
        where = f" (not so from joint {off[0]} to {off[0] + 1})" if len(off) else ""
        if ends > SHORTEST:
            where = f" (they go from {places[0]:.9g} to {places[-1]:.9g})"
        raise InputError(
            FIELD, given, f"s of every joint, from 0 to 1, each {SHORTEST:g} above the last{where}"
        )
    if np.abs(steps * links - 1).max() < float(JOINED):
        return RodMesh(links)
    return RodMesh(links, (0.0, *places[1:-1].tolist(), 1.0))
