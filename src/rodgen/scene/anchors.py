"""What holds a rod elsewhere than at its start: supports, and a foundation all along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.model.terms import TERMS
from rodgen.scene.expression import Numbers
from rodgen.scene.law import Law
from rodgen.scene.places import point_of

if TYPE_CHECKING:
    from rodgen.scene.tables import Foundation, Rod, Support

SAME = 1e-9  # of a link, by which points are one


def _acts(support: Support) -> bool:
    """Whether it holds or damps anything."""
    turning = support.rotation, support.rotation_damping
    return any((*support.stiffness, *support.damping, *turning))


@dataclass(frozen=True)
class Tie:
    """A support as it is drawn: its link, the share of that before its point, and the fixed
    point."""

    link: int
    share: float
    x: float
    y: float

    def way(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """From the point of the rod to the fixed one, (2, 2), for joints at (links + 1, 2)."""
        start, end = joints[self.link], joints[self.link + 1]
        return np.array((start + self.share * (end - start), (self.x, self.y)))


@dataclass(frozen=True)
class Anchors:
    """The anchors of a rod; start: where joint 0 is; numbers: those that expressions call by
    names."""

    rod: Rod
    supports: Sequence[Support] = ()
    foundation: Foundation | None = None
    start: Sequence[float] = (0.0, 0.0)
    numbers: Numbers = ()

    def check(self) -> None:
        """Raise InputError for what no anchor can be like."""
        if self.foundation is not None:
            self._stiffness.check(self.rod.links, self.rod.links + 1)
        first: dict[int, tuple[int, float]] = {}
        for i, support in enumerate(self.supports):
            link, share = point_of(support.at, self.rod.links)
            if link < self.rod.hold.first:
                allowed = f"on a link that moves, beyond {1 / self.rod.links:.6g}"
                raise InputError(f"supports[{i}].at", support.at, allowed)
            other, there = first.setdefault(link, (i, share))
            if abs(share - there) > SAME:
                allowed = (
                    f"on another link than supports[{other}], or at its point: take more links"
                )
                raise InputError(f"supports[{i}].at", support.at, allowed)

    @property
    def terms(self) -> tuple[str, ...]:
        """Terms that a module has for them."""
        return ("foundation",) * (self.foundation is not None) + ("supports",) * bool(self.supports)

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters of these terms."""
        values: dict[str, Any] = {}
        if self.foundation is not None:
            values |= self._bedded()
        return values | self._supported() if self.supports else values

    @property
    def angle(self) -> float:
        """The angle of the straight rod [rad]."""
        return self.rod.clamp_angle or 0.0

    def place(self, support: Support) -> tuple[float, float]:
        """The fixed point of a support; by default where the straight rod has its point."""
        if support.to is not None:
            return support.to[0], support.to[1]
        way = support.at * self.rod.length
        return self.start[0] + way * cos(self.angle), self.start[1] + way * sin(self.angle)

    @property
    def ties(self) -> list[Tie]:
        """Supports as they are drawn: those that do anything."""
        links, acting = self.rod.links, filter(_acts, self.supports)
        return [Tie(*point_of(one.at, links), *self.place(one)) for one in acting]

    @property
    def bed(self) -> NDArray[np.float64]:
        """The line across which a foundation acts, as long as the rod, (2, 2); (0, 2) without."""
        ways = (0.0, self.rod.length) if self.foundation is not None else ()
        points = [(way * cos(self.angle), way * sin(self.angle)) for way in ways]
        return np.array(points).reshape(-1, 2)

    def _bedded(self) -> dict[str, Any]:
        """Of a foundation: every joint has what lies along half a link on both sides."""
        assert self.foundation is not None
        links = self.rod.links
        width = np.full(links + 1, self.rod.length / links)
        width[[0, -1]] /= 2
        stiffness = self._stiffness.at(np.arange(links + 1) / links)
        return {
            "foundation_angle": self.angle,
            "foundation_stiffness": (width * stiffness).tolist(),
            "foundation_damping": (width * self.foundation.damping).tolist(),
        }

    def _supported(self) -> dict[str, Any]:
        """Of supports: those of one point are one, which rests where they are in balance."""
        links = self.rod.links
        names = [one.name for one in TERMS["supports"].parameters if one.several]
        values = {name: np.zeros(links) for name in names}
        for support in self.supports:
            link, values["support_share"][link] = point_of(support.at, links)
            for axis, at in zip("xy", self.place(support), strict=True):
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
