"""Supports: springs and dampers from points of the rod to fixed points, and against turning."""

from typing import Any

from sympy import Expr

from ..closed_form import Num
from ..symbols import parameters
from .kinds import Value
from .link_anchor import LinkAnchor, LinkMotion

ANGLE = parameters("supports")[0]


class Supports(LinkAnchor):
    """Springs of energy (k_x (x - x_0)^2 + k_y (y - y_0)^2 + kappa (phi - phi_0)^2)/2; dampers."""

    letter = "R"

    def spring_energy(self, link: LinkMotion) -> Expr:
        _, x0, y0, kx, ky, _, _, kappa, _ = link.factors
        x, y, angle = link.place
        return (kx * (x - x0) ** 2 + ky * (y - y0) ** 2 + kappa * (angle - ANGLE) ** 2) / 2

    def damper_force(self, link: LinkMotion) -> tuple[Expr, ...]:
        *_, cx, cy, _, chi = link.factors
        return tuple(-c * v for c, v in zip((cx, cy, chi), link.velocity, strict=True))

    def spring_by_hand(self, link: LinkMotion, value: Value, functions: Any) -> tuple[Num, ...]:
        """-k times the displacement from rest."""
        _, _, _, kx, ky, _, _, kappa, _ = link.factors
        rest = self.rest_by_hand(link, value)
        ways = zip((kx, ky, kappa), link.place, rest, strict=True)
        return tuple(-k * (at - there) for k, at, there in ways)

    def damper_by_hand(self, link: LinkMotion, value: Value, functions: Any) -> tuple[Num, ...]:
        """-c times the velocity."""
        _, _, _, _, _, cx, cy, _, chi = link.factors
        vx, vy, rate = link.velocity
        return -cx * vx, -cy * vy, -chi * rate

    def rest_by_hand(self, link: LinkMotion, value: Value) -> tuple[Num, ...]:
        return link.factors[1], link.factors[2], value(ANGLE)


LOAD = Supports()
