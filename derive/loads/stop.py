"""Stop: a point of the rod runs against something that pushes it back and never pulls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sympy import Eq, Expr, IndexedBase, Piecewise, S

from rodgen.model.rod import Boundary

from ..chain import Vector, direction, link_step
from ..generic_chain import GenericChain
from ..symbols import i, joint_vx, joint_vy, joint_x, joint_y
from .contact import Contact, ContactState
from .kinds import Value
from .point_force import PointForce


class Stop(Contact, PointForce):
    """A force on a point of a link, by its way beyond a gap in a direction."""

    letter = "S"
    by_velocity = by_position = True
    is_inside = True  # its arrays are of every joint, at the tail too
    _depends_on_link = True

    @property
    def force_arrays(self) -> tuple[IndexedBase, ...]:
        x, y = (IndexedBase(f"{self.term}_pull_{axis}", real=True) for axis in "xy")
        return x, y

    def force(self, angle: Expr) -> Vector:
        x, y = (base[self.point.link] for base in self.force_arrays)
        return x, y

    def constants(self, first_joint: int, links: int) -> list[Expr]:
        return [base[link] for base in self.force_arrays for link in range(links)]

    def _seen(self, place: Vector, velocity: Vector) -> tuple[Vector, Expr, Expr]:
        """Unit vector towards the stop, depth and its rate, for a point at a place."""
        unit = direction(self.number("direction"))
        to = (self.number("to", part) for part in "01")
        way = sum((x - x0) * u for x, x0, u in zip(place, to, unit, strict=True))
        rate = sum(v * u for v, u in zip(velocity, unit, strict=True))
        return unit, way - self.number("gap"), rate

    def _motion(self, link: Expr, at: Expr, way: Expr) -> Any:
        """Direction, depth and rate for a point a share ``way`` of a link behind joint ``at``."""
        x, y, vx, vy = link_step(link, way, self.rod.length(link)) if way != 0 else (S.Zero,) * 4
        place = joint_x[at] + x, joint_y[at] + y
        velocity = joint_vx[at] + vx, joint_vy[at] + vy
        return self._seen(place, velocity)

    def _push(self, link: Expr, at: Expr, way: Expr) -> Vector:
        unit, depth, rate = self._motion(link, at, way)
        push = self.push(depth, rate)
        return -push * unit[0], -push * unit[1]

    def link_arrays(self, boundary: Boundary) -> dict[IndexedBase, Expr]:
        here, law = Eq(i, self.point.link), self._push(i, i, self.point.share)
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
            law = [e + part[at] * f for e, f in zip(law, self._push(*there), strict=True)]
        return {base[at]: e for base, e in zip(self.bases, law, strict=True)}

    def contact(self, chain: GenericChain) -> ContactState:
        link = self.point.link
        _, depth, rate = self._motion(link, link, self.point.share)
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
        link = self.point.link
        _, depth, rate = self._motion(link, link, self.point.share)
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
