"""Random scenes by number: structures that many numbers share, and sizes of each."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen_evidence.tolerance.measure.random_loads import Loads

Tables = dict[str, Any]

STRUCTURES = 30  # each is compiled once, which takes some ten seconds
LONGEST = 60.0  # spans, in units of T
RADIANS = 2e4  # of the fastest mode in most spans: tight runs of more take too long
SAMPLES = 100  # intervals between them


def random_tables(seed: int) -> Tables:
    """The tables of the scene of a number."""
    structure = seed % STRUCTURES
    shape = np.random.default_rng([structure, 61])
    return _Rod(structure, shape, np.random.default_rng([seed, 62])).tables(seed)


class _Rod(Loads):
    """The tables of a scene as they are drawn."""

    def tables(self, seed: int) -> Tables:
        rod: Tables = {"length": self.L, "mass": self.M, "bending_stiffness": self.EI}
        rod |= {"links": self.n, "boundary": self.boundary, "inertia": self.inertia}
        found: Tables = {"name": f"tolerance_{seed}", "rod": rod, "loads": self.loads()}
        if "gimbal" in repr(found["loads"]):
            follows = f"{self.size(0.05, 2)!r}*{self.sensor()}"
            rate = f"{self.size(2, 50) / self.T!r}*({follows} - gimbal)"
            found["states"] = {"gimbal": {"rate": rate, "initial": self.size(1e-3, 0.1)}}
        found |= self.springs() | self.bodies()
        found["initial"] = self.start()
        span = self.T * self.size(0.5, self.longest())
        return found | {"integrate": {"span": [0.0, span], "output_every": span / SAMPLES}}

    def longest(self) -> float:
        """The longest span, over T: a period of the first mode of a clamped rod is 1.8 T, and the
        fastest mode makes some 7 n^2 radians in T."""
        more = 4.0 if self.sizes.random() < 0.1 else 1.0
        return min(LONGEST, max(1.0, more * RADIANS / (7 * self.n**2)))

    def start(self) -> Tables:
        """Bent or kicked; one in ten straight and at rest."""
        how = self.sizes.choice(["bent", "kicked", "both", "rest"], p=[0.4, 0.25, 0.25, 0.1])
        a, b = (self.signed_size(1e-3, 1.0) for _ in range(2))
        found: Tables = {}
        if how in ("bent", "both"):
            found["phi"] = f"{a!r}*s + {b!r}*s*s*(1 - s)"
        if how in ("kicked", "both"):
            found["omega"] = f"{self.signed_size(1e-2, 3) / self.T!r}*sin({self.size(1, 6)!r}*s)"
        if self.boundary == "free" and self.sizes.random() < 0.5:
            found["velocity"] = [self.signed_size(0.01, 3) * self.L / self.T for _ in range(2)]
        return found

    def springs(self) -> Tables:
        """Springs and dampers that hold the rod in its place."""
        k, c = self.F / self.L, self.M / self.T
        found: Tables = {}
        if self.boundary != "free" and self.chance(0.15):
            found["foundation"] = {"stiffness": self.size(1, 200) * k / self.L}
            found["foundation"] |= {"damping": self.size(1e-3, 3) * c / self.L}
        if self.chance(0.25):
            ends = (0.0, 1.0) if self.boundary == "free" else (round(0.5 + self.spot() / 2, 3),)
            found["supports"] = []
            for at in ends:
                row: Tables = {"at": at}
                row["stiffness"] = [self.size(1, 500) * k for _ in range(2)]
                row["damping"] = [self.size(1e-3, 3) * c for _ in range(2)]
                if self.chance(0.3):
                    row |= {"rotation": self.size(0.1, 20) * self.F * self.L}
                found["supports"].append(row)
        return found

    def bodies(self) -> Tables:
        if not self.chance(0.2):
            return {}
        body: Tables = {"name": "payload", "at": self.spot(), "mass": self.size(0.02, 3) * self.M}
        if self.inertia == "lumped":
            body["at"] = int(self.shape.integers(1, self.n + 1)) / self.n
        else:
            body["inertia"] = self.size(1e-4, 0.1) * self.M * self.L**2
        return {"bodies": [body]}
