"""A periodic motion and what there is to say of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.analyse.cycles.closing import Orbit
from rodgen.analyse.cycles.elimination import Complex
from rodgen.arrays import Array
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import Solution
from rodgen.scene import Scene
from rodgen.shown import Shown
from rodgen.system import System

STABLE = 1e-7  # by which a multiplier may exceed 1: beyond it, a cycle is unstable


@dataclass(frozen=True, repr=False)
class Cycle(Shown):
    """A periodic motion.

    scene: the scene with the loads of the cycle, starting on it; t: time of y0 [s], which counts if
    loads repeat; period: of the motion [s]; y0: a state on the cycle (states,), in SI units;
    multipliers: Floquet multipliers, the largest first (the place of joint 0 has none if nothing
    depends on it, and without drag its velocity neither); trivial: how many of them are 1 by
    symmetry (one for time, one if the rod may be turned, one for each conserved quantity);
    trivial_error: the largest difference of these from 1, dimensionless, a measure of the error of
    all; angle: by which the rod as a whole is turned after a period [rad]; energy: of y0 [J];
    amplitude: the largest deviation of an angle from its mean [rad]; forced: whether the period is
    that of the loads, or a whole multiple of it; residual: how far the motion is from closing, over
    its size, dimensionless; iterations: number of Newton's corrections; by: "collocation",
    "shooting" or "picard"; error: of the period and the larger multipliers, relative,
    dimensionless, from two meshes of collocation; after: length of the run that led to the cycle
    [s]; notes: what changes with twice as many links, if that was asked for; model: the generated
    module, if it is there already; orbit: the mesh of the motion, from which branches go on.

    Examples
    --------
    >>> import rodgen
    >>> cycle = rodgen.find_cycle(rodgen.Scene.example("beck_after_flutter"))
    >>> cycle.stable, bool(abs(cycle.nontrivial[0]) < 1), cycle.drift.tolist()
    (True, True, [0.0, 0.0])
    """

    scene: Scene
    t: float
    period: float
    y0: Array = field(repr=False)
    multipliers: Complex = field(repr=False)
    trivial: int
    trivial_error: float
    angle: float
    energy: float
    amplitude: float
    forced: bool
    residual: float
    iterations: int
    by: str
    error: float = 0.0
    after: float = 0.0
    notes: tuple[str, ...] = ()
    model: ModuleType | None = field(default=None, repr=False, compare=False)
    orbit: Orbit | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        how = "stable" if self.stable else f"unstable ({self.unstable} multipliers above 1)"
        return (
            f"<Cycle of {self.scene.name}: period {self.period:.8g} s, "
            f"amplitude {self.amplitude:.4g} rad; {how}>"
        )

    @cached_property
    def nontrivial(self) -> Complex:
        """The multipliers that are not 1 by symmetry, the largest first."""
        return nontrivial(self.multipliers, self.trivial)

    @property
    def unstable(self) -> int:
        """How many of them are larger than 1."""
        return int((np.abs(self.nontrivial) > 1 + STABLE).sum())

    @property
    def stable(self) -> bool:
        """Whether small disturbances do not grow."""
        return self.unstable == 0

    @cached_property
    def motion(self) -> Solution:
        """The run over one period, in 128 steps of time, with the work of every load."""
        settings: dict[str, Any] = {"span": [self.t, self.t + self.period]}
        settings |= {"output_every": self.period / 128, "rtol": 1e-10, "atol": 1e-12}
        return simulate(
            System(self.scene).at({"events": [], "integrate": settings}), model=self.model
        )

    @cached_property
    def drift(self) -> Array:
        """By how much joint 0 moves in a period (2,) [m]."""
        joints: Array = self.motion.joints[[0, -1], 0]
        moved: Array = joints[1] - joints[0]
        return moved

    @property
    def work(self) -> dict[str, float]:
        """Work of every load without potential over the period [J], by name; their sum is what the
        energy of the rod gains: 0, unless it is carried on by its thrust."""
        return {name: float(done[-1]) for name, done in self.motion.work.items()}


def nontrivial(found: Complex, trivial: int) -> Complex:
    """Multipliers without so many of those nearest to 1."""
    left = np.ones(len(found), dtype=bool)
    left[np.argsort(np.abs(found - 1), kind="stable")[:trivial]] = False
    return found[left]
