"""SciPy's methods on rodgen's right-hand side and exact Jacobian in C."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np
from integrate_jobs import Job
from our_runs import tolerances
from problem import Vector
from scipy.integrate import odeint, solve_ivp
from work_precision import Contestant, Deadline, Finish

import rodgen

EDGE = 1e-12  # by which a time is held inside a stretch: at its ends loads may jump


class Rod:
    """The rod of a job in C, and how often it was asked."""

    def __init__(self, job: Job):
        self.model = rodgen.build(job.scene, target="c")
        self.p = self.model.parameters(**job.scene.parameters)
        self.calls = 0
        self.low, self.high = job.span

    def enter(self, first: float, last: float) -> None:
        """Start a stretch without a kink."""
        self.low, self.high = first + EDGE, last - EDGE

    def rhs(self, t: float, y: Vector, out: Vector | None = None) -> Vector:
        """New rates each time, or in an array that is given."""
        self.calls += 1
        if self.calls % 1024 == 0:
            Deadline.look()
        at = min(max(t, self.low), self.high)
        rates: Vector = self.model.rhs(at, y, self.p, out)
        return rates

    def jac(self, t: float, y: Vector) -> Vector:
        """The exact Jacobian."""
        jacobian: Vector = self.model.jac(min(max(t, self.low), self.high), y, self.p)
        return jacobian

    def begin(self) -> None:
        """Count from here."""
        self.calls = 0


def dop853(job: Job, asked: float, share: float) -> Iterator[Contestant]:
    """Dormand and Prince of order 8: SciPy keeps the arrays that it is given, so no `out`."""
    return (with_solve_ivp(job, "DOP853", rtol, share * rtol) for rtol in tolerances(asked))


def radau(job: Job, asked: float, share: float) -> Iterator[Contestant]:
    """Radau IIA of order 5."""
    return (with_solve_ivp(job, "Radau", rtol, share * rtol) for rtol in tolerances(asked))


def bdf(job: Job, asked: float, share: float) -> Iterator[Contestant]:
    """Backward differences."""
    return (with_solve_ivp(job, "BDF", rtol, share * rtol) for rtol in tolerances(asked))


def lsoda(job: Job, asked: float, share: float) -> Iterator[Contestant]:
    """Adams and backward differences in turn, by odeint, which steps outside Python."""
    return (_lsoda(job, rtol, share * rtol) for rtol in tolerances(asked))


def with_solve_ivp(job: Job, method: str, rtol: float, atol: float) -> Contestant:
    rod = Rod(job)
    settings = {} if method == "DOP853" else {"jac": rod.jac}

    def integrate() -> Finish:
        rod.begin()
        y = job.start
        for first, last in job.stretches:
            rod.enter(first, last)
            settings["t_eval"] = [last]
            found = solve_ivp(rod.rhs, (first, last), y, method, rtol=rtol, atol=atol, **settings)
            if not found.success:
                raise ArithmeticError(found.message)
            y = found.y[:, -1]
        return Finish(y, f"{rod.calls} rhs")

    return Contestant(f"SciPy {method}, rtol {rtol:.1e}, atol {atol:.1e}", integrate)


def _lsoda(job: Job, rtol: float, atol: float) -> Contestant:
    rod, rates = Rod(job), np.empty_like(job.start)
    settings = {"Dfun": rod.jac, "tfirst": True, "mxstep": 10**8, "rtol": rtol, "atol": atol}

    def rhs(t: float, y: Vector) -> Vector:
        return rod.rhs(t, y, rates)

    def integrate() -> Finish:
        rod.begin()
        y = job.start
        for first, last in job.stretches:
            rod.enter(first, last)
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # that it failed is told by a warning
                y = odeint(rhs, y, (first, last), tcrit=[last], **settings)[-1]
        return Finish(y, f"{rod.calls} rhs")

    return Contestant(f"SciPy LSODA, rtol {rtol:.1e}, atol {atol:.1e}", integrate)
