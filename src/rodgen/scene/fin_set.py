"""Fins on a body in the air, by their geometry.

J. S. and J. A. Barrowman, The Theoretical Prediction of the Center of Pressure (NARAM-8, 1966): of
a slender rocket at a small angle of attack, well below the speed of sound.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi, sqrt

# Numbers of fins, each with the share of the body's interference that it has.
SETS = {3: 1.0, 4: 1.0, 6: 0.5}


@dataclass(frozen=True)
class FinSet:
    """A set of equal fins. Lengths in m: chords of root and tip, span beyond the body, way from the
    leading edge of the root to that of the tip along the body, radius of the body."""

    root: float
    tip: float
    span: float
    sweep: float
    number: int
    body_radius: float

    @property
    def area(self) -> float:
        """Reference area: the cross section of the body [m^2]."""
        return pi * self.body_radius**2

    @property
    def normal_slope(self) -> float:
        """Slope of the coefficient of normal force over the angle of attack, body and fins
        together where these stand."""
        body, share = self.body_radius, SETS[self.number]
        middle = hypot(self.span, self.sweep + (self.tip - self.root) / 2)  # line of half the chord
        slender = 1 + sqrt(1 + (2 * middle / (self.root + self.tip)) ** 2)
        alone = self.number * (self.span / body) ** 2 / slender
        return (1 + share * body / (self.span + body)) * alone

    @property
    def centre(self) -> float:
        """Where the normal force acts, behind the leading edge of the root [m]."""
        total = self.root + self.tip
        swept = self.sweep / 3 * (self.root + 2 * self.tip) / total
        return swept + (total - self.root * self.tip / total) / 6
