"""A force on every link, which may turn with it and differ from link to link."""

from __future__ import annotations

from abc import abstractmethod

from sympy import Expr, IndexedBase, Sum, expand
from sympy.polys.rings import PolyElement

from rodgen.model.rod import Boundary

from ..chain import Vector
from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import GenericChain
from ..symbols import HALF, i, joint, n, other, phi
from .kinds import JointForces, Value, Work


class LinkForce(JointForces):
    """A force on every link at the fraction ``share`` of it. On the joints at both ends of a rigid
    link its parts do what the whole does there."""

    share: Expr = HALF

    @abstractmethod
    def force(self, angle: Expr, link: Expr) -> Vector:
        """The force on a link [N], where that has this angle."""

    def rows(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        poly, rows = chain.calculus.poly, []
        for link, angle in enumerate(chain.angles):
            fx, fy = map(poly, self.force(angle, link))
            rows.append(chain.virtual_work(chain.point(link, self.share), (fx, fy)))
        return rows

    def work(self, chain: GenericChain) -> Work:
        def behind(low: Expr) -> Vector:
            x, y = (Sum(f, (other, low, n - 1)) for f in self.force(phi[other], other))
            return x, y

        own = expand(chain.lean(self.force(phi[i], i)))
        lean = chain.lean(behind(i + 1)) + self.share * own
        return Work(behind(chain.hold.first), chain.reach * lean)

    def _law(self, at: Expr, before: Expr | None, after: Expr | None) -> Vector:
        """The force on a joint where links of these angles meet; None where there is none."""
        ends = [(self.share, before, at - 1), (1 - self.share, after, at)]
        parts = [
            [share * f for f in self.force(angle, link)]
            for share, angle, link in ends
            if angle is not None
        ]
        x, y = map(sum, zip(*parts, strict=True))
        return x, y

    def on_start(self, link: Expr, hold: Boundary) -> Vector:
        x, y = ((1 - self.share) * f for f in self.force(phi[link], link))
        return x, y

    def arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        start = self._law(joint, None, phi[joint])
        end = self._law(joint, phi[joint - 1], None)
        cases = zip(start, end, self._law(joint, phi[joint - 1], phi[joint]), strict=True)
        return {b: chain.at_ends(*case) for b, case in zip(self.bases, cases, strict=True)}

    def near(
        self, at: Expr, before: Expr | None, after: Expr | None, chain: GenericChain
    ) -> dict[Expr, Expr]:
        law = self._law(at, before, after)
        return {base[at]: f for base, f in zip(self.bases, law, strict=True)}

    def force_by_hand(self, rod: ClosedForm, link: Num, value: Value) -> Pair:
        """The force on a link."""
        x, y = map(value, self.force(phi[link], link))
        return x, y

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        return self._behind(rod, rod.hold.first, value)

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        own = rod.turning(i, self.force_by_hand(rod, i, value))
        behind = rod.turning(i, self._behind(rod, i + 1, value))
        return behind + value(self.share) * own

    def _behind(self, rod: ClosedForm, low: Num, value: Value) -> Pair:
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
