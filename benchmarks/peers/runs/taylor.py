"""heyoka: Taylor series of high order, compiled for the O(n) expressions of chain.py."""

from __future__ import annotations

import time
from collections.abc import Iterator

import heyoka as hy
import numpy as np
from integrate_jobs import Job
from work_precision import Contestant, Finish

import rodgen
from peers.runs import GRACE
from peers.runs.chain import accelerations

# Tolerances by the error that they came to on n = 50, loosest last: each costs minutes to compile.
UNROLLED = ((6.1e-9, 1e-8), (4e-6, 1e-5))
COMPACT = ((0.0, 1e-16), (1e-12, 1e-12))
hy.llvm_state.set_diskcache_enabled(False)  # set-up is that of a first compilation

AGREED = 1e-10  # of the expressions with rodgen's right-hand side, relative


def unrolled(job: Job, asked: float) -> Iterator[Contestant]:
    """Straight code, fast to run; compilation takes tens of seconds to minutes."""
    yield contestant(job, _tolerance(UNROLLED, asked), compact_mode=False)


def compact(job: Job, asked: float) -> Iterator[Contestant]:
    """Loops over functions: compiled in seconds, several times slower to run."""
    yield contestant(job, _tolerance(COMPACT, asked), compact_mode=True)


def _tolerance(known: tuple[tuple[float, float], ...], asked: float) -> float:
    enough = [tol for error, tol in known if error <= asked * GRACE["heyoka"]]
    if not enough:
        raise ValueError("no tolerance is known for such an error")
    return enough[-1]


def contestant(job: Job, tol: float, compact_mode: bool) -> Contestant:
    unknowns, rates = system(job)
    hy.llvm_state.clear_memcache()
    start = time.perf_counter()
    equations = list(zip(unknowns, rates, strict=True))
    series = hy.taylor_adaptive(equations, job.start, tol=tol, compact_mode=compact_mode)
    setup = time.perf_counter() - start
    first, last = job.span

    def integrate() -> Finish:
        series.time = first
        series.state[:] = job.start
        outcome, _, _, count, *_ = series.propagate_until(last)
        if outcome != hy.taylor_outcome.time_limit:
            raise ArithmeticError(str(outcome))
        return Finish(series.state.copy(), f"{count} steps of order {series.order}")

    kind = "compact" if compact_mode else "unrolled"
    return Contestant(f"heyoka {kind}, tol {tol:.0e}", integrate, setup)


def system(job: Job) -> tuple[list[hy.expression], list[hy.expression]]:
    """Unknowns in rodgen's order and their rates, shown to be those of rodgen."""
    if set(job.scene.structure.terms) - {"follower", "internal_damping"}:
        raise ValueError("chain.py knows a follower force and internal damping alone")
    n = job.scene.rod.links
    phi, omega = (hy.make_vars(*(f"{name}{i}" for i in range(n))) for name in ("phi", "omega"))
    x, y, vx, vy = hy.make_vars("x", "y", "vx", "vy")
    bends = accelerations(job.scene, phi, omega, hy.cos, hy.sin)
    unknowns, rates = [x, y, *phi, vx, vy, *omega], [vx, vy, *omega, *bends]
    state = np.random.default_rng(1).normal(size=len(unknowns))
    model = rodgen.build(job.scene, target="c")
    ours = model.rhs(0.0, state, model.parameters(**job.scene.parameters))
    theirs = hy.cfunc(rates, unknowns, compact_mode=True)(state)
    off = np.abs(theirs - ours).max() / np.abs(ours).max()
    if not off < AGREED:
        raise ArithmeticError(f"the expressions differ from rodgen's by {off:.1e}")
    return unknowns, rates
