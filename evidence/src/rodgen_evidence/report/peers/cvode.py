"""CVODE of SUNDIALS, by scikit-sundae, on rodgen's right-hand side in C.

Newton's iteration with the exact Jacobian, dense, which measures faster than GMRES for Adams too;
scikit-sundae has no fixed-point iteration, and the Jacobian of a rod has no band: the joint forces
tie every link to all others.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from sksundae.cvode import CVODE

from rodgen.analyse.precision.job import Stretch
from rodgen.analyse.precision.method_families import LARGEST, SHARE, CountedRates, scipy_tolerances
from rodgen.arrays import Array
from rodgen_evidence.report.peers.peer import Over, Peer

MOST = 2**31 - 1  # steps between two samples


class CvodeRod(Peer):
    """Adams methods of orders 1 to 12, or backward differences of orders 1 to 5."""

    who, target = "CVODE", "rodgen's c"
    most, why = LARGEST, "a dense Jacobian is too large"

    def settings(self, quick: bool) -> Iterator[float]:
        """Relative tolerances."""
        return scipy_tolerances(quick)

    def integrator(self, setting: float) -> Over:
        """Create a solver that begins anew in every stretch."""
        asked = CountedRates(self.job)

        def rhs(t: float, y: Array, out: Array) -> None:
            self.counts["nfev"] += 1
            asked.rhs(t, y, out)

        def jac(t: float, y: Array, _: Array, out: Array) -> None:
            self.counts["njev"] += 1
            out[:] = asked.jac(t, y)

        def over(stretch: Stretch, y: Array) -> Array:
            asked.stretch = stretch
            tolerance = {"rtol": setting, "atol": SHARE * setting, "max_num_steps": MOST}
            how = {"method": self.method, "jacfn": jac, "linsolver": "dense"}
            solver = CVODE(rhs, **how, **tolerance)
            solver.init_step(stretch.first, y)
            rows = []
            for at in stretch.times:
                found = solver.step(at, tstop=stretch.last)
                if not found.success:
                    raise ArithmeticError(found.message)
                rows.append(np.array(np.ravel(found.y)))
            return np.array(rows)

        return over
