"""A moment on the link of a point."""

from __future__ import annotations

from abc import abstractmethod

from sympy import Eq, Expr, IndexedBase, Piecewise, S
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary

from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import GenericChain
from ..symbols import i, n, omega, phi
from .kinds import NOTHING, GeneralisedForces, Value
from .point_force import PointLoad


class PointMoment(PointLoad):
    """A moment on the link of a point, which depends on nothing else: the same anywhere on it."""

    is_of_one_link = True

    @property
    @abstractmethod
    def moment(self) -> Expr:
        """The moment [N m], positive to the left."""

    @property
    def _here(self) -> IndexedBase:
        """One for the link of the point, else zero."""
        return IndexedBase(f"{self.term}_here", real=True)

    def _acts(self, boundary: Boundary) -> bool:
        """Whether its link moves."""
        link = self.point.link
        return not (link.is_Integer and link < boundary.first_in_motion)

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        poly, diff = chain.calculus.poly, chain.calculus.diff
        angle = poly(chain.angles[int(self.point.link.subs(n, chain.n))])
        return [[poly(self.moment) * diff(angle, q) for q in chain.coordinates]]

    def generalised_forces(self, chain: GenericChain) -> GeneralisedForces:
        link = self.point.link
        here = Piecewise((S.Zero, i < link), (S.One, i <= link), (S.Zero, True))
        return GeneralisedForces(NOTHING, self.moment * here)

    def link_moment(self, link: Expr, boundary: Boundary) -> Expr:
        return self.moment * self._here[link] if self._acts(boundary) else S.Zero

    def link_arrays(self, boundary: Boundary) -> dict[IndexedBase, Expr]:
        if not self._acts(boundary):
            return {}
        return {self._here: Piecewise((S.One, Eq(i, self.point.link)), (S.Zero, True))}

    def power(self, chain: GenericChain) -> Expr:
        acts = self._acts(chain.boundary_condition)
        return self.moment * omega[self.point.link] if acts else S.Zero

    def potential(self, chain: GenericChain) -> Expr:
        acts = self._acts(chain.boundary_condition)
        return -self.moment * phi[self.point.link] if acts else S.Zero

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        return 0 * value(self.moment), 0 * value(self.moment)

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        """M on the link of the point, on others nothing."""
        acts = i == self.point.link.subs(n, rod.n)
        return value(self.moment) if acts else 0 * value(self.moment)

    def potential_by_hand(self, rod: ClosedForm, value: Value) -> Num:
        """-M phi of the link, of one that is held nothing."""
        link = int(self.point.link.subs(n, rod.n))
        moves = int(link >= rod.boundary.first_in_motion)
        return -moves * value(self.moment) * rod.phi[link]
