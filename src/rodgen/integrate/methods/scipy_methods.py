"""SciPy's methods with error control, step by step."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from scipy.integrate import BDF, DOP853, LSODA, RK23, RK45, OdeSolver, Radau

from rodgen.integrate.stepper import Array, Counts, Interpolant, Rhs, StepError

METHODS: dict[str, type[OdeSolver]] = {
    "rk23": RK23,
    "rk45": RK45,
    "dop853": DOP853,
    "radau": Radau,
    "bdf": BDF,
    "lsoda": LSODA,
}
RUNGE_KUTTA = ("rk23", "rk45", "dop853")  # explicit: every try costs as many evaluations
IMPLICIT = ("radau", "bdf", "lsoda")  # these are given the exact Jacobian
LOOKS = 500  # steps between two looks at the stability limit, which cost as much as 30
PATIENCE = 1000  # evaluations in a row that are not finite, before a method is stopped


class ScipyStep:
    """A SciPy method between two break points (see stepper.Stepper).

    longest: the longest step [s] at (t, y); of an explicit method, at most the largest stable
    one. Error control alone lets the fastest motions grow up to the tolerance, and at loose
    tolerances of smooth motions some steps beyond it, unnoticed.
    """

    def __init__(
        self,
        name: str,
        rhs: Rhs,
        jac: Rhs,
        t: float,
        y: Array,
        end: float,
        rtol: float,
        atol: float,
        longest: Callable[[float, Array], float] = lambda t, y: np.inf,
    ):
        self._rhs, self._broken, self._broken_in_a_row = rhs, False, 0
        # Evaluations of one try, where the method is of Runge-Kutta type.
        self._stages: int | None = METHODS[name].n_stages if name in RUNGE_KUTTA else None
        self._rejected = 0
        self._steps = 0
        self.t, self.y = t, y
        self._watched(t, y)
        if self._broken:  # SciPy would look for a first step for ever
            raise self._failure("")
        # A first step into infinity is judged by the run, not by a warning.
        self._longest = longest
        exact = {"jac": jac} if name in IMPLICIT else {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._solver = METHODS[name](
                self._watched, t, y, end, max_step=longest(t, y), rtol=rtol, atol=atol, **exact
            )

    def _watched(self, t: float, y: Array) -> Array:
        rate = self._rhs(t, y)
        if np.isfinite(rate).all():
            self._broken_in_a_row = 0
            return rate
        self._broken = True
        self._broken_in_a_row += 1
        if self._broken_in_a_row > PATIENCE:
            raise self._failure("")
        return rate

    @property
    def counts(self) -> Counts:
        solver = self._solver
        rejected = self._rejected if self._stages else None
        return Counts(self._steps, rejected, solver.nfev, solver.njev, solver.nlu)

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        solver, before = self._solver, self._solver.nfev
        self._broken = False
        if self._stages and self._steps and self._steps % LOOKS == 0:
            solver.max_step = self._longest(self.t, self.y)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                message = solver.step()
        except (ValueError, np.linalg.LinAlgError) as error:
            raise self._failure(str(error)) from error
        if solver.status == "failed":
            raise self._failure(message)
        self._steps += 1
        if self._stages:
            self._rejected += (solver.nfev - before) // self._stages - 1
        self.t, self.y = float(solver.t), solver.y
        return bool(solver.status == "finished")

    def _failure(self, message: str) -> StepError:
        if self._broken:
            return StepError("the rates stop being finite")
        reason = (message or "no reason given").rstrip(".").lower()
        return StepError(f"the method gave up ({reason})")

    def interpolant(self) -> Interpolant:
        """Dense output of the last step."""
        dense = self._solver.dense_output()
        return lambda times: dense(times).T
