"""A force on a point of a link that follows the motion of the point, by whatever law."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, NamedTuple

from sympy import Eq, Expr, IndexedBase, Piecewise, S

from rodgen.model.rod import Boundary

from ..chain import Vector, link_step
from ..generic_chain import GenericChain
from ..symbols import i, joint_vx, joint_vy, joint_x, joint_y, phi
from .kinds import Value
from .point_force import PointForce


class PointMotion(NamedTuple):
    """Motion of a point of a link, in symbols: its place, its velocity, the angle of the link."""

    place: Vector
    velocity: Vector
    angle: Expr


class PointLaw(PointForce):
    """A force on a point of a link, by its motion. The proofs of its work take its components as
    given, as arrays over the links."""

    by_velocity = True
    is_inside = True  # its arrays are of every joint, at the tail too
    _depends_on_link = True

    @abstractmethod
    def force_at(self, of: PointMotion) -> Vector:
        """The force [N] on a point that moves so."""

    @abstractmethod
    def force_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Any, ...]:
        """The force [N] on a point of a link (`supports.LinkMotion`), in the arithmetic of
        ``functions``."""

    @property
    def force_arrays(self) -> tuple[IndexedBase, ...]:
        x, y = (IndexedBase(f"{self.term}_pull_{axis}", real=True) for axis in "xy")
        return x, y

    def force(self, angle: Expr) -> Vector:
        x, y = (base[self.point.link] for base in self.force_arrays)
        return x, y

    def constants(self, first_joint: int, links: int) -> list[Expr]:
        return [base[link] for base in self.force_arrays for link in range(links)]

    def motion(self, link: Expr, at: Expr, way: Expr) -> PointMotion:
        """Motion of a point a share ``way`` of a link behind joint ``at``."""
        x, y, vx, vy = link_step(link, way, self.rod.length(link)) if way != 0 else (S.Zero,) * 4
        place = joint_x[at] + x, joint_y[at] + y
        velocity = joint_vx[at] + vx, joint_vy[at] + vy
        return PointMotion(place, velocity, phi[link])

    @property
    def own_motion(self) -> PointMotion:
        """Motion of its point."""
        return self.motion(self.point.link, self.point.link, self.point.share)

    def link_arrays(self, boundary: Boundary) -> dict[IndexedBase, Expr]:
        law = self.force_at(self.motion(i, i, self.point.share))
        here = Eq(i, self.point.link)
        return {
            base: Piecewise((f, here), (S.Zero, True))
            for base, f in zip(self.force_arrays, law, strict=True)
        }

    def joint_laws(
        self, at: Expr, before: Expr | None, after: Expr | None, chain: GenericChain
    ) -> dict[Expr, Expr]:
        law, point = [S.Zero, S.Zero], self.point
        if not self._moving_parts(chain.boundary_condition):
            return {}
        for part, (joint, _) in zip(self._shares, point.parts, strict=True):
            starts = joint == point.link
            if (after if starts else before) is None:
                continue
            there = (at, at, point.share) if starts else (at - 1, at, point.share - 1)
            force = self.force_at(self.motion(*there))
            law = [e + part[at] * f for e, f in zip(law, force, strict=True)]
        return {base[at]: e for base, e in zip(self.bases, law, strict=True)}
