"""heyoka: Taylor series of high order, compiled for the O(n) expressions of chain.py.

In its compact mode, of loops over functions: straight code is several times faster to run, and
takes minutes to compile.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import heyoka as hy
import numpy as np

from rodgen.judge.peers import chain, loads
from rodgen.judge.peers.agreement import Accelerations, agreed
from rodgen.judge.peers.stretches import Stretch, integrated, stretches
from rodgen.judge.precision.contestant import Array, Contestant, Deadline, Finish, NotModelledError
from rodgen.judge.precision.job import Job

TOLERANCES = (1e-5, 1e-10, 1e-15)  # of one step; each is compiled anew, in 20 s of 50 links
IN_SHORT = (1e-6, 1e-12)
SHORT = 20  # links up to which there is time for all
LARGEST = 60  # links whose settings are compiled within a minute
FUNCTIONS = {name: getattr(hy, name) for name in loads.NAMES}
hy.llvm_state.set_diskcache_enabled(False)  # set-up is that of a first compilation

Equations = list[tuple[Any, Any]]


def compact(job: Job, quick: bool) -> Iterator[Contestant]:
    """The order follows from the tolerance."""
    loads.refuse("heyoka", job.scene, chain.KNOWN)
    if job.scene.rod.links > (SHORT if quick else LARGEST):
        raise NotModelledError(f"heyoka: {job.scene.rod.links} links take too long to compile")
    off = agreed(job, _accelerations(job))
    few = quick or job.scene.rod.links > SHORT
    return (_contestant(job, tol, off) for tol in (IN_SHORT if few else TOLERANCES))


def _contestant(job: Job, tol: float, off: float) -> Contestant:
    hy.llvm_state.clear_memcache()
    begin = time.perf_counter()
    written = [equations(job, stretch.middle) for stretch in stretches(job)]
    middle = time.perf_counter()
    series = [hy.taylor_adaptive(made, job.start, tol=tol, compact_mode=True) for made in written]
    setup = {"generate": middle - begin, "compile": time.perf_counter() - middle}
    by_start = dict(zip((stretch.first for stretch in stretches(job)), series, strict=True))

    def integrate() -> Finish:
        steps = 0

        def look(_: Any) -> bool:
            Deadline.look()
            return True

        def over(stretch: Stretch, y: Array) -> Array:
            nonlocal steps
            one = by_start[stretch.first]
            one.time, one.state[:] = stretch.first, y
            grid = [stretch.first, *stretch.times]
            outcome, _, _, count, _, states = one.propagate_grid(grid, callback=look)
            if outcome != hy.taylor_outcome.time_limit:
                raise ArithmeticError(str(outcome))
            steps += count
            return np.array(states[1:])

        return Finish(integrated(job, over), {"steps": steps})

    return Contestant(
        "heyoka",
        "Taylor, compact",
        "heyoka",
        "rtol",
        tol,
        integrate,
        order=float(series[0].order),
        setup=setup,
        agreed=off,
    )


def equations(job: Job, middle: float) -> Equations:
    """Unknowns in rodgen's order, each with its rate, as they are in the stretch of that time."""
    base = 2 if job.scene.hold.translates else 0
    q, u = (hy.make_vars(*(f"{name}{i}" for i in range(len(job.start) // 2))) for name in "qu")
    given = loads.parameters(job.scene, middle, FUNCTIONS)(hy.time)
    rates = chain.accelerations(job.scene, given, q[base:], u[base:], hy.cos, hy.sin)
    return list(zip([*q, *u], [*u, *rates], strict=True))


def _accelerations(job: Job) -> Accelerations:
    """Compiled once for every stretch."""

    @lru_cache
    def function(t: float) -> Any:
        made = equations(job, t)
        rates = [rate for _, rate in made[len(made) // 2 :]]
        return hy.cfunc(rates, [unknown for unknown, _ in made], compact_mode=True)

    def found(t: float, y: Array) -> Array:
        one = function(t)
        rates: Array = one(y, time=t) if one.is_time_dependent else one(y)
        return rates

    return found
