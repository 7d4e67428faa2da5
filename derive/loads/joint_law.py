"""Moment across joints by how far they are bent and how fast, by whatever law."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, NamedTuple

from sympy import Eq, Expr, IndexedBase, Piecewise, S, Sum
from sympy.polys.rings import PolyElement

from ..closed_form import ClosedForm, Num, Pair
from ..explicit_chain import ExplicitChain
from ..generic_chain import AtSprings, GenericChain
from ..symbols import n, omega, phi, s
from .kinds import Load, Value


class BendMotion(NamedTuple):
    """Motion of a joint with a spring: its number, the angle by which it is bent [rad] and the rate
    of that [rad/s], and the length of the rod that bends there [m]."""

    at: Any
    bend: Any
    rate: Any
    length: Any


class JointLaw(Load):
    """A moment across every joint with a spring, by its bend and its rate."""

    across_joints = True

    @abstractmethod
    def moment(self, motion: BendMotion) -> Expr:
        """Moment on the link after a joint [N m]; the link before it, or the clamp, gets the
        opposite."""

    @abstractmethod
    def moment_by_hand(self, motion: BendMotion, value: Value, functions: Any) -> Num:
        """The moment, in the arithmetic of ``functions``."""

    @property
    def force_arrays(self) -> tuple[IndexedBase, ...]:
        return (IndexedBase(f"{self.term}_couple", real=True),)

    @property
    def angles(self) -> tuple[Any, ...]:
        return ()

    def constants(self, first_joint: int, links: int) -> list[Expr]:
        return [base[at] for base in self.force_arrays for at in range(links + 1)]

    def explicit_forces(self, chain: ExplicitChain) -> list[list[PolyElement]]:
        (base,), rows = self.force_arrays, []
        numbers = chain.boundary_condition.spring_joints(chain.n)
        for at, (_, before, after) in zip(numbers, chain.springs, strict=True):
            moment = chain.calculus.generator[base[at]]
            opening = chain.calculus.poly(after - before)
            rows.append([moment * chain.calculus.diff(opening, q) for q in chain.coordinates])
        return rows

    def moments(self, chain: GenericChain) -> AtSprings:
        (base,), boundary = self.force_arrays, chain.boundary_condition
        ends = base[0] if boundary.root else S.Zero, base[n] if boundary.tail else S.Zero
        return AtSprings(base[s], *ends)

    def motions(self, chain: GenericChain) -> tuple[BendMotion, BendMotion, BendMotion]:
        """Motions of the joint s between two links, of the root and of the tail."""
        bends = chain.at_springs(lambda before, after, of: of.bend(before, after), phi)
        rates = chain.at_springs(lambda before, after, of: after - before, omega)
        lengths = chain.at_springs(lambda before, after, of: of.length, phi)
        inner, root, tail = zip(bends, rates, lengths, strict=True)
        return BendMotion(s, *inner), BendMotion(S.Zero, *root), BendMotion(n, *tail)

    def _by_joint(self, of: Any, chain: GenericChain) -> Expr:
        """A function of the motion of the joint s, which differs at a root and a tail that have a
        spring."""
        (inner, root, tail), boundary = self.motions(chain), chain.boundary_condition
        cases = [(of(root), Eq(s, 0))] if boundary.root else []
        cases += [(of(tail), Eq(s, n))] if boundary.tail else []
        return Piecewise(*cases, (of(inner), True))

    def spring_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        (base,) = self.force_arrays
        return {base: self._by_joint(self.moment, chain)}

    def spring_laws(
        self, at: Expr, chain: GenericChain, root: bool, tail: bool
    ) -> dict[Expr, Expr]:
        (base,), (inner, first, last) = self.force_arrays, self.motions(chain)
        if root:
            law = self.moment(first).xreplace({phi[0]: phi[at], omega[0]: omega[at]})
        elif tail:
            law = self.moment(last).subs(n, at)
        else:
            law = self.moment(inner).subs(s, at)
        return {base[at]: law}

    def power(self, chain: GenericChain) -> Expr:
        (inner, root, tail), boundary = self.motions(chain), chain.boundary_condition
        total = Sum(self.lost(inner), (s, 1, n - 1))
        total += self.lost(root) if boundary.root else S.Zero
        return total + (self.lost(tail) if boundary.tail else S.Zero)

    def lost(self, motion: BendMotion) -> Expr:
        """Power in a joint that is not that of a spring [W]."""
        return self.moment(motion) * motion.rate

    def lost_by_hand(self, motion: BendMotion, value: Value, functions: Any) -> Num:
        """Power in a joint by hand, in the arithmetic of ``functions``."""
        return self.moment_by_hand(motion, value, functions) * motion.rate

    # By hand ------------------------------------------------------------------------------------

    def base_by_hand(self, rod: ClosedForm, value: Value) -> Pair:
        return 0 * rod.l, 0 * rod.l

    def link_by_hand(self, rod: ClosedForm, i: Num, value: Value) -> Num:
        return self.ends_by_hand(i, rod.joint_sizes(i), value)

    def ends_by_hand(self, i: Num, sizes: tuple[int, int], value: Value) -> Num:
        """Moment of the joints at both ends of a link on it; sizes: zero for no spring."""
        moment = value(self.force_arrays[0])
        start, end = (moment[at] if size else 0 for at, size in zip((i, i + 1), sizes, strict=True))
        return start - end
