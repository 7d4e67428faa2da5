"""Implicit steps, whole jobs and analyses."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from functools import partial
from types import ModuleType

import numpy as np
from scipy.integrate import Radau

import rodgen
from rodgen.integrate.spectrum import spectrum
from rodgen.judge.costs.rod import (
    DAMPED,
    THRUST,
    VALUES,
    Array,
    built,
    compared,
    packed,
    row,
    scene,
    why,
)
from rodgen.judge.timing import Batch, calls
from rodgen.judge.unit import Row

STEPS = 1000  # of a job, by rk4
OF_LIMIT = 0.5  # of the largest stable step
TIMES, QUICK_TIMES = 3, 1  # a job is run
TAKEN, SCIPY_TAKEN = 30, 8  # implicit steps at a time
MOST_SCIPY, MOST_DENSE_JOB = 200, 100  # links
SPAN = 10.0  # s, that the implicit methods could go
TOLERANCES = {"rtol": 1e-6, "atol": 1e-8}


def implicit_steps(links: int, quick: bool) -> list[Row]:
    """One accepted step with all its iterations, evaluations and factorisations, of a strongly
    damped rod from its start on; SciPy's with dense matrices."""
    try:
        module = built(links, DAMPED)
    except Exception as error:  # of a compiler, say
        return [row("implicit step", "rodgen C", links, failed=why(error))]
    y, p = scene(links, VALUES["internal_damping"]).initial_state(), packed(module)
    made: dict[str, Callable[[], Batch]] = {
        f"rodgen C, {method}": partial(_ours, module, method, y, p) for method in ("gauss", "radau")
    }
    if links <= MOST_SCIPY:
        made["SciPy Radau on rodgen C"] = partial(_scipy, module, y, p)
    return compared("implicit step", links, made, quick)


def _ours(module: ModuleType, method: str, y: Array, p: Array) -> Batch:
    nothing = np.empty(0), np.empty((0, len(y) + len(module.WORKS)))

    def once() -> float:
        run = module.Run(method, 0.0, y, p, **TOLERANCES)
        run.begin(SPAN)
        start = time.perf_counter()
        status, _ = run.on(TAKEN, *nothing)
        taken = time.perf_counter() - start
        if status < 0:
            raise ArithmeticError(f"{method} ends with status {status}")
        return taken / int(run.numbers.steps)

    return lambda number: sum(once() for _ in range(number))


def _scipy(module: ModuleType, y: Array, p: Array) -> Batch:
    def once() -> float:
        solver = Radau(
            lambda t, at: module.rhs(t, at, p),
            *(0.0, y, SPAN),
            jac=lambda t, at: module.jac(t, at, p),
            **TOLERANCES,
        )
        start = time.perf_counter()
        for _ in range(SCIPY_TAKEN):
            solver.step()
        return (time.perf_counter() - start) / SCIPY_TAKEN

    return lambda number: sum(once() for _ in range(number))


def jobs(links: int, module: ModuleType, quick: bool) -> list[Row]:
    """STEPS steps of rk4 by rodgen.simulate, with the samples at both ends."""
    made = {"rodgen C": module}
    if not quick:
        made["rodgen NumPy"] = built(links, THRUST, "numpy")
    if links <= MOST_DENSE_JOB and not quick:
        made["rodgen NumPy, dense"] = built(links, THRUST, "numpy", "dense")
    free = scene(links)
    p = module.parameters(**free.parameters)
    rate = spectrum(module, 0.0, free.initial_state(), p).rate
    step = OF_LIMIT * np.sqrt(8) / rate
    span = float(step * STEPS)
    job = scene(links, method="rk4", step=float(step), span=[0.0, span], output_every=span)
    return [_job(links, who, one, job, quick) for who, one in made.items()]


def _job(links: int, who: str, module: ModuleType, job: rodgen.Scene, quick: bool) -> Row:
    what, times = f"job: {STEPS} steps of rk4", TIMES
    if quick or who != "rodgen C":
        times = QUICK_TIMES
    return _whole(what, who, links, lambda: rodgen.simulate(job, model=module), times)


def analyses(links: int, quick: bool) -> list[Row]:
    """Critical thrust and natural modes; set-up is done before."""
    free, times = scene(links), QUICK_TIMES if quick else TIMES
    made: dict[str, Callable[[], object]] = {
        "critical force": lambda: rodgen.critical_force(free),
        "ten natural modes": lambda: rodgen.natural_modes(free, 10),
    }
    rows = []
    for what, call in made.items():
        first = _whole(what, "rodgen", links, call, 1)
        again = first if first["failed"] else _whole(what, "rodgen", links, call, times)
        rows.append(again)
    return rows


def _whole(what: str, who: str, links: int, call: Callable[[], object], times: int) -> Row:
    """A median of some calls that are long."""
    try:
        seconds = statistics.median(calls(call)(1) for _ in range(times))
    except Exception as error:  # what fails is a row, and ends no other
        return row(what, who, links, failed=why(error))
    return row(what, who, links, seconds, rounds=times)
