"""Law of a contact, which pushes and never pulls: a spring with a damper that grows with its depth.

    F = k d^e max(0, 1 + c d')   while d > 0,

d the depth by which it is pressed, d' its rate (K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42
(1975) 440): without a jump where it touches, and without a pull where it leaves.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cache
from typing import Any, NamedTuple

from sympy import Expr, Float, Max, Piecewise, S, Symbol, integrate, symbols

from ..closed_form import Num
from ..generic_chain import GenericChain
from .kinds import Load, Value

LEAST = Float("1e-300")  # m or rad, that powers of a depth are taken of
_depth, _k, _e = symbols("depth k e", positive=True)


@cache
def _spring(exponent: Expr) -> tuple[Expr, Expr]:
    """Force of a spring by its depth and its stiffness, and the energy that it has taken up."""
    force = _k * _depth**exponent
    energy = integrate(force, _depth)
    return force, energy - energy.subs(_depth, 0)


class ContactState(NamedTuple):
    """A contact in symbols, of every joint if it is along the rod: depth [m or rad], negative while
    it is apart; push [N or N m]; opening: what is zero where the damper would begin to pull;
    corner: what is zero where the push turns from one side to another; one where nothing does."""

    depth: Expr
    push: Expr
    opening: Expr
    corner: Expr = S.One


class Contact(Load):
    """Law of a load that pushes while it is pressed."""

    @property
    def angles(self) -> tuple[Symbol, ...]:
        """None: what the law makes of its parameters is given to the proofs of its work."""
        return ()

    @abstractmethod
    def contact(self, chain: GenericChain) -> ContactState:
        """Depth, push and opening of the contact."""

    # The law ------------------------------------------------------------------------------------

    def _by_spring(self, of: int, depth: Expr) -> Expr:
        """Force of the spring (0) or its energy (1) at a positive depth."""
        given, exponent = self.number("exponent"), S.One
        if given is not None:
            # No power of what is not positive, whichever branch is taken.
            exponent, depth = given, Max(depth, LEAST)
        law = _spring(_e if given is not None else S.One)[of]
        return law.subs({_e: exponent}).xreplace({_depth: depth, _k: self.number("stiffness")})

    def opening(self, rate: Expr) -> Expr:
        """Factor of the damper at a rate of the depth, before it is kept from pulling."""
        c = self.number("damping")
        return S.One if c is None else 1 + c * rate

    def push(self, depth: Expr, rate: Expr) -> Expr:
        """Force of the contact [N], or moment [N m], at a depth and its rate."""
        force, opening = self._by_spring(0, depth), self.opening(rate)
        if opening != 1:
            force *= Piecewise((opening, opening > 0), (S.Zero, True))
        return Piecewise((force, depth > 0), (S.Zero, True))

    def stored_energy(self, depth: Expr) -> Expr:
        """Energy that the spring has taken up [J]."""
        return Piecewise((self._by_spring(1, depth), depth > 0), (S.Zero, True))

    def damping_power(self, depth: Expr, rate: Expr) -> Expr:
        """Power of the damper [W]: what the spring does not give back; never positive."""
        if (c := self.number("damping")) is None:
            return S.Zero
        beside = Piecewise((c * rate, c * rate > -1), (-S.One, True))
        return Piecewise((-self._by_spring(0, depth) * beside * rate, depth > 0), (S.Zero, True))

    # By hand ------------------------------------------------------------------------------------

    def spring_push(self, depth: Num, value: Value) -> Num:
        """Force of the spring alone, in numbers."""
        if depth <= 0:
            return 0 * depth
        exponent = self.number("exponent")
        return value(self.number("stiffness")) * depth ** (
            1 if exponent is None else value(exponent)
        )

    def push_by_hand(self, depth: Num, rate: Num, value: Value) -> Num:
        """Force of the contact, in numbers."""
        c = self.number("damping")
        return self.spring_push(depth, value) * max(0, 1 + (0 if c is None else value(c)) * rate)

    @abstractmethod
    def approach_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Num, Num, Num]:
        """Depth of a contact, its rate, and the length of rod that is pressed, in numbers."""

    def state_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Num, Num, Num]:
        """Depth, push and opening, in numbers."""
        depth, rate, length = self.approach_by_hand(motion, value, functions)
        c = self.number("damping")
        push = length * self.push_by_hand(depth, rate, value)
        return depth, push, 1 + (0 if c is None else value(c)) * rate

    def energy_by_hand(self, motion: Any, value: Value, functions: Any) -> Num:
        """Energy of the spring: the integral of its force, in numbers."""
        depth, _, length = self.approach_by_hand(motion, value, functions)
        if depth <= 0:
            return 0 * depth
        return length * functions.quad(lambda d: self.spring_push(d, value), [0, depth])

    def lost_by_hand(self, motion: Any, value: Value, functions: Any) -> Num:
        """Power that is not that of the spring, in numbers."""
        depth, rate, length = self.approach_by_hand(motion, value, functions)
        pushes = self.spring_push(depth, value), self.push_by_hand(depth, rate, value)
        return length * (pushes[0] - pushes[1]) * rate
