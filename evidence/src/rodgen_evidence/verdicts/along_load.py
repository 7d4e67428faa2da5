"""Behaviour of a scene under every size of its load, by the 50-digit chain."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from mpmath import mp

from rodgen_evidence.verdicts.digits import DIGITS, FLOAT
from rodgen_evidence.verdicts.exact_rest import ChainFoldError, ExactRest, follow, refine, residual
from rodgen_evidence.verdicts.link_chain import LinkChain, Table
from rodgen_evidence.verdicts.random_scenes import Sketch
from rodgen_evidence.verdicts.spectrum50 import Spectrum50, spectrum50

LOADS = 20
SMALL = 0.02  # of the way on which all loads grow together
HELD = 1e-9  # of the largest stiffness: less holds nothing


class KinkError(Exception):
    """The linearised equations of a rest do not exist."""


class AlongLoad:
    """Rests of a scene along its load, each from that before, and their small motions."""

    def __init__(self, sketch: Sketch, loads: int = LOADS):
        self.sketch = sketch
        self.grid = sketch.highest * np.linspace(0.0, 1.0, loads) ** 2
        self._rests: dict[float, ExactRest] = {}
        self._spectra: dict[float, Spectrum50] = {}
        self.end = np.inf  # the load at which the way of the rests ends

    @cached_property
    def hangs(self) -> bool:
        """Whether nothing but loads gives the rod its direction."""
        table = self.sketch.table
        springs = "supports" in table or "foundation" in table
        return table["rod"]["boundary"] == "pinned" and not springs

    @cached_property
    def start(self) -> Any:
        """The rest without the load, from that of the rod without any. Raises FoldError."""
        chain = LinkChain(self.sketch.table, FLOAT)
        z = np.zeros(chain.size + len(chain.states))
        if self.hangs and (pull := self._pull()).any():
            z[: chain.size] = np.arctan2(pull[1], pull[0])
            return follow(lambda _: self.sketch.at(0.0), z)
        z[chain.base : chain.size] = self.sketch.table["rod"].get("clamp_angle", 0.0)
        return follow(lambda share: self.sketch.at(0.0, share), z)

    def _pull(self) -> Any:
        """Dead loads of the whole rod without the load that is varied."""
        loads = self.sketch.at(0.0)["loads"]
        bodies = sum(body["mass"] for body in self.sketch.table.get("bodies", ()))
        mass = self.sketch.table["rod"]["mass"] + bodies
        down = -mass * loads.get("gravity", {"g": 0.0})["g"]
        tip = loads.get("tip", {})
        return np.array([tip.get("x", 0.0), tip.get("y", 0.0) + down])

    def rest(self, size: float) -> ExactRest:
        """The rest under a size of the load. Raises FoldError."""
        if size not in self._rests:
            if size >= self.end:
                raise ChainFoldError(self.end)
            below = [one for one in self._rests if one <= size]
            low = max(below, default=0.0)
            z = np.array(self._rests[low].z, dtype=float) if below else self.start
            try:
                z = follow(lambda share: self.sketch.at(low + share * (size - low)), z)
                with mp.workdps(DIGITS):
                    self._rests[size] = refine(self.sketch.at(size), z)
            except ChainFoldError as folded:
                self.end = min(self.end, low + folded.where * (size - low))
                raise
        return self._rests[size]

    def spectrum(self, size: float) -> Spectrum50:
        """Small motions under a size of the load. Raises FoldError, KinkError."""
        if size not in self._spectra:
            rest = self.rest(size)
            self._spectra[size] = self.about(self.sketch.at(size), rest)
        return self._spectra[size]

    @staticmethod
    def about(table: Table, rest: ExactRest) -> Spectrum50:
        """Small motions about a rest. Raises KinkError of a bent one with external damping."""
        chain = LinkChain(table, FLOAT)
        phi = np.append(chain.axis * np.ones(chain.held), np.array(rest.z, dtype=float))
        angles = phi[chain.base : chain.base + chain.n]
        if "external_damping" in table["loads"] and np.ptp(angles) > 1e-12:
            raise KinkError("external damping has no linear part about a bent rod")
        return spectrum50(table, rest)

    def at_rest(self, table: Table, y: Any) -> ExactRest:
        """The rest that a state of the product stands for. Raises FoldError where it is none."""
        chain = LinkChain(table, FLOAT)
        z = np.append(y[: chain.size], y[2 * chain.size :])
        with mp.workdps(DIGITS):
            found = refine(table, z)
        if np.abs(np.array(found.z, dtype=float) - z).max(initial=0.0) > 1e-6:
            raise ChainFoldError(0.0)
        return found

    def stays(self, size: float) -> bool:
        """Whether the rest under a size of the load is one, without steady acceleration."""
        chain = LinkChain(self.sketch.at(size), FLOAT)
        g = np.abs(residual(chain, [float(v) for v in self.rest(size).z]))
        scale = chain.k / (chain.l**2 * chain.mass)
        return bool(g.max(initial=0.0) < 1e-6 * scale)

    def together(self, size: float) -> Any:
        """The rest to which all loads lead as they grow together. Raises FoldError."""
        chain = LinkChain(self.sketch.table, FLOAT)
        z = np.zeros(chain.size + len(chain.states))
        z[chain.base : chain.size] = self.sketch.table["rod"].get("clamp_angle", 0.0)
        return follow(lambda share: self.sketch.at(share * size, share), z, SMALL)

    def turns_back(self, size: float) -> bool:
        """Whether all loads, as they grow together, lead to no rest."""
        try:
            self.together(size)
        except ChainFoldError:
            return True
        return False

    def is_way(self, size: float, other: ExactRest) -> bool:
        """Whether they lead to this rest rather than to that of the load that is varied."""
        if self.turns_back(size):
            return False
        apart = np.abs(self.together(size) - np.array(other.z, dtype=float))
        return bool(apart.max(initial=0.0) < 1e-6)
