"""CVODE of SUNDIALS, by scikit-sundae, on rodgen's right-hand side in C.

Newton's iteration with the exact Jacobian, dense, which measures faster than GMRES for Adams too;
scikit-sundae has no fixed-point iteration, and the Jacobian of a rod has no band: the joint forces
tie every link to all others.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from integrate_jobs import Job
from our_runs import tolerances
from problem import Vector
from sksundae.cvode import CVODE
from work_precision import Contestant, Finish

from peers.runs.scipy_methods import Rod

LEAST = 1e-13  # relative tolerance, below which CVODE gives up


def adams(job: Job, asked: float, share: float) -> Iterator[Contestant]:
    """Orders 1 to 12."""
    return (contestant(job, "Adams", r, share * r) for r in tolerances(asked) if r > LEAST)


def bdf(job: Job, asked: float, share: float) -> Iterator[Contestant]:
    """Orders 1 to 5."""
    return (contestant(job, "BDF", r, share * r) for r in tolerances(asked) if r > LEAST)


def contestant(job: Job, method: str, rtol: float, atol: float) -> Contestant:
    """One setting."""
    rod = Rod(job)

    def rhs(t: float, y: Vector, out: Vector) -> None:
        rod.rhs(t, y, out)

    def jac(t: float, y: Vector, _: Vector, out: Vector) -> None:
        out[:] = rod.jac(t, y)

    def integrate() -> Finish:
        rod.begin()
        y = job.start
        for first, last in job.stretches:
            rod.enter(first, last)
            settings = {"rtol": rtol, "atol": atol, "jacfn": jac, "linsolver": "dense"}
            solver = CVODE(rhs, method=method, max_num_steps=10**8, **settings)
            solver.init_step(first, y)
            found = solver.step(last, tstop=last)
            if not found.success:
                raise ArithmeticError(found.message)
            y = np.ravel(found.y)
        return Finish(y, f"{rod.calls} rhs")

    return Contestant(f"CVODE {method}, rtol {rtol:.1e}, atol {atol:.1e}", integrate)
