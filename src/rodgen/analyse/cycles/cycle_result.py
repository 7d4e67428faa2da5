"""Result of the search for a periodic motion: period, multipliers, stability."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.analyse.cycles.elimination import Complex
from rodgen.analyse.cycles.periodicity import Orbit
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import Solution
from rodgen.result import (
    ASKED,
    FLAG,
    USUAL,
    Note,
    Result,
    Row,
    StudyStorage,
    collect_doubts,
    doubt,
    format_angle,
    omit_from_tables,
)
from rodgen.scene import Scene
from rodgen.system import System

STABLE = 1e-7  # by which a multiplier may exceed 1: beyond it, a cycle is unstable
# Error of the trivial multipliers, beyond which all of them are doubtful; where they are double,
# they move by the root of the rounding.
UNSURE, UNSURE_DOUBLE = 1e-6, 1e-4
ROUGH = 1e-8  # likewise, of the error of collocation
SHOWN = 10  # multipliers in a table
STILL = 1e-12  # of the length, by which joint 0 moves by rounding alone
PICARD = "newton_picard"  # which computes the leading multipliers alone


@dataclass(frozen=True, repr=False)
class Cycle(Result, Plottable):
    """A periodic motion.

    system: the rod with the loads of the cycle, starting on it; t: time of y0 [s], which counts if
    loads repeat; period: of the motion [s]; y0: a state on the cycle (states,), in SI units;
    multipliers: Floquet multipliers, the largest first (the place of joint 0 has none if nothing
    depends on it, and without drag its velocity neither); trivial: how many of them are 1 by
    symmetry (one for time, one if the rod may be turned, one for each conserved quantity);
    trivial_error: the largest difference of these from 1, dimensionless, a measure of the error of
    all; angle: by which the rod as a whole is turned after a period [rad]; energy: of y0 [J];
    amplitude: the largest deviation of an angle from its mean [rad]; forced: whether the period is
    that of the loads, or a whole multiple of it; residual: how far the motion is from closing, over
    its size, dimensionless; iterations: number of Newton's corrections; method: "collocation",
    "shooting" or "newton_picard"; error: of the period and the larger multipliers, relative,
    dimensionless, from two meshes of collocation; after: length of the run that led to the cycle
    [s]; found_doubts: of the runs that led to it, and what changes with twice as many links, if
    that was asked for; model: the generated module, if it is there already; orbit: the mesh of the
    motion, from which branches go on.

    Examples
    --------
    >>> import rodgen
    >>> cycle = rodgen.find_cycle(rodgen.Scene.example("beck_after_flutter"))
    >>> cycle.stable, bool(abs(cycle.nontrivial[0]) < 1), cycle.drift.tolist()
    (True, True, [0.0, 0.0])
    """

    system: System
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
    method: str
    error: float = 0.0
    after: float = 0.0
    found_doubts: tuple[Note, ...] = ()
    model: ModuleType | None = field(default=None, repr=False, compare=False)
    orbit: Orbit | None = field(default=None, repr=False, compare=False)

    ROWS = (
        Row("period", "period", "s", ".12g", text=lambda found: found._period, kept=USUAL),
        Row("frequency", "frequency", "Hz"),
        Row("amplitude", "amplitude of the angles", "rad", ".8g", kept=USUAL),
        Row("energy", "energy of y0", "J", kept=ASKED),
        Row("work", "work of {} a period", "J", ".8g"),
        Row("angle", "turned after a period by", "rad", text=lambda found: found._angle),
        Row("drift", "moved after a period by", "m", ".8g", text=lambda found: found._drift),
        Row(
            "moduli",
            "moduli of the multipliers",
            text=omit_from_tables,
            kept=StudyStorage(several=4),
        ),
        Row("multipliers", "multipliers, those that are 1 as well", text=omit_from_tables),
        Row("nontrivial", "multipliers", text=lambda found: found._multipliers),
        Row("trivial", "multipliers that are 1", text=lambda found: found._trivial),
        Row("trivial_error", "their error", format=".1e", text=omit_from_tables, kept=ASKED),
        Row("error", "error of the period", format=".1e", text=omit_from_tables, kept=ASKED),
        Row("stable", "stable", kept=FLAG),
        Row(
            "unstable",
            "multipliers larger than 1",
            text=omit_from_tables,
            kept=StudyStorage(False, "i8", -1),
        ),
        Row("method", "found", text=lambda found: found._way),
        Row("t", "time of y0", "s", text=omit_from_tables),
        Row("y0", "a state on it", text=omit_from_tables),
    )

    @property
    def scene(self) -> Scene:
        """The scene with the loads of the cycle, starting on it."""
        return self.system.scene

    @property
    def frequency(self) -> float:
        """Frequency of the motion [Hz]."""
        return 1 / self.period

    @property
    def moduli(self) -> Array:
        """Absolute values of the multipliers that are not 1 by symmetry, the largest first,
        dimensionless."""
        return np.abs(self.nontrivial)

    @cached_property
    def notes(self) -> tuple[Note, ...]:  # type: ignore[override]  # a field of other results
        """Doubts: that it is unstable, how far its multipliers are right, and what changes with
        twice as many links."""
        return (*self.found_doubts, *self._doubts())

    def with_notes(self, notes: tuple[Note, ...]) -> Cycle:
        """Return a copy with further notes, after those that it was found with."""
        return replace(self, found_doubts=(*self.found_doubts, *notes))

    def _doubts(self) -> Iterator[Note]:
        if not self.stable:
            words = f"this cycle is unstable: {self.unstable} multipliers are larger than 1"
            yield doubt(words, multiplier=float(self.moduli[0]))
        if self.error > ROUGH:
            words = (
                f"the larger multipliers are right to about {self.error:.0e} only: drag and other "
                "loads with a kink spoil the order of collocation"
            )
            yield doubt(words, error=self.error)
        double = not (self.forced or loads_at_work(self.model or self.motion.model))
        if self.trivial_error > (UNSURE_DOUBLE if double else UNSURE):
            words = f"the multipliers are right to {self.trivial_error:.1e} only"
            yield doubt(words, error=self.trivial_error)

    @property
    def _period(self) -> str:
        return f"{self.period:.12g} s" + ", that of the loads" * self.forced

    @property
    def _angle(self) -> str | None:
        return format_angle(self.angle) if self.angle else None

    @property
    def _drift(self) -> str | None:
        (x, y), least = self.drift, STILL * self.system.parameter("length")
        return f"({x:.8g}, {y:.8g}) m" if np.hypot(x, y) > least else None

    @property
    def _multipliers(self) -> dict[str, str]:
        rows = {}
        for at, mu in enumerate(self.nontrivial[:SHOWN].tolist()):
            sign = f" {'+-'[mu.imag < 0]} {abs(mu.imag):.8g} i" if mu.imag else ""
            rows[f"multiplier {at + 1}"] = f"{mu.real:.8g}{sign}   (size {abs(mu):.8g})"
        left = len(self.nontrivial) - len(rows)
        further = f"{left}, smaller" if left else "none"
        rows["further multipliers"] = (
            "smaller, and not computed" if self.method == PICARD else further
        )
        return rows

    @property
    def _trivial(self) -> str:
        if not self.trivial:
            return "none: the loads give the phase"
        return f"{self.trivial}, found with an error of {self.trivial_error:.1e}"

    @property
    def _way(self) -> str:
        way = f"after a run of {self.after:g} s, " if self.after else ""
        way += f"by {self.method}, in {self.iterations} iterations of Newton's method"
        if not self.iterations:
            way = "on the family of a linear mode"
        return f"{way}; closes to {self.residual:.1e} of its size"

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
        """Number of multipliers, of those not 1 by symmetry, that are larger than 1."""
        return int((np.abs(self.nontrivial) > 1 + STABLE).sum())

    @property
    def stable(self) -> bool:
        """Whether small disturbances do not grow."""
        return self.unstable == 0

    @cached_property
    def motion(self) -> Solution:
        """Simulated run over one period, in 128 steps of time, with the work of every load."""
        settings: dict[str, Any] = {"span": [self.t, self.t + self.period]}
        settings |= {"output_every": self.period / 128, "rtol": 1e-10, "atol": 1e-12}
        with collect_doubts():  # what is doubtful about the system was told as it was found
            whole = self.system.at({"events": [], "integrate": settings})
            return simulate(whole, model=self.model)

    @cached_property
    def drift(self) -> Array:
        """Displacement of joint 0 in a period (2,) [m]."""
        joints: Array = self.motion.joints[[0, -1], 0]
        moved: Array = joints[1] - joints[0]
        return moved

    @property
    def work(self) -> dict[str, float]:
        """Work of every load without potential over the period [J], by name. The sum is what the
        rod gains in energy: 0, unless thrust accelerates it as a whole."""
        return {name: float(done[-1]) for name, done in self.motion.work.items()}


def nontrivial(found: Complex, trivial: int) -> Complex:
    """Leave out the multipliers nearest to 1, so many (trivial) of them."""
    left = np.ones(len(found), dtype=bool)
    left[np.argsort(np.abs(found - 1), kind="stable")[:trivial]] = False
    return found[left]
