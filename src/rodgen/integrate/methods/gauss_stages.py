"""The three stages of Gauss collocation, by Newton's method on dense matrices."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from rodgen.integrate.methods.gauss_tableau import MU, MU_PAIR, TI, C, Factors, T
from rodgen.integrate.stepper import Array, Counts, Rhs

ITERATIONS, MOST_ITERATIONS = 7, 50  # of a step that may be made shorter, and of an equal one
LEFT = 1e6  # times the rounding of the states that rounding in the rates may leave


class Stages:
    """Newton's method for steps of a system with rates rhs and Jacobian jac, to a share of a
    tolerance; equal: to rounding, however small the tolerance."""

    def __init__(self, rhs: Rhs, jac: Rhs, rtol: float, atol: float, equal: bool = False):
        self._rhs, self._jac, self._equal = rhs, jac, equal
        self._rtol, self._atol = rtol, atol
        self.counts = Counts(rejected=0)

    def rates(self, t: float, y: Array) -> Array:
        """The rates, counted."""
        self.counts.rhs += 1
        return self._rhs(t, y)

    def jacobian(self, t: float, y: Array) -> Array:
        """The Jacobian, counted."""
        self.counts.jacobian += 1
        return self._jac(t, y)

    def tolerated(self, y: Array) -> Array:
        """What is tolerated of an error in a state."""
        scale: Array = self._atol + self._rtol * np.abs(y)
        return scale

    def factors(self, J: Array, h: float) -> tuple[Factors, Factors]:
        """Of the real and of the complex matrix of a step h."""
        self.counts.factorisations += 2
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
