"""Stages of three-point Gauss collocation on dense matrices: coefficients, solver, and steps.

With z the stages less the state at the start: transformation and first estimate as in RADAU5 (E.
Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.8).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from rodgen.arrays import Array
from rodgen.integrate.stepper import Counts, InitialValueProblem, Rhs

Factors = tuple[Array, Array]  # of a matrix, as scipy.linalg.lu_factor gives them

FAST = 5e-2  # so fast do the first changes shrink that equal steps keep their derivatives
ITERATIONS, MOST_ITERATIONS = 7, 50  # of a step that may be made shorter, and of an equal one
NUDGE = 1e-7  # of a state, or of one, in a difference of rates
LEFT = 1e6  # times the rounding of the states that rounding in the rates may leave

# Nodes, A, its inverse, and the step's end as a sum of z.
C = (np.polynomial.legendre.leggauss(3)[0] + 1) / 2
_POWERS = C[:, None] ** np.arange(3)
_A = C[:, None] ** np.arange(1, 4) / np.arange(1, 4) @ np.linalg.inv(_POWERS)
_INVERSE = np.linalg.inv(_A)
END = np.linalg.solve(_POWERS.T, 1 / np.arange(1, 4)) @ _INVERSE
# A^-1 = T L T^-1 with a real number and a pair: the first and second columns of T belong to them.
_VALUES, _VECTORS = np.linalg.eig(_INVERSE)
_REAL, _PAIR = int(np.argmin(abs(_VALUES.imag))), int(np.argmin(_VALUES.imag))
MU, MU_PAIR = float(_VALUES[_REAL].real), complex(_VALUES[_PAIR].conjugate())
T = np.stack((_VECTORS[:, _REAL].real, _VECTORS[:, _PAIR].real, _VECTORS[:, _PAIR].imag), axis=1)
TI = np.linalg.inv(T)
# The collocation polynomial's coefficients of x, x^2, x^3 from z; its slopes at both ends.
_DENSE = np.linalg.inv(C[:, None] ** np.arange(1, 4))
_SLOPES = np.array([[1, 0, 0], [1, 2, 3]]) @ _DENSE
# What it lacks, in three parts: with M(x) of zeros C, the integrals of M, of (x - 1/2) M, and of
# the parabola that takes the values of the first of them at C.
_ZEROS = np.polynomial.Polynomial.fromroots(C)
_FIRST = _ZEROS.integ()
_PARTS = (
    _FIRST,
    (_ZEROS * np.polynomial.Polynomial([-0.5, 1])).integ(),
    np.polynomial.Polynomial(np.linalg.solve(_POWERS, _FIRST(C))).integ(),
)


@dataclass(frozen=True)
class CollocationStep:
    """Step from the state y at time t [s] over h [s] with rates f at both ends, the stages z (3,
    states), and the factors of the real Newton matrix MU / h - J, which may be of an older step;
    rhs: the rates at a time and a state."""

    t: float
    y: Array
    h: float
    z: Array
    rates: tuple[Array, Array]
    real: Factors
    rhs: Rhs

    @cached_property
    def end_state(self) -> Array:
        """State at the end."""
        return np.asarray(self.y + END @ self.z)

    @cached_property
    def start_defect(self) -> Array:
        """Defect of the polynomial's slope at the start, times h."""
        return np.asarray(self.h * self.rates[0] - _SLOPES[0] @ self.z)

    @cached_property
    def end_defect(self) -> Array:
        """Defect of the polynomial's slope at the end, times h."""
        return np.asarray(self.h * self.rates[1] - _SLOPES[1] @ self.z)

    @cached_property
    def trapezoid_error(self) -> Array:
        """Difference of the end to that of the trapezoidal rule: -h^3 y''' / 12."""
        far: Array = self.end_state - self.y - self.h / 2 * (self.rates[0] + self.rates[1])
        return far

    def damp(self, defect: Array) -> Array:
        """Damp the stiff part of a defect by the Newton matrix."""
        return np.asarray(
            scipy.linalg.lu_solve(self.real, MU / self.h * defect, check_finite=False)
        )

    @cached_property
    def corrections(self) -> Array:
        """Terms that the polynomial lacks, since its stages are of order 3 alone: with y4 and y5
        the derivatives, h^4 y4 / 6, h^5 y5 / 24 and, by a difference of rates, h^5 J y4 / 6
        (3, states)."""
        first = self.damp(self.end_defect - self.start_defect)
        turned = self.damp(first) - first
        third = 10 * self.h * self._jacobian_product(first)
        second = 20 * self.damp(self.end_defect + self.start_defect) + third / 4
        return np.stack((10 * (first - turned), second, third))

    def _jacobian_product(self, change: Array) -> Array:
        """Multiply J at the start by a change of the states, by a difference of rates."""
        most = float((np.abs(change) / np.maximum(1.0, np.abs(self.y))).max())
        if not 0 < most < np.inf:
            return np.zeros_like(change)
        by = NUDGE / most
        return (self.rhs(self.t, self.y + by * change) - self.rates[0]) / by

    def states_at(self, x: Array, whole: bool = True) -> Array:
        """States (K, states) at shares x (K,) of the step, beyond its end too; whole: with the
        terms that the polynomial lacks."""
        states: Array = self.y + x[:, None] ** np.arange(1, 4) @ (_DENSE @ self.z)
        if whole:
            states += np.stack([part(x) for part in _PARTS], axis=1) @ self.corrections
        return states

    def error_by_one_step(self) -> Array:
        """Error estimate by this step alone, of order 4 in h."""
        return self.damp(self.start_defect) / MU

    def error_by_two_steps(self, last: CollocationStep) -> Array:
        """Error estimate by this step and the last, of order 6 in h: the fourth derivative by the
        defects, less that by the third, which `trapezoid_error` gives."""
        ratio = self.h / last.h
        turn = 0.1 * (ratio - 1) / (ratio + 1)
        fourth = (0.5 + turn) * (self.end_defect - self.start_defect)
        fourth = fourth + ratio**4 * (0.5 - turn) * (last.end_defect - last.start_defect)
        third = 0.4 * ratio / (ratio + 1) * (ratio**3 * last.trapezoid_error - self.trapezoid_error)
        return self.damp(third - fourth) / (2 * MU)


class StageSolver:
    """Solver of the three stages of steps, by Newton's method to a share of the tolerance; equal:
    to rounding, whatever the tolerance. rate: how fast the first changes shrank of late."""

    def __init__(self, problem: InitialValueProblem, equal: bool = False):
        self._rhs, self._jac, self._equal = problem.rhs, problem.jac, equal
        self._rtol, self._atol = problem.settings.rtol, problem.settings.atol
        self.counts, self.rate = Counts(rejected=0), 0.0

    def rates(self, t: float, y: Array) -> Array:
        """Evaluate the rates, and count that."""
        self.counts.nfev += 1
        return self._rhs(t, y)

    def jacobian(self, t: float, y: Array) -> Array:
        """Evaluate the Jacobian, and count that."""
        self.counts.njev += 1
        return self._jac(t, y)

    def error_scale(self, y: Array) -> Array:
        """Tolerated error of each state."""
        scale: Array = self._atol + self._rtol * np.abs(y)
        return scale

    def factors(self, J: Array, h: float) -> tuple[Factors, Factors]:
        """Factors of the real and of the complex Newton matrix of a step h."""
        self.counts.nlu += 2
        real, pair = (
            scipy.linalg.lu_factor(mu / h * np.eye(len(J)) - J, check_finite=False)
            for mu in (MU, MU_PAIR)
        )
        return real, pair

    def solve(
        self, t: float, y: Array, h: float, factors: tuple[Factors, Factors], z: Array
    ) -> tuple[Array | None, int]:
        """Solve for z (3, states) from a guess, None if it fails to converge; and iterations."""
        real, pair = factors
        w = TI @ z
        scale = self.error_scale(y)
        rounding = float(np.finfo(float).eps) * rms((abs(y) + abs(z[-1])) / scale)
        wanted = max(10 * rounding, min(0.03, self._rtol**0.5))
        last, most = 0.0, MOST_ITERATIONS if self._equal else ITERATIONS
        self.rate = 0.0
        for iteration in range(1, most + 1):
            stages = zip(C, z, strict=True)
            F = TI @ np.stack([self.rates(t + c * h, y + row) for c, row in stages])
            if not np.isfinite(F).all():
                return None, iteration
            first = scipy.linalg.lu_solve(real, F[0] - MU / h * w[0], check_finite=False)
            moved = F[1] + 1j * F[2] - MU_PAIR / h * (w[1] + 1j * w[2])
            others = scipy.linalg.lu_solve(pair, moved, check_finite=False)
            change = np.stack((first, others.real, others.imag))
            w = w + change
            z = T @ w
            changed = rms(change / scale)
            # Where the first guess is right, changes are rounding, and do not shrink.
            if changed <= rounding:
                return z, iteration
            if iteration > 1:
                rate = changed / last
                self.rate = rate if iteration == 2 else self.rate
                if self._equal:  # to what rounding in the rates leaves
                    if rate >= 1 and changed <= LEFT * rounding:
                        return z, iteration
                else:
                    ahead = rate ** (ITERATIONS - iteration) * changed
                    if rate >= 1 or ahead > wanted * (1 - rate):
                        return None, iteration
                    if rate * changed < wanted * (1 - rate):
                        return z, iteration
            last = changed
        return None, most


def rms(x: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(x))))
