"""rodgen's own methods as contestants."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import ceil
from typing import Any

import rodgen
from rodgen.integrate.spectrum import spectrum
from rodgen.integrate.stability import LIMITS, limit
from rodgen.judge.precision.contestant import Contestant, Deadline, Family, Finish
from rodgen.judge.precision.job import SAMPLES, Job
from rodgen.scene.tables import ADAPTIVE, FIXED_STEP, LEAST_RTOL

ORDERS: dict[str, float] = {
    "euler": 1,
    "semi_implicit_euler": 1,
    "rk4": 4,
    "thesis_runge_kutta": 1,
    "dop853": 8,
    "gauss": 6,
    "radau": 5,
    "rk23": 3,
    "rk45": 5,
}
NUMPY = ("rk4", "dop853", "gauss", "radau")  # in Python: some of each kind
MOST_LINKS = 50  # up to which they are run in Python
ATOL = 0.01  # absolute tolerance over the relative one: angles of this size count as large
HALVINGS = 14  # of a fixed step
NEAR = 0.99  # of the stability limit, where a fixed step begins
# Of a method without a limit, steps by which the fastest motion grows e-fold in the span.
GROWTH = 1.0


@dataclass(frozen=True)
class Named:
    """A family before anything of it is run."""

    who: str
    method: str
    target: str
    make: Callable[[], Family]
    setup: dict[str, float] = field(default_factory=dict)


def families(job: Job, quick: bool, setup: dict[str, float]) -> list[Named]:
    """All methods with the C target, some in Python; setup: seconds by target and kind."""
    warnings.simplefilter("ignore", rodgen.StepWarning)  # the limit is among what is tried
    found = [(method, "c") for method in (*FIXED_STEP, *ADAPTIVE)]
    if job.scene.rod.links <= MOST_LINKS:
        found += [(method, "numpy") for method in NUMPY]
    return [_named(job, method, target, quick, setup) for method, target in found]


def _named(job: Job, method: str, target: str, quick: bool, setup: dict[str, float]) -> Named:
    taken = {k.split("_", 1)[1]: v for k, v in setup.items() if k.startswith(f"{target}_")}
    fixed = method in FIXED_STEP

    def make() -> Family:
        if fixed:
            return (contestant(job, method, target, step=h) for h in steps(job, method, quick))
        return (contestant(job, method, target, rtol=rtol) for rtol in tolerances(quick))

    return Named("rodgen", method, target, make, taken)


def contestant(job: Job, method: str, target: str, **setting: float) -> Contestant:
    """One step [s] or rtol of a method, as a user calls it, with all samples of the job."""
    (kind, value), *_ = setting.items()
    given: dict[str, Any] = {"method": method, **setting}
    if kind == "rtol":
        given["atol"] = ATOL * value
    model = job.model if target == "c" else rodgen.build(job.scene, target)

    def integrate() -> Finish:
        run = rodgen.simulate(job.scene, model=model, progress=lambda _: Deadline.look(), **given)
        names = ("steps", "rejected", "rhs", "jacobian", "factorisations")
        counts = {k: getattr(run.stats, k) for k in names if getattr(run.stats, k) is not None}
        return Finish(run.y, counts, run.stats.wall_seconds, lambda: run.energy_error)

    return Contestant("rodgen", method, target, kind, value, integrate, ORDERS.get(method))


def tolerances(quick: bool) -> Iterator[float]:
    """From 1e-2 to 1e-13, one a decade; quick: every other."""
    for decade in range(2, 14, 2 if quick else 1):
        yield max(10.0**-decade, LEAST_RTOL)


def steps(job: Job, method: str, quick: bool) -> Iterator[float]:
    """From the stability limit down, each half of the one before (quick: a quarter), so that
    samples fall on steps."""
    first, last = job.span
    count = SAMPLES * max(1, ceil((last - first) / (SAMPLES * NEAR * longest(job, method))))
    for halving in range(0, HALVINGS, 2 if quick else 1):
        yield (last - first) / (count * 2**halving)


def longest(job: Job, method: str) -> float:
    """The largest step [s] that is worth trying: that of the stability limit."""
    fastest = spectrum(job.model, job.span[0], job.start, job.p)
    span = job.span[1] - job.span[0]
    most = limit(method, fastest.value, fastest.partner) if method in LIMITS else span
    if most == 0:  # the modulus of 1 + i h omega is 1 + (h omega)^2/2
        most = 2 * GROWTH / (fastest.rate**2 * span)
    return min(most, span / SAMPLES)
