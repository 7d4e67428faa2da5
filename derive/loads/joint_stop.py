"""Stop in a joint: it bends no further than to a gap."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sympy import Eq, Expr, IndexedBase, Piecewise, S

from ..closed_form import Num
from ..generic_chain import GenericChain
from ..symbols import omega, phi, s
from .contact import Contact, ContactState
from .joint_law import BendMotion, JointLaw
from .kinds import Value
from .point_force import PointLoad


class JointStop(Contact, JointLaw, PointLoad):
    """A moment across the joint where a link starts, by its bend beyond a gap to one side."""

    letter = "S_j"

    @property
    def _here(self) -> IndexedBase:
        """One for its joint, else zero."""
        return IndexedBase(f"{self.term}_here", real=True)

    def _seen(self, motion: BendMotion) -> tuple[Any, Any, Any]:
        """Side to which the joint bends towards the stop (1: left, -1: right), depth, its rate."""
        side = self.number("direction")
        return side, side * motion.bend - self.number("gap"), side * motion.rate

    def moment(self, motion: BendMotion) -> Expr:
        side, depth, rate = self._seen(motion)
        return -side * self.push(depth, rate)

    def spring_arrays(self, chain: GenericChain) -> dict[IndexedBase, Expr]:
        (base,), here = self.force_arrays, Eq(s, self.point.link)
        law = Piecewise((self._by_joint(self.moment, chain), here), (S.Zero, True))
        return {base: law, self._here: Piecewise((S.One, here), (S.Zero, True))}

    def spring_laws(
        self, at: Expr, chain: GenericChain, root: bool, tail: bool
    ) -> dict[Expr, Expr]:
        laws = super().spring_laws(at, chain, root, tail)
        return {moment: self._here[at] * law for moment, law in laws.items()}

    def _motion(self, chain: GenericChain) -> BendMotion:
        """Motion of its joint."""
        inner, root, _ = self.motions(chain)
        at = self.point.link
        return root if at == 0 else BendMotion(*(S(e).subs(s, at) for e in inner))

    def contact(self, chain: GenericChain) -> ContactState:
        _, depth, rate = self._seen(self._motion(chain))
        return ContactState(depth, self.push(depth, rate), self.opening(rate))

    @property
    def inputs(self) -> list[tuple[str, Expr]]:
        """Numbers that its push depends on, each with its link."""
        link = self.point.link
        links = [link] if link == 0 else [link - 1, link]
        return [(what, at) for what in ("phi", "omega") for at in links]

    def push_of(self, chain: GenericChain, seen: Sequence[Expr]) -> Expr:
        """Push by the numbers that it follows."""
        half, motion, at = len(seen) // 2, self._motion(chain), self.point.link
        known = dict(zip((phi[at], omega[at]), (seen[half - 1], seen[-1]), strict=True))
        if half == 2:
            known |= dict(zip((phi[at - 1], omega[at - 1]), (seen[0], seen[2]), strict=True))
        _, depth, rate = self._seen(motion)
        return self.push(depth, rate).xreplace(known)

    def power(self, chain: GenericChain) -> Expr:
        _, depth, rate = self._seen(self._motion(chain))
        return self.damping_power(depth, rate)

    def energy(self, chain: GenericChain) -> Expr:
        return self.stored_energy(self.contact(chain).depth)

    # By hand ------------------------------------------------------------------------------------

    def approach_by_hand(self, motion: BendMotion, value: Value, functions: Any) -> tuple[Any, ...]:
        """Bend to the left beyond the gap, or to the right."""
        if value(self.number("direction")) > 0:
            return motion.bend - value(self.number("gap")), motion.rate, 1
        return -value(self.number("gap")) - motion.bend, -motion.rate, 1

    def moment_by_hand(self, motion: BendMotion, value: Value, functions: Any) -> Num:
        push = self.state_by_hand(motion, value, functions)[1]
        return -push if value(self.number("direction")) > 0 else push


LOAD = JointStop()
