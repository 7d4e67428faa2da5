"""CVODE's Adams methods of variable order (A. C. Hindmarsh et al. 2005), by scikit-sundae."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from rodgen.integrate.stepper import Array, Counts, Interpolant, Rhs, StepError
from rodgen.scene import SceneError

PACKAGE = "sksundae.cvode"


class CvodeStep:
    """The method between two break points (see stepper.Stepper), with the exact Jacobian."""

    def __init__(
        self,
        rhs: Rhs,
        jac: Rhs,
        t: float,
        y: Array,
        end: float,
        rtol: float,
        atol: float,
        longest: float = np.inf,
    ):
        try:
            solver = import_module(PACKAGE).CVODE
        except ImportError as error:
            allowed = f'another, or pip install "rodgen[cvode]" ({error})'
            raise SceneError("integrate.method", "cvode", allowed) from None

        self.counts = Counts()

        def rates(at: float, state: Array, out: Array) -> None:
            self.counts.rhs += 1
            out[:] = rhs(at, np.array(state))

        def matrix(at: float, state: Array, _: Array, out: Any) -> None:
            self.counts.jacobian += 1
            out[:] = jac(at, np.array(state))

        self._solver = solver(
            rates,
            method="Adams",
            jacfn=matrix,
            rtol=rtol,
            atol=atol,
            linsolver="dense",
            max_step=longest if longest < np.inf else 0.0,
        )
        self._end = end
        self._solver.init_step(t, y)
        self.t, self.y = t, np.array(y)

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        found = self._solver.step(self._end, method="onestep", tstop=self._end)
        if found.success and float(found.t) == self.t:  # where it was, after an interpolation
            found = self._solver.step(self._end, method="onestep", tstop=self._end)
        if not found.success:
            raise StepError(f"the method gave up ({str(found.message).rstrip('.').lower()})")
        self.counts.steps += 1
        self.t, self.y = float(found.t), np.array(found.y)
        if abs(self._end - self.t) <= 4 * np.spacing(abs(self._end)):
            self.t = self._end
        return self.t >= self._end

    def interpolant(self) -> Interpolant:
        """CVODE's own, of the order of the step."""

        def at(times: Array) -> Array:
            return np.stack([np.array(self._solver.step(time).y) for time in times])

        return at
