"""Random scenes by number: links, ends, loads, feedback, damping, springs and masses."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rodgen_evidence.verdicts.draws import SHARED, Draws
from rodgen_evidence.verdicts.link_chain import Table
from rodgen_evidence.verdicts.scaling import with_load

HIGHEST = {"follower": 60.0, "tip": 12.0, "distributed_follower": 120.0, "gravity": 30.0}  # EI/L^2
FREE = 1.5  # times as much of a rod that nothing holds
MAINS = ("follower",) * 5 + ("tip", "distributed_follower", "gravity")
STEERS = ("", "", "{g}*{T}*omega({s})", "{g}*phi({s})", "{g}*({T}*omega({s}) + phi(0.5))", "gimbal")
SIDES = ("{g}*{F}*{T}*omega({s})", "{g}*{F}*{T}*vy({s})/{L}", "{g}*{F}*phi({s})")


class Sketch(NamedTuple):
    """A scene as tables, the load that is varied, its largest size, and whether it stays straight;
    unit: the size of that load that counts."""

    seed: int
    table: Table
    load: str
    highest: float
    unit: float
    straight: bool

    def at(self, size: float, others: float = 1.0) -> Table:
        """The tables with this size of the load, and a share of all other loads."""
        return with_load(self.table, self.load, size, others)


def sketch(seed: int) -> Sketch:
    """The scene of a number."""
    shape = np.random.default_rng([seed // SHARED, 32])
    return _Drawn(seed, shape, np.random.default_rng([seed, 33])).sketch()


class _Drawn(Draws):
    """The tables of a scene as they are drawn."""

    def sketch(self) -> Sketch:
        main = str(self.shape.choice(MAINS))
        if main == "gravity" and not self.bent:
            main = "follower"
        tables: Table = {"name": f"scene_{self.seed}", "rod": self.rod(), "loads": self.loads(main)}
        tables |= self.ties() if self.tied else {}
        tables |= self.bodies()
        if '"gimbal"' in repr(tables["loads"]).replace("'", '"'):
            rate, lag = self.law(STEERS[2:5]), repr(self.size(2, 50) / self.T)
            tables["states"] = {"gimbal": {"rate": f"{lag}*({rate} - gimbal)"}}
        unit = self.F / (self.M if main == "gravity" else 1.0)
        free = self.boundary == "free" and not self.tied
        highest = HIGHEST[main] * unit * (FREE if free else 1.0)
        return Sketch(self.seed, tables, main, highest, unit, not self.bent)

    def rod(self) -> Table:
        own = {"length": self.L, "mass": self.M, "bending_stiffness": self.EI}
        return own | {"links": self.n, "boundary": self.boundary, "inertia": self.inertia}

    def loads(self, main: str) -> Table:
        F, T = self.F, self.T
        loads: Table = {}
        if main == "follower" or self.chance(0.2):
            force = 1.0 if main == "follower" else self.size(0.1, 8) * F
            follower: Any = {"force": force}
            steer = self.law(STEERS)
            follower |= {"angle": steer} if steer else {}
            several = [follower]
            if self.chance(0.15):
                at = float(self.shape.choice([0.25, 0.5, 1.0]))
                several.append({"force": self.signed_size(0.1, 5) * F, "at": at})
                if self.bent and self.chance(0.5):
                    several[-1]["angle"] = self.signed_size(0.1, 3)
            if self.chance(0.15):
                several.append({"force": self.law(SIDES), "angle": float(np.pi / 2), "at": 0.5})
            loads["follower"] = several if len(several) > 1 else follower
        if main == "distributed_follower" or self.chance(0.1):
            size = 1.0 if main == "distributed_follower" else self.size(0.1, 10) * F
            loads["distributed_follower"] = {"force_per_length": size / self.L}
        bends = self.bent and main != "gravity" and self.chance(0.5)
        if main == "tip" or self.chance(0.1) or (self.bent and not bends):
            x = -1.0 if main == "tip" else -self.size(0.1, 1) * F
            loads["tip"] = {"x": x, "y": self.signed_size(0.05, 2) * (1 if main == "tip" else F)}
            if not self.bent:
                del loads["tip"]["y"]
        if main == "gravity" or bends:
            loads["gravity"] = {"g": self.size(0.3, 10) * F / self.M}
        if self.chance(0.6):
            loads["material_damping"] = {"time": self.size(1e-3, 0.1) * T}
        if self.chance(0.2):
            loads["internal_damping"] = {"coefficient": self.size(1e-3, 0.3) * self.L**2 / T}
        if self.chance(0.2) and (not self.bent or self.chance(0.3)):
            loads["external_damping"] = {"coefficient": self.size(1e-2, 5) / T}
        if self.chance(0.25):
            loads["drag"] = self.drag()
        return loads
