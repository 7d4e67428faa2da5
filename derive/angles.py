"""Angles known only by cosine and sine: what the closed form needs in exact arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Angle:
    """An angle with exact cosine and sine; sums and differences by the addition theorems."""

    c: Any
    s: Any

    def __add__(self, other: Angle) -> Angle:
        return Angle(self.c * other.c - self.s * other.s, self.s * other.c + self.c * other.s)

    def __rmul__(self, sign: Any) -> Angle:
        if sign != -1:
            raise ValueError(
                f"only minus an angle is known by cosine and sine, not {sign} times it"
            )
        return Angle(self.c, -self.s)

    def __sub__(self, other: Angle) -> Angle:
        return Angle(self.c * other.c + self.s * other.s, self.s * other.c - self.c * other.s)


def cos(angle: Angle) -> Any:
    return angle.c


def sin(angle: Angle) -> Any:
    return angle.s
