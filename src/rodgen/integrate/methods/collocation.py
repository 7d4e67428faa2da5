"""Gauss collocation at three points on dense matrices: coefficients, stages, and a step by it.

With z the stages less the state at the start: transformation and first estimate as in RADAU5 (E.
Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.8).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from rodgen.arrays import Array
from rodgen.integrate.stepper import Counts, Problem, Rhs

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
class Taken:
    """A step from the state y at time t [s] over h [s] with rates f at both ends, the stages z
    (3, states), and the factors of the real Newton matrix MU / h - J, which may be of an older
    step; rhs: the rates at a time and a state."""

    t: float
    y: Array
    h: float
    z: Array
    rates: tuple[Array, Array]
    real: Factors
    rhs: Rhs

    @cached_property
    def new(self) -> Array:
        """The state at the end."""
        state: Array = self.y + END @ self.z
        return state

    @cached_property
    def begin(self) -> Array:
        """h times what the polynomial's slope lacks at the start."""
        lack: Array = self.h * self.rates[0] - _SLOPES[0] @ self.z
        return lack

    @cached_property
    def end(self) -> Array:
        """h times what the polynomial's slope lacks at the end."""
        lack: Array = self.h * self.rates[1] - _SLOPES[1] @ self.z
        return lack

    @cached_property
    def bend(self) -> Array:
        """How far the end is from that of the trapezoidal rule: -h^3 y''' / 12."""
        far: Array = self.new - self.y - self.h / 2 * (self.rates[0] + self.rates[1])
        return far

    def damped(self, defect: Array) -> Array:
        """A defect, what is stiff in it damped by the Newton matrix."""
        less: Array = lu_solve(self.real, MU / self.h * defect, check_finite=False)
        return less

    @cached_property
    def lacks(self) -> Array:
        """What the polynomial lacks, since its stages are of order 3 alone: with y4 and y5 the
        derivatives, h^4 y4 / 6, h^5 y5 / 24 and, by a difference of rates, h^5 J y4 / 6
        (3, states)."""
        first = self.damped(self.end - self.begin)
        turned = self.damped(first) - first
        third = 10 * self.h * self._change_along(first)
        second = 20 * self.damped(self.end + self.begin) + third / 4
        return np.stack((10 * (first - turned), second, third))

    def _change_along(self, change: Array) -> Array:
        """J at the start times a change of the states."""
        most = float((np.abs(change) / np.maximum(1.0, np.abs(self.y))).max())
        if not 0 < most < np.inf:
            return np.zeros_like(change)
        by = NUDGE / most
        slope: Array = (self.rhs(self.t, self.y + by * change) - self.rates[0]) / by
        return slope

    def at(self, x: Array, whole: bool = True) -> Array:
        """States at shares x (K,) of the step, after it too; whole: with what the polynomial lacks
        (K, states)."""
        states: Array = self.y + x[:, None] ** np.arange(1, 4) @ (_DENSE @ self.z)
        if whole:
            states += np.stack([part(x) for part in _PARTS], axis=1) @ self.lacks
        return states

    def error_of_one(self) -> Array:
        """The error as this step alone tells it, of the power 4 of h."""
        return self.damped(self.begin) / MU

    def error_of_two(self, last: Taken) -> Array:
        """The error as this step and the last tell it, of the power 6: what the fourth derivative
        is by the defects, less what the third, by `bend`, says of it."""
        ratio = self.h / last.h
        turn = 0.1 * (ratio - 1) / (ratio + 1)
        fourth = (0.5 + turn) * (self.end - self.begin)
        fourth = fourth + ratio**4 * (0.5 - turn) * (last.end - last.begin)
        third = 0.4 * ratio / (ratio + 1) * (ratio**3 * last.bend - self.bend)
        return self.damped(third - fourth) / (2 * MU)


class Stages:
    """The three stages of steps of a problem, by Newton's method to a share of the tolerance;
    equal: to rounding, whatever the tolerance. rate: how fast the first changes shrank of late."""

    def __init__(self, problem: Problem, equal: bool = False):
        self._rhs, self._jac, self._equal = problem.rhs, problem.jac, equal
        self._rtol, self._atol = problem.settings.rtol, problem.settings.atol
        self.counts, self.rate = Counts(rejected=0), 0.0

    def rates(self, t: float, y: Array) -> Array:
        """The rates, counted."""
        self.counts.nfev += 1
        return self._rhs(t, y)

    def jacobian(self, t: float, y: Array) -> Array:
        """The Jacobian, counted."""
        self.counts.njev += 1
        return self._jac(t, y)

    def tolerated(self, y: Array) -> Array:
        """What is tolerated of an error in a state."""
        scale: Array = self._atol + self._rtol * np.abs(y)
        return scale

    def factors(self, J: Array, h: float) -> tuple[Factors, Factors]:
        """Of the real and of the complex matrix of a step h."""
        self.counts.nlu += 2
        real, pair = (
            lu_factor(mu / h * np.eye(len(J)) - J, check_finite=False) for mu in (MU, MU_PAIR)
        )
        return real, pair

    def solved(
        self, t: float, y: Array, h: float, factors: tuple[Factors, Factors], z: Array
    ) -> tuple[Array | None, int]:
        """z (3, states) from a first guess, and the iterations; None if they do not converge."""
        real, pair = factors
        w = TI @ z
        scale = self.tolerated(y)
        rounding = float(np.finfo(float).eps) * size((abs(y) + abs(z[-1])) / scale)
        wanted = max(10 * rounding, min(0.03, self._rtol**0.5))
        last, most = 0.0, MOST_ITERATIONS if self._equal else ITERATIONS
        self.rate = 0.0
        for iteration in range(1, most + 1):
            stages = zip(C, z, strict=True)
            F = TI @ np.stack([self.rates(t + c * h, y + row) for c, row in stages])
            if not np.isfinite(F).all():
                return None, iteration
            first = lu_solve(real, F[0] - MU / h * w[0], check_finite=False)
            moved = F[1] + 1j * F[2] - MU_PAIR / h * (w[1] + 1j * w[2])
            others = lu_solve(pair, moved, check_finite=False)
            change = np.stack((first, others.real, others.imag))
            w = w + change
            z = T @ w
            changed = size(change / scale)
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


def size(x: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(x))))
