"""The jobs that whole integrations are timed on, each with its reference solution.

A reference is a file of data/, made by references.py, which holds the angles of the links at the
end and an estimate of their own error from two families of methods.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from problem import Vector

import rodgen

DATA = Path(__file__).parent / "data"
SCENES = Path(__file__).parents[1] / "scenes"


@dataclass(frozen=True, eq=False)
class Job:
    """A scene, and the name of its reference in data/."""

    name: str
    scene: rodgen.Scene

    @cached_property
    def reference(self) -> dict[str, Any]:
        """The file of data/: phi at the end, error_estimate and where they come from."""
        found: dict[str, Any] = json.loads((DATA / f"{self.name}.json").read_text(encoding="utf-8"))
        return found

    @cached_property
    def exact(self) -> Vector:
        """The angles of the moving links at the end [rad]."""
        return np.array(self.reference["phi"])

    def phi(self, y: Vector) -> Vector:
        """The angles of the moving links in a state, or in the first half of one."""
        base = 2 if self.scene.hold.translates else 0
        return np.asarray(y)[base : base + self.scene.rod.links]

    def error(self, y: Vector) -> float:
        """Largest error of an angle at the end [rad]; infinite where it is not a number."""
        off = float(np.abs(self.phi(y) - self.exact).max())
        return off if np.isfinite(off) else np.inf

    @property
    def start(self) -> Vector:
        """The state at the start."""
        y0: Vector = self.scene.initial_state()
        return y0

    @property
    def span(self) -> tuple[float, float]:
        """From when to when [s]."""
        first, last = self.scene.integrate.span
        return first, last

    @property
    def stretches(self) -> list[tuple[float, float]]:
        """The span, parted where a load is not smooth: every method steps onto these times."""
        first, last = self.span
        return list(pairwise([first, *self.scene.breaks(), last]))


def rod(links: int, damping: float = 0.0, span: float = 10.0) -> rodgen.Scene:
    """A free rod, slightly bent, under a follower force of 300 N, 68 % of the critical one."""
    loads: dict[str, Any] = {"follower": {"force": 300.0}}
    if damping:
        loads["internal_damping"] = {"coefficient": damping}
    return rodgen.Scene.from_dict(
        {
            "name": f"rod_n{links}",
            "rod": {"links": links, "length": 5.0, "bending_stiffness": 100.0, "mass": 50.0},
            "loads": loads,
            "initial": {"phi": "0.01*cos(pi*s)"},
            "integrate": {"span": [0.0, span], "output_every": span},
        }
    )


R50 = Job("rod_n50", rod(50))
R200 = Job("rod_n200", rod(200))
DAMPED = Job("rod_n200_damped", rod(200, damping=5.0))  # m^2/s
THESIS = Job("thesis", rod(50, span=200.0))  # timed alone, at a step of 0.6 ms
BEAM = Job("ivp_beam", rodgen.Scene.from_toml(SCENES / "ivp_beam.toml"))
JOBS = (R50, R200, DAMPED, BEAM)
