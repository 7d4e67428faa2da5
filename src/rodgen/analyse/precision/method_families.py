"""Contestants: methods of rodgen, and SciPy's on rodgen's rates and exact Jacobian in C."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from math import ceil
from typing import Any

import numpy as np
from scipy.integrate import odeint, solve_ivp

from rodgen.analyse.precision.contestant import (
    COUNTS,
    Contestant,
    Deadline,
    Family,
    NotModelledError,
    RunResult,
)
from rodgen.analyse.precision.job import SAMPLES, Job, Stretch, integrate_stretches
from rodgen.arrays import Array
from rodgen.integrate.simulate import simulate
from rodgen.integrate.stability import LIMITS, dominant, step_limit
from rodgen.loading import build
from rodgen.model.methods import FIXED_STEP, METHODS
from rodgen.result import collect_doubts
from rodgen.scene.integration import LEAST_RTOL

VARIABLE_ORDER = ("bdf", "lsoda", "cvode")  # of which errors follow no single power of the step
HALVINGS = 14  # of a fixed step
NEAR = 0.99  # of the stability limit, where a fixed step begins
# Of a method without a limit, steps by which the fastest motion grows e-fold in the span.
GROWTH = 1.0
ORDERS = {"RK45": 5.0, "DOP853": 8.0, "Radau": 5.0}
EXPLICIT = ("RK45", "DOP853")
LOOSEST, TIGHTEST = 2, 12  # negative powers of ten of a tolerance
SHARE = 0.01  # absolute tolerance over the relative one, as a scene of rodgen has it by default
EVERY = 256  # calls between two looks at the deadline
LARGEST = 600  # links with a dense Jacobian: beyond, a factorisation takes a second


def own_family(job: Job, method: str, target: str, quick: bool) -> Family:
    """Yield settings of one of rodgen's methods."""
    if method in FIXED_STEP:
        for step in step_settings(job, method, quick):
            yield contestant(job, method, target, step=step)
    else:
        for rtol in tolerance_decades(quick):
            yield contestant(job, method, target, rtol=rtol)


def contestant(job: Job, method: str, target: str, **setting: float) -> Contestant:
    """Set up a run with one step [s] or rtol of a method, as a user calls it, with all samples."""
    (kind, value), *_ = setting.items()
    given: dict[str, Any] = {"method": method, **setting}
    if kind == "rtol":
        given["atol"] = SHARE * value
    model = job.model if target == "c" else build(job.scene, target)

    def integrate() -> RunResult:
        with collect_doubts():  # the limit is among what is tried
            run = simulate(job.scene, model=model, progress=lambda _: Deadline.check(), **given)
        found = {name: getattr(run.stats, name) for name in COUNTS}
        counts = {name: value for name, value in found.items() if value is not None}
        return RunResult(run.y, counts, run.stats.wall_seconds, lambda: run.energy_error)

    order = None if method in VARIABLE_ORDER else METHODS[method].order
    return Contestant("rodgen", method, target, kind, value, integrate, order)


def tolerance_decades(quick: bool) -> Iterator[float]:
    """Yield tolerances from 1e-2 to 1e-13, one a decade; quick: every other."""
    for decade in range(2, 14, 2 if quick else 1):
        yield max(10.0**-decade, LEAST_RTOL)


def step_settings(job: Job, method: str, quick: bool) -> Iterator[float]:
    """Yield steps from the stability limit down, each half of the one before (quick: a quarter), so
    that samples fall on steps."""
    first, last = job.span
    count = SAMPLES * max(1, ceil((last - first) / (SAMPLES * NEAR * largest_step(job, method))))
    for halving in range(0, HALVINGS, 2 if quick else 1):
        yield (last - first) / (count * 2**halving)


def largest_step(job: Job, method: str) -> float:
    """Largest step [s] that is worth trying: that of the stability limit."""
    fastest = dominant(job.model, job.span[0], job.initial_state, job.p)
    span = job.span[1] - job.span[0]
    most = step_limit(method, fastest.value, fastest.partner) if method in LIMITS else span
    if most == 0:  # the modulus of 1 + i h omega is 1 + (h omega)^2/2
        most = 2 * GROWTH / (fastest.rate**2 * span)
    return min(most, span / SAMPLES)


def scipy_tolerances(quick: bool) -> Iterator[float]:
    """Yield relative tolerances, two a decade; quick: one a decade."""
    for half in range(2 * LOOSEST, 2 * TIGHTEST + 1, 2 if quick else 1):
        yield 10.0 ** (-half / 2)


class CountedRates:
    """Rates and exact Jacobian of a job in C, with counts of their calls."""

    def __init__(self, job: Job):
        self.model, self.p = job.model, job.p
        self.rates = self.jacobians = 0
        self.stretch = Stretch(*job.span, job.sample_times, 0)

    def reset(self) -> None:
        """Reset the counts."""
        self.rates = self.jacobians = 0

    def rhs(self, t: float, y: Array, out: Array | None = None) -> Array:
        """Evaluate the rates, in a new array or in ``out``."""
        self.rates += 1
        if self.rates % EVERY == 0:
            Deadline.check()
        rates: Array = self.model.rhs(self.stretch.clip(t), y, self.p, out)
        return rates

    def jac(self, t: float, y: Array) -> Array:
        """Evaluate the exact dense Jacobian."""
        self.jacobians += 1
        Deadline.check()
        jacobian: Array = self.model.jac(self.stretch.clip(t), y, self.p)
        return jacobian


def lsoda(job: Job, quick: bool) -> Iterator[Contestant]:
    """Settings of Adams and backward differences in turn, by odeint, which steps outside Python."""
    check_dense_jacobian(job, "SciPy")
    return (_lsoda(job, rtol) for rtol in scipy_tolerances(quick))


def check_dense_jacobian(job: Job, who: str) -> None:
    """Raise NotModelledError for more links than a dense Jacobian can be factorised for in time."""
    if job.scene.rod.links > LARGEST:
        raise NotModelledError(
            f"{who}: a dense Jacobian, which {job.scene.rod.links} links make large"
        )


def _scipy_family(method: str) -> Callable[[Job, bool], Iterator[Contestant]]:
    """Create the function that yields settings of a method of solve_ivp for a job."""

    def family(job: Job, quick: bool) -> Iterator[Contestant]:
        if method not in EXPLICIT:
            check_dense_jacobian(job, "SciPy")
        return (_solve_ivp(job, method, rtol) for rtol in scipy_tolerances(quick))

    return family


# Dormand and Prince of orders 5 and 8, Radau IIA, and backward differences of orders 1 to 5.
rk45, dop853, radau, bdf = map(_scipy_family, ("RK45", "DOP853", "Radau", "BDF"))


def _scipy_contestant(method: str, rtol: float, integrate: Any) -> Contestant:
    return Contestant(
        "SciPy", method, "rodgen's c", "rtol", rtol, integrate, order=ORDERS.get(method)
    )


def _solve_ivp(job: Job, method: str, rtol: float) -> Contestant:
    asked = CountedRates(job)
    # SciPy keeps the arrays that it is given, so there is a new one each time.
    settings = {} if method in EXPLICIT else {"jac": asked.jac}

    def integrate() -> RunResult:
        asked.reset()
        factorised = 0

        def solve_stretch(stretch: Stretch, y: Array) -> Array:
            nonlocal factorised
            asked.stretch = stretch
            span = stretch.first, stretch.last
            tolerance = {"rtol": rtol, "atol": SHARE * rtol}
            with np.errstate(all="ignore"):
                found = solve_ivp(
                    asked.rhs, span, y, method, stretch.times, **tolerance, **settings
                )
            if not found.success:
                raise ArithmeticError(found.message)
            factorised += found.nlu
            states: Array = found.y.T
            return states

        y = integrate_stretches(job, solve_stretch)
        counts = {"nfev": asked.rates, "njev": asked.jacobians, "nlu": factorised}
        return RunResult(y, counts)

    return _scipy_contestant(method, rtol, integrate)


def _lsoda(job: Job, rtol: float) -> Contestant:
    asked, rates = CountedRates(job), np.empty_like(job.initial_state)
    settings = {"tfirst": True, "mxstep": 10**8, "rtol": rtol, "atol": SHARE * rtol}

    def rhs(t: float, y: Array) -> Array:
        return asked.rhs(t, y, rates)

    def integrate() -> RunResult:
        asked.reset()
        steps = 0

        def solve_stretch(stretch: Stretch, y: Array) -> Array:
            nonlocal steps
            asked.stretch = stretch
            times, stop = np.array([stretch.first, *stretch.times]), [stretch.last]
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # odeint tells a failure by a warning
                y, said = odeint(
                    rhs, y, times, Dfun=asked.jac, tcrit=stop, full_output=True, **settings
                )
            steps += int(said["nst"][-1])
            return y[1:]

        y = integrate_stretches(job, solve_stretch)
        return RunResult(y, {"nsteps": steps, "nfev": asked.rates, "njev": asked.jacobians})

    return _scipy_contestant("LSODA", rtol, integrate)
