"""CasADi's integrators on its own expressions of the scene, with its own exact Jacobian.

Every one is a single call from the start of a stretch to its end.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import casadi as ca
import numpy as np

from rodgen.judge.peers import loads
from rodgen.judge.peers.agreement import agreed
from rodgen.judge.peers.deadline import stopped
from rodgen.judge.peers.settings import SHARE, steps, tolerances
from rodgen.judge.peers.stretches import Stretch, integrated, stretches
from rodgen.judge.peers.symbolic import KNOWN, equations, evaluated
from rodgen.judge.precision.contestant import Array, Contestant, Finish, NotModelledError
from rodgen.judge.precision.job import SAMPLES, Job

LARGEST = {"cvodes": 100, "idas": 100, "collocation": 20}  # links that it is set up for in seconds
ADAMS = {"linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional"}
MOST = 2**31 - 1  # steps between two samples
DEGREE = 3  # of collocation by Radau's points, of order 5
COUNTS = {
    "steps": "nsteps",
    "rejected": "netfails",
    "rhs": "nfevals",
    "factorisations": "nlinsetups",
}


def cvodes_bdf(job: Job, quick: bool) -> Iterator[Contestant]:
    """Backward differences of orders 1 to 5, Newton's iteration."""
    return _adaptive(job, "CVODES BDF", "cvodes", {}, quick)


def cvodes_adams(job: Job, quick: bool) -> Iterator[Contestant]:
    """Adams methods of orders 1 to 12, fixed-point iteration."""
    return _adaptive(job, "CVODES Adams", "cvodes", ADAMS, quick)


def idas(job: Job, quick: bool) -> Iterator[Contestant]:
    """Backward differences for implicit equations."""
    return _adaptive(job, "IDAS", "idas", {}, quick)


def collocation(job: Job, quick: bool) -> Iterator[Contestant]:
    """Radau's points, of order 5, in elements of one length; in an element at least a sample."""
    first, last = job.span
    check(job, LARGEST["collocation"])
    lengths = steps(job, (last - first) / SAMPLES, quick)
    plans = ((length, _elements(job, length)) for length in lengths)
    return _family(job, "collocation, Radau 5", "collocation", "step", 5.0, plans)


def check(job: Job, most: int) -> None:
    """Raise NotModelledError for what cannot be had in time."""
    loads.refuse("CasADi", job.scene, KNOWN)
    if job.scene.rod.links > most:
        raise NotModelledError(
            f"CasADi: unrolled expressions, too large for more than {most} links"
        )


def _adaptive(
    job: Job, method: str, plugin: str, options: dict[str, Any], quick: bool
) -> Iterator[Contestant]:
    check(job, LARGEST[plugin])
    plans = ((rtol, _tolerance(job, rtol, options)) for rtol in tolerances(quick))
    return _family(job, method, plugin, "rtol", None, plans)


def _tolerance(job: Job, rtol: float, options: dict[str, Any]) -> list[dict[str, Any]]:
    settings = {"reltol": rtol, "abstol": SHARE * rtol, "max_num_steps": MOST}
    return [options | settings] * len(stretches(job))


def _elements(job: Job, length: float) -> list[dict[str, Any]]:
    fixed = {"interpolation_order": DEGREE, "collocation_scheme": "radau"}
    return [
        {"number_of_finite_elements": round((one.last - one.first) / length) or 1, **fixed}
        for one in stretches(job)
    ]


def _family(
    job: Job,
    method: str,
    plugin: str,
    kind: str,
    order: float | None,
    plans: Iterator[tuple[float, list[dict[str, Any]]]],
) -> Iterator[Contestant]:
    begin = time.perf_counter()
    made = {one.first: equations(job.scene, one.middle) for one in stretches(job)}
    written = time.perf_counter() - begin
    middles = {one.middle: made[one.first] for one in stretches(job)}
    off = agreed(job, lambda t, y: evaluated(middles[t], t, y))

    def contestant(setting: float, options: list[dict[str, Any]]) -> Contestant:
        begin = time.perf_counter()
        solvers = {
            one.first: ca.integrator("solver", plugin, made[one.first], one.first, one.times, said)
            for one, said in zip(stretches(job), options, strict=True)
        }
        setup = {"generate": written + time.perf_counter() - begin}
        return Contestant(
            "CasADi",
            method,
            "CasADi",
            kind,
            setting,
            lambda: _integrate(job, solvers),
            order=order,
            setup=setup,
            agreed=off,
        )

    return (contestant(setting, options) for setting, options in plans)


def _integrate(job: Job, solvers: dict[float, Any]) -> Finish:
    counts: dict[str, int] = {}

    def over(stretch: Stretch, y: Array) -> Array:
        solver = solvers[stretch.first]
        with stopped():
            states: Array = solver(x0=y)["xf"].full().T
        said = solver.stats()
        for name, known in COUNTS.items():
            if known in said:
                counts[name] = counts.get(name, 0) + int(said[known])
        return states

    y = integrated(job, over)
    if not np.isfinite(y).all():
        raise ArithmeticError("states that are no numbers")
    return Finish(y, counts)
