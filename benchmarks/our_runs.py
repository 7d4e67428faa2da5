"""rodgen's own methods as contestants."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from integrate_jobs import Job
from work_precision import Contestant, Deadline, Family, Finish

import rodgen
from rodgen.scene import tables

# Steps at the very limit are among those that are tried.
warnings.simplefilter("ignore", rodgen.StepWarning)

# Steps times the largest rate of the rod at which a method of fixed step begins to be stable; and
# the error below which it is not looked at, as its order is too low.
FIXED = {
    "semi_implicit_euler": (2.0, 1e-6),
    "rk4": (2.8, 1e-8),
    "thesis_runge_kutta": (1.66, 1e-6),
}
SHARES = (1.0, 0.1, 1e-2)  # absolute tolerance over the relative one
ADAPTIVE = ("dop853", "gauss", "radau")
TIGHTEST = 2.3e-14  # a hundred times the rounding of a double


def families(job: Job, asked: float, methods: tuple[str, ...] = ()) -> dict[str, Family]:
    """Those of the methods, or of all, that this rodgen has, from loose to tight settings."""
    offered = [name for name in methods or (*ADAPTIVE, *FIXED) if name in tables.METHODS]
    found: dict[str, Family] = {}
    for name in offered:
        if name not in FIXED:
            for share in SHARES:
                found[f"{name}, atol {share:g} rtol"] = _adaptive(job, asked, name, share)
        elif asked >= FIXED[name][1]:
            found[name] = _fixed(job, name)
    return found


def contestant(job: Job, label: str, **settings: object) -> Contestant:
    """A run of simulate as a user calls it, with the samples of the start and the end alone."""
    rodgen.build(job.scene, target="c")  # built and compiled before it is timed

    def integrate() -> Finish:
        run = rodgen.simulate(
            job.scene,
            target="c",
            progress=lambda _: Deadline.look(),
            output_every=job.span[1] - job.span[0],
            **settings,
        )
        stats = run.stats
        counts = f"{stats.steps} steps, {stats.rhs} rhs"
        return Finish(run.y[-1], counts, stats.wall_seconds)

    return Contestant(label, integrate)


def tolerances(asked: float) -> Iterator[float]:
    """From a hundred times the error asked for down to rounding, two a decade."""
    for half in range(40):
        rtol = min(1e-2, 100 * asked) * 10 ** (-half / 2)
        if rtol < TIGHTEST:
            return
        yield rtol


def steps(job: Job, reach: float) -> Iterator[int]:
    """Numbers of equal steps in the span, from the limit of stability up, four to an octave."""
    first, last = job.span
    for quarter in range(60):
        yield int(np.ceil((last - first) * fastest(job) / reach * 2 ** (quarter / 4)))


@lru_cache(maxsize=8)
def fastest(job: Job) -> float:
    """The largest rate of the rod at the start [1/s]."""
    model = rodgen.build(job.scene, target="c")
    jacobian = model.jac(job.span[0], job.start, model.parameters(**job.scene.parameters))
    return float(np.abs(np.linalg.eigvals(jacobian)).max())


def _adaptive(job: Job, asked: float, method: str, share: float) -> Iterator[Contestant]:
    for rtol in tolerances(asked):
        label = f"{method}, rtol {rtol:.1e}, atol {share * rtol:.1e}"
        yield contestant(job, label, method=method, rtol=rtol, atol=share * rtol)


def _fixed(job: Job, method: str) -> Iterator[Contestant]:
    first, last = job.span
    for count in steps(job, FIXED[method][0]):
        yield contestant(
            job, f"{method}, {count} steps", method=method, step=(last - first) / count
        )
