"""Stop: a point of the rod runs against something that pushes it back and never pulls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sympy import Expr

from ..chain import Vector, direction
from ..generic_chain import GenericChain
from .contact import Contact, ContactState
from .kinds import Value
from .point_law import PointLaw, PointMotion


class Stop(Contact, PointLaw):
    """A force on a point of a link, by its way beyond a gap in a direction."""

    letter = "S"
    by_position = True

    def _seen(self, place: Vector, velocity: Vector) -> tuple[Vector, Expr, Expr]:
        """Unit vector towards the stop, depth and its rate, for a point at a place."""
        unit = direction(self.number("direction"))
        to = (self.number("to", part) for part in "01")
        way = sum((x - x0) * u for x, x0, u in zip(place, to, unit, strict=True))
        rate = sum(v * u for v, u in zip(velocity, unit, strict=True))
        return unit, way - self.number("gap"), rate

    def force_at(self, of: PointMotion) -> Vector:
        unit, depth, rate = self._seen(of.place, of.velocity)
        push = self.push(depth, rate)
        return -push * unit[0], -push * unit[1]

    def contact(self, chain: GenericChain) -> ContactState:
        own = self.own_motion
        _, depth, rate = self._seen(own.place, own.velocity)
        return ContactState(depth, self.push(depth, rate), self.opening(rate))

    @property
    def inputs(self) -> list[tuple[str, Expr]]:
        """Numbers that its push depends on, each with its place, a link and a share of it."""
        return [(what, self.point.link + self.point.share) for what in ("x", "y", "vx", "vy")]

    def push_of(self, chain: GenericChain, seen: Sequence[Expr]) -> Expr:
        """Push by the numbers that it follows."""
        x, y, vx, vy = seen
        _, depth, rate = self._seen((x, y), (vx, vy))
        return self.push(depth, rate)

    def power(self, chain: GenericChain) -> Expr:
        own = self.own_motion
        _, depth, rate = self._seen(own.place, own.velocity)
        return self.damping_power(depth, rate)

    def energy(self, chain: GenericChain) -> Expr:
        return self.stored_energy(self.contact(chain).depth)

    # By hand ------------------------------------------------------------------------------------

    def approach_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Any, ...]:
        """Depth beyond the point of touching, which lies in the direction from `to`."""
        (ux, uy), (x, y) = self._unit_by_hand(value, functions), motion.place[:2]
        gap = value(self.number("gap"))
        touched = (value(self.number("to", at)) + gap * u for at, u in (("0", ux), ("1", uy)))
        x0, y0 = touched
        vx, vy = motion.velocity[:2]
        return ux * (x - x0) + uy * (y - y0), ux * vx + uy * vy, 1

    def _unit_by_hand(self, value: Value, functions: Any) -> tuple[Any, Any]:
        angle = value(self.number("direction"))
        return functions.cos(angle), functions.sin(angle)

    def force_by_hand(self, motion: Any, value: Value, functions: Any) -> tuple[Any, ...]:
        """Force on the point of its link: away from the stop."""
        push = self.state_by_hand(motion, value, functions)[1]
        return tuple(-push * u for u in self._unit_by_hand(value, functions))


LOAD = Stop()
