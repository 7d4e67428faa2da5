"""Steppers by three-point Gauss collocation, order 6, on dense matrices: adaptive or of equal
steps.

Without damping of its own: for oscillations of which the slow ones count and the fastest are noise
(E. Hairer, C. Lubich, G. Wanner: Geometric Numerical Integration, II.1). Equal steps are symmetric;
steps that adapt are not. Control is that of RADAU5 (E. Hairer, G. Wanner: Solving Ordinary
Differential Equations II, IV.8); the error is measured in the positions, by one step and by two.
"""

from __future__ import annotations

import math

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.methods.collocation_step import (
    END,
    FAST,
    ITERATIONS,
    MU,
    C,
    CollocationStep,
    Factors,
    StageSolver,
    rms,
)
from rodgen.integrate.stepper import InitialValueProblem, Interpolant, StepError
from rodgen.model.methods import COLLOCATION

TWO_STEPS = COLLOCATION["gauss"]
NOTHING = 3.0  # a step that could have been longer by more tells nothing of the next one


class _Gauss:
    """Base of both steppers: where they are, and the last step."""

    def __init__(self, problem: InitialValueProblem, equal: bool = False):
        self._stages, self._end = StageSolver(problem, equal), problem.end
        self.counts = self._stages.counts
        half = (len(problem.y) - problem.added) // 2
        self._velocities = slice(half, 2 * half)
        self.t, self.y = problem.t, problem.y
        self._f = self._stages.rates(self.t, self.y)
        if not np.isfinite(self._f).all():
            raise StepError("the rates stop being finite")
        self._taken: CollocationStep | None = None
        self._smooth = False  # whether two steps tell more of the error than one

    def _first_guess(self, h: float) -> Array:
        """First guess of the stages: on the polynomial of the last step, or at the state."""
        if self._taken is None:
            return np.zeros((3, len(self.y)))
        return self._taken.states_at(1 + C * h / self._taken.h, self._smooth) - self.y

    def _complete(self, h: float, z: Array, next_: float, real: Factors) -> CollocationStep:
        """Complete a step with the rates at its end."""
        rates = self._f, self._stages.rates(next_, self.y + END @ z)
        return CollocationStep(self.t, self.y, h, z, rates, real, self._stages.rates)

    def _move(self, taken: CollocationStep, next_: float) -> None:
        self._taken = taken
        self.t, self.y, self._f = next_, taken.end_state, taken.rates[1]
        self.counts.nsteps += 1

    def interpolant(self) -> Interpolant:
        """Dense output of the last step: its polynomial, with the terms that it lacks."""
        taken = self._taken
        assert taken is not None
        return lambda times: taken.states_at((times - taken.t) / taken.h)


class GaussStep(_Gauss):
    """Stepper with error control between two break points (see stepper.Stepper)."""

    def __init__(self, problem: InitialValueProblem):
        super().__init__(problem)
        self._longest = problem.longest(self.t, self.y)
        self._h = self._first_step()
        self._reached = 0.0  # by the last step

    def _first_step(self) -> float:
        """First step by E. Hairer et al.: Solving Ordinary Differential Equations I, II.4."""
        scale, span = self._stages.error_scale(self.y), self._end - self.t
        d0, d1 = rms(self.y / scale), rms(self._f / scale)
        h = min(1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1, span)
        if not h > 0:  # rates beyond all numbers
            return 0.0
        change = self._stages.rates(self.t + h, self.y + h * self._f) - self._f
        largest = max(d1, rms(change / scale) / h)
        next_ = max(1e-6, 1e-3 * h) if largest <= 1e-15 else (0.01 / largest) ** 0.25
        return float(min(100 * h, next_, span))

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        t, y, again, reason = self.t, self.y, False, "the step becomes too small to move on"
        J = self._stages.jacobian(t, y)
        left = self._end - t
        while self._h > 16 * np.spacing(max(abs(t), 1e-290)):
            h = min(self._h, self._longest)
            h = left if h >= left else left / 2 if 2 * h > left else h
            factors = self._stages.factors(J, h)
            z, iterations = self._stages.solve(t, y, h, factors, self._first_guess(h))
            if z is None:
                reason = "Newton's method finds no solution, however small the step"
                self.counts.rejected = (self.counts.rejected or 0) + 1
                self._h, again = h / 2, False
                continue
            next_ = self._end if h == left else t + h
            taken = self._complete(h, z, next_, factors[0])
            whole = bool(np.isfinite(taken.rates[1]).all())
            reach = self._reach(taken, again) if whole else 0.0
            safety = 0.9 * (2 * ITERATIONS + 1) / (2 * ITERATIONS + iterations)
            factor = safety * self._step_factor(h, reach)
            if reach >= 1:
                self._h = max(h * min(10.0, max(0.2, factor)), self._h if h < self._h else 0.0)
                self._reached = min(reach, NOTHING)
                self._move(taken, next_)
                return h == left
            self.counts.rejected = (self.counts.rejected or 0) + 1
            reason = reason if whole else "the rates stop being finite"
            self._h, again = h * max(0.2, factor) if whole else h / 2, whole
        raise StepError(reason)

    def _step_factor(self, h: float, reach: float) -> float:
        """Factor of the next step, by K. Gustafsson's predictive control."""
        if self._taken is None or np.isinf(reach):
            return reach
        return min(1.0, h / self._taken.h * reach / self._reached) * reach

    def _reach(self, taken: CollocationStep, again: bool) -> float:
        """Factor by which the step could have been longer for the tolerance. The error by two steps
        holds where the motion is smooth over both, that by one at every step, after a break too,
        and where the step is longer than the fastest motion."""
        error = taken.error_by_one_step()
        one = self._error_norm(error, taken)
        if again and one > 1:
            more = self._stages.rates(taken.t, taken.y + error) - taken.rates[0]
            one = self._error_norm(error + taken.damp(taken.h * more) / MU, taken)
        reach = _at_least_tiny(one) ** -0.25
        if self._taken is None:
            return float(reach)
        two = TWO_STEPS.weight * self._error_norm(taken.error_by_two_steps(self._taken), taken)
        by_two = _at_least_tiny(two) ** (-1 / TWO_STEPS.power)
        self._smooth = by_two > reach
        return float(max(reach, by_two))

    def _error_norm(self, error: Array, taken: CollocationStep) -> float:
        """Norm of an error of all but the velocities, over what is tolerated."""
        scale = self._stages.error_scale(np.maximum(np.abs(taken.y), np.abs(taken.end_state)))
        return rms(np.delete(error / scale, self._velocities))


def _at_least_tiny(error: float) -> float:
    return max(error, 1e-100)


class GaussEqualSteps(_Gauss):
    """Stepper of equal steps between two break points, the last one shortened to meet the end (see
    stepper.Stepper); Newton's method goes on to rounding."""

    def __init__(self, problem: InitialValueProblem):
        super().__init__(problem, equal=True)
        assert problem.settings.step is not None
        self._start, self._step = problem.t, problem.settings.step
        # A step that would be shorter than a millionth of the others is not taken.
        self._total = max(1, math.ceil((self._end - self._start) / self._step - 1e-6))
        self._jacobian: Array | None = None
        self._made: tuple[float, tuple[Factors, Factors]] | None = None  # for a step

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        done = self.counts.nsteps
        last = done + 1 >= self._total
        h = self._end - self._start - done * self._step if last else self._step
        next_ = self._end if last else self._start + (done + 1) * self._step
        z, factors = self._solve_stages(h)
        taken = self._complete(h, z, next_, factors[0])
        if not np.isfinite(taken.rates[1]).all():
            raise StepError("the rates stop being finite in the step after this time")
        self._move(taken, next_)
        return last

    def _solve_stages(self, h: float) -> tuple[Array, tuple[Factors, Factors]]:
        """Solve for the stages, by the Jacobian of a step before as long as Newton's method is fast
        with it, and by that of the step itself where that leads to no solution."""
        old = self._jacobian is not None
        while True:
            if self._jacobian is None:
                self._jacobian, self._made = self._stages.jacobian(self.t, self.y), None
            if self._made is None or self._made[0] != h:
                self._made = h, self._stages.factors(self._jacobian, h)
            z, _ = self._stages.solve(self.t, self.y, h, self._made[1], self._first_guess(h))
            if z is None or self._stages.rate > FAST:
                self._jacobian = None
            if z is not None:
                return z, self._made[1]
            if not old:
                raise StepError("Newton's method finds no solution with this step")
            old = False
