"""CVODE of SUNDIALS, by scikit-sundae, on rodgen's right-hand side in C.

Newton's iteration with the exact Jacobian, dense, which measures faster than GMRES for Adams too;
scikit-sundae has no fixed-point iteration, and the Jacobian of a rod has no band: the joint forces
tie every link to all others.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from sksundae.cvode import CVODE

from rodgen.judge.peers.asked import Asked
from rodgen.judge.peers.scipy_methods import check
from rodgen.judge.peers.settings import SHARE, tolerances
from rodgen.judge.peers.stretches import Stretch, integrated
from rodgen.judge.precision.contestant import Array, Contestant, Finish
from rodgen.judge.precision.job import Job

MOST = 2**31 - 1  # steps between two samples


def adams(job: Job, quick: bool) -> Iterator[Contestant]:
    """Adams methods of orders 1 to 12."""
    return _family(job, "Adams", quick)


def bdf(job: Job, quick: bool) -> Iterator[Contestant]:
    """Backward differences of orders 1 to 5."""
    return _family(job, "BDF", quick)


def _family(job: Job, method: str, quick: bool) -> Iterator[Contestant]:
    check(job, "CVODE")
    return (_contestant(job, method, rtol) for rtol in tolerances(quick))


def _contestant(job: Job, method: str, rtol: float) -> Contestant:
    asked = Asked(job)

    def rhs(t: float, y: Array, out: Array) -> None:
        asked.rhs(t, y, out)

    def jac(t: float, y: Array, _: Array, out: Array) -> None:
        out[:] = asked.jac(t, y)

    def over(stretch: Stretch, y: Array) -> Array:
        asked.stretch = stretch
        tolerance = {"rtol": rtol, "atol": SHARE * rtol, "max_num_steps": MOST}
        solver = CVODE(rhs, method=method, jacfn=jac, linsolver="dense", **tolerance)
        solver.init_step(stretch.first, y)
        rows = []
        for at in stretch.times:
            found = solver.step(at, tstop=stretch.last)
            if not found.success:
                raise ArithmeticError(found.message)
            rows.append(np.array(np.ravel(found.y)))
        return np.array(rows)

    def integrate() -> Finish:
        asked.begin()
        y = integrated(job, over)
        return Finish(y, {"rhs": asked.rates, "jacobian": asked.jacobians})

    return Contestant("CVODE", method, "rodgen's c", "rtol", rtol, integrate)
