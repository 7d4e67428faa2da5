"""heyoka: Taylor series of high order, compiled for the O(n) expressions of chain_accelerations.py.

In its compact mode, of loops over functions: straight code is several times faster to run, and
takes minutes to compile.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import cache
from typing import Any

import heyoka as hy
import numpy as np

from rodgen.analyse.precision.contestant import Deadline, NotModelledError
from rodgen.analyse.precision.job import Job, Stretch
from rodgen.arrays import Array
from rodgen_evidence.report.peers import chain_accelerations, loads
from rodgen_evidence.report.peers.peer import Over, Peer

TOLERANCES = (1e-5, 1e-10, 1e-15)  # of one step; each is compiled anew, in 20 s of 50 links
IN_SHORT = (1e-6, 1e-12)
SHORT = 20  # links up to which there is time for all
SYMBOLS = chain_accelerations.Algebra(hy.cos, hy.sin)
FUNCTIONS = {name: getattr(hy, name) for name in loads.NAMES}
hy.llvm_state.set_diskcache_enabled(False)  # set-up is that of a first compilation

Equations = list[tuple[Any, Any]]


class HeyokaRod(Peer):
    """The order follows from the tolerance."""

    who = target = "heyoka"
    most, why = 60, "expressions take longer than a minute to compile"
    knows = chain_accelerations.KNOWN

    def __init__(self, job: Job, method: str):
        super().__init__(job, method)
        self.function = cache(self._function)

    @classmethod
    def family(cls, job: Job, method: str, quick: bool) -> Iterator[Any]:
        """In short of fewer links."""
        if quick and job.scene.rod.links > SHORT:
            raise NotModelledError(f"heyoka: {job.scene.rod.links} links take too long to compile")
        return super().family(job, method, quick)

    @property
    def name(self) -> str:
        """Name of the method, with the mode."""
        return "Taylor, compact"

    @property
    def order(self) -> float | None:
        """The order of the series that was compiled last."""
        return float(self.series[0].order)

    def settings(self, quick: bool) -> Iterator[float]:
        """Tolerances of a step."""
        return iter(IN_SHORT if quick or self.job.scene.rod.links > SHORT else TOLERANCES)

    def integrator(self, setting: float) -> Over:
        """Compile a Taylor integrator for every stretch."""
        hy.llvm_state.clear_memcache()
        begin, parts = time.perf_counter(), self.job.stretches
        written = [equations(self.job, stretch.middle) for stretch in parts]
        middle = time.perf_counter()
        self.series = [
            hy.taylor_adaptive(made, self.job.initial_state, tol=setting, compact_mode=True)
            for made in written
        ]
        self.setup = {"generate": middle - begin, "compile": time.perf_counter() - middle}
        by_start = {part.first: one for part, one in zip(parts, self.series, strict=True)}

        def look(_: Any) -> bool:
            Deadline.check()
            return True

        def over(stretch: Stretch, y: Array) -> Array:
            one = by_start[stretch.first]
            one.time, one.state[:] = stretch.first, y
            grid = [stretch.first, *stretch.times]
            outcome, _, _, count, _, states = one.propagate_grid(grid, callback=look)
            if outcome != hy.taylor_outcome.time_limit:
                raise ArithmeticError(str(outcome))
            self.counts["nsteps"] += count
            return np.array(states[1:])

        return over

    def accelerations(self, t: float, y: Array) -> Array:
        """Accelerations by functions that are compiled once for every stretch."""
        one = self.function(t)
        rates: Array = one(y, time=t) if one.is_time_dependent else one(y)
        return rates

    def _function(self, t: float) -> Any:
        made = equations(self.job, t)
        rates = [rate for _, rate in made[len(made) // 2 :]]
        return hy.cfunc(rates, [unknown for unknown, _ in made], compact_mode=True)


def equations(job: Job, middle: float) -> Equations:
    """Unknowns in rodgen's order, each with its rate, as they are in the stretch of that time."""
    q, u = (
        hy.make_vars(*(f"{name}{i}" for i in range(len(job.initial_state) // 2))) for name in "qu"
    )
    given = loads.parameters(job.scene, middle, FUNCTIONS)(hy.time)
    rates = chain_accelerations.accelerations(job.scene.structure, given, q, u, SYMBOLS)
    return list(zip([*q, *u], [*u, *rates], strict=True))
