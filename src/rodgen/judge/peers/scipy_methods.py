"""SciPy's methods on rodgen's right-hand side and exact Jacobian in C."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.integrate import odeint, solve_ivp

from rodgen.judge.peers.asked import Asked
from rodgen.judge.peers.settings import SHARE, tolerances
from rodgen.judge.peers.stretches import Stretch, integrated
from rodgen.judge.precision.contestant import Array, Contestant, Finish, NotModelledError
from rodgen.judge.precision.job import Job

ORDERS = {"RK45": 5.0, "DOP853": 8.0, "Radau": 5.0}
EXPLICIT = ("RK45", "DOP853")
LARGEST = 600  # links with a dense Jacobian: beyond, a factorisation takes a second


def rk45(job: Job, quick: bool) -> Iterator[Contestant]:
    """Dormand and Prince of order 5."""
    return _family(job, "RK45", quick)


def dop853(job: Job, quick: bool) -> Iterator[Contestant]:
    """Dormand and Prince of order 8."""
    return _family(job, "DOP853", quick)


def radau(job: Job, quick: bool) -> Iterator[Contestant]:
    """Radau IIA of order 5."""
    return _family(job, "Radau", quick)


def bdf(job: Job, quick: bool) -> Iterator[Contestant]:
    """Backward differences of orders 1 to 5."""
    return _family(job, "BDF", quick)


def lsoda(job: Job, quick: bool) -> Iterator[Contestant]:
    """Adams and backward differences in turn, by odeint, which steps outside Python."""
    check(job, "SciPy")
    return (_lsoda(job, rtol) for rtol in tolerances(quick))


def check(job: Job, who: str) -> None:
    """Raise NotModelledError for more links than a dense Jacobian can be factorised for in time."""
    if job.scene.rod.links > LARGEST:
        raise NotModelledError(
            f"{who}: a dense Jacobian, which {job.scene.rod.links} links make large"
        )


def _family(job: Job, method: str, quick: bool) -> Iterator[Contestant]:
    if method not in EXPLICIT:
        check(job, "SciPy")
    return (_solve_ivp(job, method, rtol) for rtol in tolerances(quick))


def _contestant(method: str, rtol: float, integrate: Any) -> Contestant:
    return Contestant(
        "SciPy", method, "rodgen's c", "rtol", rtol, integrate, order=ORDERS.get(method)
    )


def _solve_ivp(job: Job, method: str, rtol: float) -> Contestant:
    asked = Asked(job)
    # SciPy keeps the arrays that it is given, so there is a new one each time.
    settings = {} if method in EXPLICIT else {"jac": asked.jac}

    def integrate() -> Finish:
        asked.begin()
        factorised = 0

        def over(stretch: Stretch, y: Array) -> Array:
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

        y = integrated(job, over)
        counts = {"rhs": asked.rates, "jacobian": asked.jacobians, "factorisations": factorised}
        return Finish(y, counts)

    return _contestant(method, rtol, integrate)


def _lsoda(job: Job, rtol: float) -> Contestant:
    asked, rates = Asked(job), np.empty_like(job.start)
    settings = {"tfirst": True, "mxstep": 10**8, "rtol": rtol, "atol": SHARE * rtol}

    def rhs(t: float, y: Array) -> Array:
        return asked.rhs(t, y, rates)

    def integrate() -> Finish:
        asked.begin()
        steps = 0

        def over(stretch: Stretch, y: Array) -> Array:
            nonlocal steps
            asked.stretch = stretch
            times, stop = np.array([stretch.first, *stretch.times]), [stretch.last]
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # that it failed is told by a warning
                y, said = odeint(
                    rhs, y, times, Dfun=asked.jac, tcrit=stop, full_output=True, **settings
                )
            steps += int(said["nst"][-1])
            return y[1:]

        y = integrated(job, over)
        return Finish(y, {"steps": steps, "rhs": asked.rates, "jacobian": asked.jacobians})

    return _contestant("LSODA", rtol, integrate)
