"""A force on every link, which may turn with it and differ from link to link."""

from __future__ import annotations

from abc import abstractmethod

from sympy import Expr, IndexedBase, Sum, expand, trigsimp
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import GenericChain
from ..symbols import HALF, i, joint, n, other, phi
from .kinds import GeneralisedForces, JointLoad, Value


class LinkForce(JointLoad):
    """A force on every link at the fraction ``share`` of it. On the joints at both ends of a rigid
    link its parts have the same effect as the whole."""

    share: Expr = HALF

    @abstractmethod
    def force(self, angle: Expr, link: Expr) -> Vector:
        """The force on a link [N], where that has this angle."""

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        poly, rows = chain.calculus.poly, []
        for link, angle in enumerate(chain.angles):
            fx, fy = map(poly, self.force(angle, link))
            rows.append(chain.virtual_work(chain.point(link, self.share), (fx, fy)))
        return rows

    def generalised_forces(self, chain: GenericChain) -> GeneralisedForces:
        def force_from(low: Expr) -> Vector:
            x, y = (Sum(f, (other, low, n - 1)) for f in self.force(phi[other], other))
            return x, y

        own = trigsimp(expand(chain.angle_force(self.force(phi[i], i))))
        lean = chain.angle_force(force_from(i + 1)) + self.share * own
        return GeneralisedForces(
            force_from(chain.boundary_condition.first_in_motion), chain.joint_lever * lean
        )

    def _force_at_joint(self, at: Expr, before: Expr | None, after: Expr | None) -> Vector:
        """Force on a joint where links of these angles meet; None stands for no link."""
        ends = [(self.share, before, at - 1), (1 - self.share, after, at)]
        parts = [
            [share * f for f in self.force(angle, link)]
            for share, angle, link in ends
            if angle is not None
        ]
        x, y = map(sum, zip(*parts, strict=True))
        return x, y

    def start_force(self, link: Expr, boundary: Boundary) -> Vector:
        x, y = ((1 - self.share) * f for f in self.force(phi[link], link))
        return x, y

    def joint_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        start = self._force_at_joint(joint, None, phi[joint])
        end = self._force_at_joint(joint, phi[joint - 1], None)
        cases = zip(
            start, end, self._force_at_joint(joint, phi[joint - 1], phi[joint]), strict=True
        )
        return {
            b: chain.piecewise_at_ends(*case) for b, case in zip(self.bases, cases, strict=True)
        }

    def joint_laws(
        self, at: Expr, before: Expr | None, after: Expr | None, chain: GenericChain
    ) -> dict[Expr, Expr]:
        law = self._force_at_joint(at, before, after)
        return {base[at]: f for base, f in zip(self.bases, law, strict=True)}

    def force_by_hand(self, rod: ClosedForm, link: Num, value: Value) -> Pair:
        """The force on a link."""
        x, y = map(value, self.force(phi[link], link))
        return x, y

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        return self._force_from(rod, rod.boundary.first_in_motion, value)

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        own = rod.force_moment(i, self.force_by_hand(rod, i, value))
        behind = rod.force_moment(i, self._force_from(rod, i + 1, value))
        return behind + value(self.share) * own

    def _force_from(self, rod: ClosedForm, low: Num, value: Value) -> Pair:
        """Sum of the forces on a link and on all after it."""

        def total(axis: int) -> Num:
            return rod.arithmetic.total(
                lambda q: self.force_by_hand(rod, q, value)[axis], low, rod.n - 1
            )

        return total(0), total(1)

    def joints_by_hand(self, rod: ClosedForm, value: Value) -> list[Pair]:
        """The forces on all joints: of every link its parts on both ends."""
        share, found = value(self.share), [(0 * rod.l, 0 * rod.l)] * (rod.n + 1)
        for q in range(rod.n):
            x, y = self.force_by_hand(rod, q, value)
            for at, part in ((q, 1 - share), (q + 1, share)):
                found[at] = found[at][0] + part * x, found[at][1] + part * y
        return found
