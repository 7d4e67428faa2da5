"""Steppers in Python: of fixed step, where the last one is shortened to meet the end; SciPy's
methods with error control; and CVODE's.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import scipy

from rodgen.arrays import Array
from rodgen.errors import InputError, install_command
from rodgen.integrate.stepper import (
    Counts,
    InitialValueProblem,
    Interpolant,
    Rhs,
    StepError,
    hermite,
)
from rodgen.model.methods import HALVED, LARGEST_LAST, METHODS, MOST_PARTS, TABLEAUX, Tableau

Advance = Callable[[Rhs, float, Array, Array, float], Array]

LOOKS = 500  # steps between two looks at the stability limit, which cost as much as 30
PATIENCE = 1000  # evaluations in a row that are not finite, before a method is stopped
PACKAGE = "sksundae.cvode"


def explicit_step(
    tableau: Tableau, number: Callable[[Any], Any] = float, added: int = 0
) -> Advance:
    """Make the step of an explicit method: new state from rhs, t, y, the rate at (t, y) and h.

    number: converts the weights; states may be of symbols where it makes such; added: how many of
    the states are neither positions nor velocities.
    """
    rows = [[(at, number(w)) for at, w in enumerate(row) if w] for row in tableau.rows]
    times = [number(c) for c in tableau.c]

    def combine(y: Array, h: float, row: list[tuple[int, Any]], rates: list[Array]) -> Array:
        new: Array = y + h * sum(weight * rates[at] for at, weight in row)
        if tableau.follow:
            half = (len(y) - added) // 2
            new[:half] = y[:half] + h * new[half : 2 * half]
        return new

    def step(rhs: Rhs, t: float, y: Array, f: Array, h: float) -> Array:
        rates = [f]
        for c, row in zip(times[1:], rows, strict=False):
            rates.append(rhs(t + c * h, combine(y, h, row, rates)))
        return combine(y, h, rows[-1], rates)

    return step


class FixedStep:
    """Stepper of a method of fixed step between two break points (see stepper.Stepper)."""

    def __init__(self, problem: InitialValueProblem):
        t, y, end, step = problem.t, problem.y, problem.end, problem.settings.step
        assert step is not None
        tableau = TABLEAUX[problem.settings.method]
        self._advance, self._step = explicit_step(tableau, added=problem.added), step
        self.counts = Counts(rejected=0)

        def rhs(at: float, state: Array) -> Array:
            self.counts.nfev += 1
            return problem.rhs(at, state)

        self._rhs = rhs
        self._start, self._end = t, end
        # A step that would be shorter than a millionth of the others is not taken.
        self._total = max(1, math.ceil((end - t) / step - 1e-6))
        self.t, self.y = t, y
        self._f = rhs(t, y)

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        self.counts.nsteps += 1
        last = self.counts.nsteps >= self._total
        t = self._end if last else self._start + self.counts.nsteps * self._step
        y = self._advance(self._rhs, self.t, self.y, self._f, t - self.t)
        f = self._rhs(t, y)
        if not np.isfinite(f).all():
            raise StepError("the rates stop being finite in the step after this time")
        self._before = (self.t, self.y, self._f)
        self.t, self.y, self._f = t, y, f
        return last

    def interpolant(self) -> Interpolant:
        """Cubic Hermite interpolant of the ends of the last step."""
        return hermite(*self._before, self.t, self.y, self._f)


class ScipyStep:
    """Stepper of a SciPy method between two break points (see stepper.Stepper).

    An explicit method takes steps of at most the largest stable one. Error control alone lets the
    fastest motions grow up to the tolerance, and at loose tolerances of smooth motions some steps
    beyond it, unnoticed.
    """

    def __init__(self, problem: InitialValueProblem):
        t, y, settings = problem.t, problem.y, problem.settings
        method = METHODS[settings.method]
        solver = getattr(scipy.integrate, method.scipy)
        self._problem, self._broken, self._broken_in_a_row = problem, False, 0
        # Evaluations of one try of an explicit method, of which all tries cost as many.
        self._stages: int | None = None if method.implicit else solver.n_stages
        self._rejected = 0
        self._steps = 0
        self.t, self.y = t, y
        self._rates(t, y)
        if self._broken:  # SciPy would look for a first step for ever
            raise self._failure("")
        self._rtol, self._atol = settings.step_tolerances
        # A first step into infinity is judged by the run, not by a warning.
        given = {"rtol": self._rtol, "atol": self._atol, "max_step": problem.longest(t, y)}
        exact = {"jac": problem.jac} if method.implicit else {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._solver: scipy.integrate.OdeSolver = solver(
                self._rates, t, y, problem.end, **given, **exact
            )

    def _rates(self, t: float, y: Array) -> Array:
        rate = self._problem.rhs(t, y)
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
        # LSODA counts in NumPy's integers, which JSON does not know.
        return Counts(self._steps, rejected, *map(int, (solver.nfev, solver.njev, solver.nlu)))

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        solver, before = self._solver, self._solver.nfev
        self._broken = False
        if self._stages and self._steps and self._steps % LOOKS == 0:
            solver.max_step = self._problem.longest(self.t, self.y)
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
        """Dense output of the last step; of DOP853, where it is off, that of steps over parts of
        it."""
        dense = self._solver.dense_output()
        if (
            isinstance(self._solver, scipy.integrate.DOP853)
            and (parts := self._count_parts(dense)) > 1
        ):
            dense = self._dense_in_parts(dense.t_old, dense.y_old, parts) or dense
        return lambda times: dense(times).T

    def _count_parts(self, dense: Any) -> int:
        """Number of parts of the last step in which its dense output is good enough (as parts_of in
        native/control.h)."""
        tolerated = self._atol + self._rtol * np.maximum(np.abs(dense.y_old), np.abs(self.y))
        over = np.sqrt(np.mean((dense.F[-1] / tolerated) ** 2)) / LARGEST_LAST
        parts = 1
        while not over < 1 and parts < MOST_PARTS:
            parts, over = 2 * parts, over / HALVED
        return parts

    def _dense_in_parts(self, start: float, y: Array, parts: int) -> Any:
        """Dense output of so many equal steps over the last one, if they succeed."""
        length = (self.t - start) / parts
        how = {"first_step": length, "max_step": length, "rtol": np.inf, "atol": np.inf}
        what = self._solver.fun, (start, self.t), y, "DOP853"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            made = scipy.integrate.solve_ivp(*what, dense_output=True, **how)
        return made.sol if made.success else None


class CvodeStep:
    """Stepper of CVODE's Adams methods of variable order (A. C. Hindmarsh et al. 2005), by
    scikit-sundae, between two break points (see stepper.Stepper), with the exact Jacobian."""

    def __init__(self, problem: InitialValueProblem):
        try:
            solver = import_module(PACKAGE).CVODE
        except ImportError as error:
            allowed = f"another, or {install_command('cvode')} ({error})"
            raise InputError("integrate.method", "cvode", allowed) from None

        self.counts = Counts()

        def rates(at: float, state: Array, out: Array) -> None:
            self.counts.nfev += 1
            out[:] = problem.rhs(at, np.array(state))

        def jacobian(at: float, state: Array, _: Array, out: Any) -> None:
            self.counts.njev += 1
            out[:] = problem.jac(at, np.array(state))

        longest = problem.longest(problem.t, problem.y)
        self._solver = solver(
            rates,
            method="Adams",
            jacfn=jacobian,
            rtol=problem.settings.rtol,
            atol=problem.settings.atol,
            linsolver="dense",
            max_step=longest if longest < np.inf else 0.0,
        )
        self._end = problem.end
        self._solver.init_step(problem.t, problem.y)
        self.t, self.y = problem.t, np.array(problem.y)

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        found = self._solver.step(self._end, method="onestep", tstop=self._end)
        if found.success and float(found.t) == self.t:  # where it was, after an interpolation
            found = self._solver.step(self._end, method="onestep", tstop=self._end)
        if not found.success:
            raise StepError(f"the method gave up ({str(found.message).rstrip('.').lower()})")
        self.counts.nsteps += 1
        self.t, self.y = float(found.t), np.array(found.y)
        if abs(self._end - self.t) <= 4 * np.spacing(abs(self._end)):
            self.t = self._end
        return self.t >= self._end

    def interpolant(self) -> Interpolant:
        """Dense output of CVODE, of the order of the step."""

        def at(times: Array) -> Array:
            # Beyond the end, be it by a rounding, CVODE would take another step.
            inside = np.minimum(times, self.t)
            return np.stack([np.array(self._solver.step(time).y) for time in inside])

        return at
