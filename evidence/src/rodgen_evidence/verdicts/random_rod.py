"""A rod of random size, and numbers in decades: what random scenes of all campaigns begin with."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen.model.rod import BOUNDARIES, INERTIAS


class RandomRod:
    """Size, ends and units of a rod: F of its forces [N], T of its times [s].

    structure: number of its structure; shape: draws what belongs to that; sizes: draws numbers.
    """

    def __init__(self, structure: int, shape: Any, sizes: Any):
        self.shape, self.sizes = shape, sizes
        self.boundary = list(BOUNDARIES)[structure % len(BOUNDARIES)]
        self.inertia = str(shape.choice(list(INERTIAS)))
        self.n = self.links()
        self.L, self.M = self.size(0.5, 3), self.size(0.5, 5)
        self.EI = self.size(0.5, 100)
        self.F = self.EI / self.L**2
        self.T = float(np.sqrt(self.M * self.L**3 / self.EI))

    def links(self) -> int:
        """Draw a number of links."""
        return int(self.shape.integers(2, 6))

    def chance(self, share: float) -> bool:
        """Whether something is so in a share of all structures."""
        return bool(self.shape.random() < share)

    def size(self, low: float, high: float) -> float:
        """A number between two, alike in all decades."""
        return float(f"{10 ** self.sizes.uniform(np.log10(low), np.log10(high)):.6g}")

    def signed_size(self, low: float, high: float) -> float:
        """Draw a number of a random size with either sign."""
        return float(self.sizes.choice([-1, 1])) * self.size(low, high)

    def spot(self) -> float:
        """A place along the rod, as a share of its length."""
        return round(float(self.shape.random()), 2)
