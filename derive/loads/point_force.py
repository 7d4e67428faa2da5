"""A force on a point of a link: as forces on the joints at both ends of the link, for any n."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

from sympy import Eq, Expr, IndexedBase, Integer, Piecewise, Rational, S
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import GenericChain
from ..symbols import i, joint, joint_vx, joint_vy, n, phi
from .kinds import NOTHING, AppliedForces, GeneralisedForces, Load, Value


@dataclass(frozen=True)
class LinkPoint:
    """The point at the fraction ``share`` of a link; links are counted from either end."""

    link: Expr
    share: Expr = S.One

    @property
    def parts(self) -> list[tuple[Expr, Expr]]:
        """Joints that take a force at the point, each with its share: on a rigid link those two
        forces have the same effect as the one."""
        ends = ((self.link, 1 - self.share), (self.link + 1, self.share))
        return [(at, share) for at, share in ends if share != 0]

    @classmethod
    def parse(cls, place: str) -> LinkPoint:
        """Point of a place: a link by its number, and the share before it, as in 6+1/10; the tail,
        if it is empty. Keys of optional parameters may follow."""
        parts = (part for part in place.split("+") if not part[:1].isalpha())
        link, share = next(parts, ""), next(parts, "0")
        return cls(Integer(link), Rational(share)) if link else TAIL


TAIL = LinkPoint(n - 1)


class PointLoad(Load):
    """A load on a point of a link."""

    point = TAIL

    def at_place(self, name: str, place: str) -> Self:
        found = super().at_place(name, place)
        found.point = LinkPoint.parse(place)
        return found

    @property
    def is_of_one_link(self) -> bool:
        """Whether its generalised forces on the links next to its point follow other laws."""
        return self.is_inside

    @property
    def is_inside(self) -> bool:
        """Whether it acts elsewhere than on the tail alone."""
        return self.point != TAIL


class PointForce(PointLoad):
    """A force on a point of a link. A dead one does not depend on the angle of the link."""

    @abstractmethod
    def force(self, angle: Expr) -> Vector:
        """The force [N], where its link has this angle."""

    @property
    def _force(self) -> Vector:
        return self.force(phi[self.point.link])

    @property
    def _depends_on_link(self) -> bool:
        """Whether its law has the angle of its link."""
        return any(f.has(phi) for f in self._force)

    def _moving_parts(self, boundary: Boundary) -> list[tuple[Expr, Expr]]:
        """Parts of the force on joints that are not held."""
        low = boundary.first_joint
        return [(at, x) for at, x in self.point.parts if not (at.is_Integer and at < low)]

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        link = int(self.point.link.subs(n, chain.n))
        force = (f.subs(n, chain.n) for f in self.force(chain.angles[link]))
        fx, fy = map(chain.calculus.poly, force)
        return [chain.virtual_work(chain.point(link, self.point.share), (fx, fy))]

    def generalised_forces(self, chain: GenericChain) -> GeneralisedForces:
        lean = chain.joint_lever * chain.angle_force(self._force)
        if not self.is_inside:
            return GeneralisedForces(self._force, lean)
        link, share = self.point.link, self.point.share
        passed = (S.One, i <= link) if share == 1 else (S.One, i < link)
        arm = Piecewise(passed, (share, i <= link), (S.Zero, True))
        return GeneralisedForces(self._force, arm * lean)

    def joint_force(self, at: Expr, boundary: Boundary) -> Vector:
        if not self.is_inside or not self._moving_parts(boundary):
            return NOTHING
        x, y = (b[at] if f != 0 else S.Zero for b, f in zip(self.bases, self._force, strict=True))
        return x, y

    def start_force(self, link: Expr, boundary: Boundary) -> Vector:
        if self.point.share == 1:
            return NOTHING
        x, y = ((1 - self.point.share) * f for f in self._force)
        here = Eq(link, self.point.link)
        return Piecewise((x, here), (S.Zero, True)), Piecewise((y, here), (S.Zero, True))

    def tail_force(self) -> Vector:
        return NOTHING if self.is_inside else self._force

    def joint_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        parts = self._moving_parts(chain.boundary_condition) if self.is_inside else []

        def distribute(value: Expr) -> Expr:
            return Piecewise(
                *((share * value, Eq(joint, at)) for at, share in parts), (S.Zero, True)
            )

        if not parts:
            return {}
        arrays = {b: distribute(f) for b, f in zip(self.bases, self._force, strict=True) if f != 0}
        if self._depends_on_link:
            for base, (at, share) in zip(self._shares, self.point.parts, strict=True):
                arrays[base] = Piecewise((share, Eq(joint, at)), (S.Zero, True))
        return arrays

    @property
    def _shares(self) -> list[IndexedBase]:
        """Shares of the force on joints as arrays, by the link that ends or begins there."""
        return [
            IndexedBase(f"{self.term}_{'start' if at == self.point.link else 'end'}", real=True)
            for at, _ in self.point.parts
        ]

    def joint_laws(
        self, at: Expr, before: Expr | None, after: Expr | None, chain: GenericChain
    ) -> dict[Expr, Expr]:
        if not (
            self.is_inside
            and self._depends_on_link
            and self._moving_parts(chain.boundary_condition)
        ):
            return {}
        law = [S.Zero, S.Zero]
        for share, (joint_, _) in zip(self._shares, self.point.parts, strict=True):
            angle = after if joint_ == self.point.link else before
            if angle is not None:
                law = [e + share[at] * f for e, f in zip(law, self.force(angle), strict=True)]
        return {base[at]: e for base, e in zip(self.bases, law, strict=True)}

    def applied_forces(self, boundary: Boundary) -> AppliedForces:
        (low, first), (high, second) = self.point.parts[0], self.point.parts[-1]
        if low == high:
            return AppliedForces(low, low, self._force)
        x, y = (Piecewise((first * f, Eq(joint, low)), (second * f, True)) for f in self._force)
        return AppliedForces(low, high, (x, y))

    def power(self, chain: GenericChain) -> Expr:
        parts, (fx, fy) = self._moving_parts(chain.boundary_condition), self._force
        return sum((x * (fx * joint_vx[at] + fy * joint_vy[at]) for at, x in parts), start=S.Zero)

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        x, y = map(value, self._force)
        return x, y

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        turning = rod.force_moment(i, self.base_by_hand(rod, value))
        if not self.is_inside:
            return turning
        return rod.lever_share(i, self.point.link.subs(n, rod.n), value(self.point.share)) * turning
