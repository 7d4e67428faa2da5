"""Random parts of a scene: numbers in decades, laws of feedback, springs, bodies and drag."""

from __future__ import annotations

from typing import Any

from rodgen_evidence.verdicts.link_chain import Table
from rodgen_evidence.verdicts.random_rod import RandomRod

SHARED = 2  # scenes in a row that have one structure, so that its module is made once


class Draws(RandomRod):
    """A random rod, and parts of a scene for it; seed: number of the scene."""

    def __init__(self, seed: int, shape: Any, sizes: Any):
        super().__init__(seed // SHARED, shape, sizes)
        self.seed = seed
        self.tied = self.chance({"free": 0.5, "pinned": 0.8}.get(self.boundary, 0.3))
        held = self.boundary in ("clamped", "cantilever") or self.tied
        self.bent = self.chance(0.4) and held

    def law(self, texts: tuple[str, ...]) -> str:
        text = str(self.shape.choice(texts))
        g = self.signed_size(1e-3, 0.5)
        given = {"g": repr(g), "T": repr(self.T), "F": repr(self.F), "L": repr(self.L)}
        return text.format(s=self.spot(), **given)

    def drag(self) -> Table:
        """Draw a drag in a wind that bends the rod; straight rods have a wind along their axis."""
        medium = self.M / self.L**2
        found: Table = {"normal": self.size(0.1, 2) * medium}
        found["tangential"] = self.size(0.01, 0.3) * medium
        speed = self.L / self.T
        if self.boundary != "free" or self.tied:
            y = self.signed_size(0.1, 2) * speed if self.bent else 0.0
            found["wind"] = [self.signed_size(0.1, 2) * speed, y]
        return found

    def ties(self) -> Table:
        """Springs and dampers that hold the rod in its place, or in part of it."""
        k, c = self.F / self.L, self.M / self.T
        if self.chance(0.3) and self.boundary != "free":
            return {"foundation": {"stiffness": self.size(1, 50) * k / self.L}} | (
                {"foundation": {"stiffness": self.size(1, 50) * k / self.L, "damping": 0.1 * c}}
                if self.chance(0.5)
                else {}
            )
        ends = (0.0, 1.0) if self.boundary == "free" else (float(self.shape.choice([0.5, 1.0])),)
        rows = []
        for at in ends:
            along = self.size(5, 200) * k if self.boundary == "free" or self.chance(0.3) else 0.0
            row = {"at": at, "stiffness": [along, self.size(1, 100) * k]}
            row["damping"] = [self.size(1e-3, 0.3) * c * bool(along), self.size(1e-3, 0.3) * c]
            if self.chance(0.3):
                row |= {"rotation": self.size(0.1, 5) * k * self.L**2, "rotation_damping": 0.0}
            rows.append(row)
        return {"supports": rows}

    def bodies(self) -> Table:
        if not self.chance(0.25):
            return {}
        body: Table = {"name": "payload", "at": 1.0, "mass": self.size(0.05, 2) * self.M}
        if self.inertia == "lumped":
            body["at"] = int(self.shape.integers(1, self.n + 1)) / self.n
            return {"bodies": [body]}
        body |= {"at": self.spot(), "inertia": self.size(1e-3, 0.1) * self.M * self.L**2}
        if self.bent and self.chance(0.5):
            body["offset"] = [0.0, self.signed_size(0.01, 0.1) * self.L]
        return {"bodies": [body]}
