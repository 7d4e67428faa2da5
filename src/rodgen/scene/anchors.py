"""Supports of a rod at points, and a foundation all along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.model.terms import TERMS
from rodgen.scene.distribution import Distribution
from rodgen.scene.expression_text import Numbers
from rodgen.scene.law import Law
from rodgen.scene.rod_mesh import RodMesh

if TYPE_CHECKING:
    from rodgen.scene.tables import BodyTable, FoundationTable, RodTable, SupportTable

SAME = 1e-9  # of a link, by which points are one


def _has_effect(support: SupportTable) -> bool:
    """Whether a support has any stiffness or damping."""
    turning = support.rotation, support.rotation_damping
    return any((*support.stiffness, *support.damping, *turning))


@dataclass(frozen=True)
class SupportPoint:
    """A support, for drawing: its link, the share of that before its point, the fixed point [m]."""

    link: int
    share: float
    x: float
    y: float

    def segment(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Segment from the rod to the fixed point, (2, 2), for joints at (links + 1, 2)."""
        start, end = joints[self.link], joints[self.link + 1]
        return np.array((start + self.share * (end - start), (self.x, self.y)))


@dataclass(frozen=True)
class Anchors:
    """Supports and foundation of a rod.

    start: position of joint 0 [m]; numbers: values of the names in expressions; turned: angle of
    link 0 of a rod without a clamp [rad]; moved: whether the base moves joint 0; bodies: those on
    the rod, of which some let its ends bend.
    """

    rod: RodTable
    supports: Sequence[SupportTable] = ()
    foundation: FoundationTable | None = None
    start: Sequence[float] = (0.0, 0.0)
    numbers: Numbers = ()
    turned: float = 0.0
    moved: bool = False
    bodies: Sequence[BodyTable] = ()

    def check(self) -> None:
        """Raise InputError for supports or a foundation that no module can have."""
        if self.foundation is not None:
            self._stiffness.check(self.mesh, self.rod.links + 1)
        first: dict[int, tuple[int, float]] = {}
        for i, support in enumerate(self.supports):
            link, share = self.mesh.link_and_share(support.at)
            if link < self.rod.boundary_condition.first:
                allowed = f"on a link that moves, beyond {self.mesh.places[1]:.6g}"
                raise InputError(f"supports[{i}].at", support.at, allowed)
            other, there = first.setdefault(link, (i, share))
            if abs(share - there) > SAME:
                elsewhere = f"on another link than supports[{other}], or at its point"
                raise InputError(f"supports[{i}].at", support.at, f"{elsewhere}: take more links")

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of their terms in a module."""
        found = ("supports",) * bool(self.supports)
        if self.foundation is not None:
            aside = "@through" * (self.through is not None)
            found = (f"foundation{aside}", *found)
        return found

    @property
    def through(self) -> Sequence[float] | None:
        """Point through which the axis of the foundation goes [m]; None for the origin."""
        if self.foundation is None:
            return None
        return self.foundation.through or (self.start if self.moved else None)

    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the parameters of these terms, by name."""
        values: dict[str, Any] = {}
        if self.foundation is not None:
            values |= self._foundation_parameters()
        return values | self._support_parameters() if self.supports else values

    @property
    def mesh(self) -> RodMesh:
        """Where the joints of the rod are."""
        return self.rod.mesh(self.numbers)

    @property
    def angle(self) -> float:
        """Angle of the straight rod [rad]."""
        return float(self.rod.clamp_angle or self.turned)

    def fixed_point(self, support: Any) -> tuple[float, float]:
        """Fixed point of the table of a support or a stop [m]; by default where the rod without
        load has its point."""
        if support.to is not None:
            return float(support.to[0]), float(support.to[1])
        shape = Distribution(self.rod, self.bodies, self.numbers).rest_shape
        angles = self.angle + np.concatenate(([0.0], shape))
        straight, *turned = np.stack((np.cos(angles), np.sin(angles)), axis=-1)
        link, share = self.mesh.link_and_share(support.at)
        way = self.mesh.lengths(self.rod.length)
        way[link] *= share
        way[link + 1 :] = 0.0
        # With what a bent rod has beside the straight one, to which rounding adds nothing.
        point = support.at * self.rod.length * straight + way @ (turned - straight)
        return float(self.start[0] + point[0]), float(self.start[1] + point[1])

    @property
    def support_points(self) -> list[SupportPoint]:
        """Supports that have any effect, for drawing."""
        acting = filter(_has_effect, self.supports)
        return [
            SupportPoint(*self.mesh.link_and_share(one.at), *self.fixed_point(one))
            for one in acting
        ]

    @property
    def foundation_line(self) -> NDArray[np.float64]:
        """Line across which a foundation acts, as long as the rod, (2, 2); (0, 2) without one."""
        ways = (0.0, self.rod.length) if self.foundation is not None else ()
        x, y = self.through or (0.0, 0.0)
        points = [(x + way * cos(self.angle), y + way * sin(self.angle)) for way in ways]
        return np.array(points).reshape(-1, 2)

    def _foundation_parameters(self) -> dict[str, Any]:
        """Parameters of a foundation: each joint carries half a link to either side."""
        assert self.foundation is not None
        width = self.mesh.lengths_at_joints(self.rod.length)
        stiffness = self._stiffness.at(self.mesh.places)
        aside = {}
        if (point := self.through) is not None:
            offset = cos(self.angle) * point[1] - sin(self.angle) * point[0]
            aside = {"foundation_offset": float(offset)}
        return aside | {
            "foundation_angle": self.angle,
            "foundation_stiffness": (width * stiffness).tolist(),
            "foundation_damping": (width * self.foundation.damping).tolist(),
        }

    def _support_parameters(self) -> dict[str, Any]:
        """Parameters of supports: several at one point become one, fixed where they balance."""
        links = self.rod.links
        names = [one.name for one in TERMS["supports"].parameters if one.is_array]
        values = {name: np.zeros(links) for name in names}
        for support in self.supports:
            link, values["support_share"][link] = self.mesh.link_and_share(support.at)
            for axis, at in zip("xy", self.fixed_point(support), strict=True):
                stiffness = values[f"support_stiffness_{axis}"]
                more = support.stiffness["xy".index(axis)]
                where, total = values[f"support_{axis}"], stiffness[link] + more
                where[link] = (stiffness[link] * where[link] + more * at) / total if total else at
                stiffness[link] = total
                values[f"support_damping_{axis}"][link] += support.damping["xy".index(axis)]
            values["support_rotation"][link] += support.rotation
            values["support_rotation_damping"][link] += support.rotation_damping
        lists = {name: value.tolist() for name, value in values.items()}
        return {"support_angle": self.angle, **lists}

    @property
    def _stiffness(self) -> Law:
        assert self.foundation is not None
        return Law(self.foundation.stiffness, "foundation.stiffness", self.numbers)
