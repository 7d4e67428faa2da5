"""Gauss collocation at three points, order 6, with error control, on dense matrices.

Symmetric, symplectic and without damping of its own: for oscillations of which the slow ones count
and the fastest are noise (E. Hairer, C. Lubich, G. Wanner: Geometric Numerical Integration, II.1).
Transformation, estimate and control are those of RADAU5 (E. Hairer, G. Wanner: Solving Ordinary
Differential Equations II, IV.8); the error is measured in the positions.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from rodgen.integrate.stepper import Array, Counts, Interpolant, Rhs, StepError

ORDER, DENSE_ORDER = 6, 3
ITERATIONS = 7

# Nodes, A, its inverse, and the step's end as a sum of z_i = y_i - y.
C = (np.polynomial.legendre.leggauss(3)[0] + 1) / 2
_POWERS = C[:, None] ** np.arange(3)
_A = C[:, None] ** np.arange(1, 4) / np.arange(1, 4) @ np.linalg.inv(_POWERS)
_B = np.linalg.solve(_POWERS.T, 1 / np.arange(1, 4))
_INVERSE = np.linalg.inv(_A)
_END = _B @ _INVERSE
# A^-1 = T L T^-1 with a real number and a pair: the first and second columns of T belong to them.
_VALUES, _VECTORS = np.linalg.eig(_INVERSE)
_REAL, _PAIR = int(np.argmin(abs(_VALUES.imag))), int(np.argmin(_VALUES.imag))
MU, MU_PAIR = float(_VALUES[_REAL].real), complex(_VALUES[_PAIR].conjugate())
_T = np.stack((_VECTORS[:, _REAL].real, _VECTORS[:, _PAIR].real, _VECTORS[:, _PAIR].imag), axis=1)
_TI = np.linalg.inv(_T)
# The quadrature of order 3 that also weighs the start, by 1 / MU, less that of the method.
_OTHER = np.linalg.solve(_POWERS.T, 1 / np.arange(1, 4) - np.array([1 / MU, 0, 0]))
_ERROR = (_OTHER - _B) @ _INVERSE * MU
_DENSE = np.linalg.inv(C[:, None] ** np.arange(1, 4))


class GaussStep:
    """The method between two break points (see stepper.Stepper)."""

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
        self._rhs, self._jac, self._end = rhs, jac, end
        self._rtol, self._atol, self._longest = rtol, atol, longest
        self.counts = Counts(rejected=0)
        self.t, self.y = t, y
        self._f = self._rates(t, y)
        if not np.isfinite(self._f).all():
            raise StepError("the rates stop being finite")
        self._h = self._first_step()
        self._last: tuple[float, float] | None = None
        self._before: tuple[float, Array, Array] | None = None  # time, state, polynomial

    def _rates(self, t: float, y: Array) -> Array:
        self.counts.rhs += 1
        return self._rhs(t, y)

    def _scale(self, y: Array) -> Array:
        scale: Array = self._atol + self._rtol * np.abs(y)
        return scale

    def _first_step(self) -> float:
        """Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.4."""
        scale, span = self._scale(self.y), self._end - self.t
        d0, d1 = _size(self.y / scale), _size(self._f / scale)
        h = min(1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1, span)
        change = self._rates(self.t + h, self.y + h * self._f) - self._f
        largest = max(d1, _size(change / scale) / h)
        next_ = max(1e-6, 1e-3 * h) if largest <= 1e-15 else (0.01 / largest) ** 0.25
        return float(min(100 * h, next_, span))

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        t, y, again, reason = self.t, self.y, False, "the step becomes too small to move on"
        J = self._jac(t, y)
        self.counts.jacobian += 1
        left = self._end - t
        while self._h > 16 * np.spacing(max(abs(t), 1e-290)):
            h = min(self._h, self._longest)
            h = left if h >= left else left / 2 if 2 * h > left else h
            real = lu_factor(MU / h * np.eye(len(y)) - J, check_finite=False)
            pair = lu_factor(MU_PAIR / h * np.eye(len(y)) - J, check_finite=False)
            self.counts.factorisations += 2
            z, iterations = self._stages(h, real, pair)
            if z is None:
                reason = "Newton's method finds no solution, however small the step"
                self.counts.rejected = (self.counts.rejected or 0) + 1
                self._h, again = h / 2, False
                continue
            new = y + _END @ z
            rest = _ERROR @ z / h
            error = lu_solve(real, self._f + rest, check_finite=False)
            size = self._measured(error, y, new)
            if again and size > 1:
                error = lu_solve(real, self._rates(t, y + error) + rest, check_finite=False)
                size = self._measured(error, y, new)
            factor = 0.9 * (2 * ITERATIONS + 1) / (2 * ITERATIONS + iterations)
            factor *= self._predicted(h, size)
            f = self._rates(self._end if h == left else t + h, new)
            if size <= 1 and np.isfinite(f).all():
                self._accept(t, y, h, h == left, new, f, z, size, factor)
                return h == left
            self.counts.rejected = (self.counts.rejected or 0) + 1
            reason = reason if size > 1 else "the rates stop being finite"
            self._h, again = h * max(0.2, factor) if size > 1 else h / 2, True
        raise StepError(reason)

    def _accept(
        self, t: float, y: Array, h: float, last: bool, new: Array, f: Array, z: Array,
        size: float, factor: float,
    ) -> None:  # fmt: skip
        self._before = t, y, _DENSE @ z
        self._last = h, size
        self.t, self.y, self._f = self._end if last else t + h, new, f
        self._h = max(h * min(10.0, max(0.2, factor)), self._h if h < self._h else 0.0)
        self.counts.steps += 1

    def _predicted(self, h: float, size: float) -> float:
        """K. Gustafsson's predictive control."""
        one = max(size, 1e-16) ** -0.25
        if self._last is None:
            return float(one)
        before, error = self._last[0], max(self._last[1], 1e-2)  # next to nothing says nothing
        return float(min(1.0, h / before * (error / max(size, 1e-16)) ** 0.25) * one)

    def _measured(self, error: Array, y: Array, new: Array) -> float:
        half = len(y) // 2
        scale = self._scale(np.maximum(np.abs(y), np.abs(new)))
        return _size((error / scale)[:half])

    def _stages(self, h: float, real: object, pair: object) -> tuple[Array | None, int]:
        """z (3, states) by Newton's method, and its iterations; None if it does not converge."""
        z = self._predict(h)
        w = _TI @ z
        scale = self._scale(self.y)
        rounding = float(np.finfo(float).eps) * _size((abs(self.y) + abs(z[-1])) / scale)
        wanted = max(10 * rounding, min(0.03, self._rtol**0.5))
        last = 0.0
        for iteration in range(1, ITERATIONS + 1):
            stages = zip(C, z, strict=True)
            F = _TI @ np.stack([self._rates(self.t + c * h, self.y + row) for c, row in stages])
            if not np.isfinite(F).all():
                return None, iteration
            first = lu_solve(real, F[0] - MU / h * w[0], check_finite=False)
            moved = F[1] + 1j * F[2] - MU_PAIR / h * (w[1] + 1j * w[2])
            others = lu_solve(pair, moved, check_finite=False)
            change = np.stack((first, others.real, others.imag))
            w = w + change
            z = _T @ w
            size = _size(change / scale)
            # Where the first guess is right, changes are rounding, and do not shrink.
            if size <= rounding:
                return z, iteration
            if iteration > 1:
                rate = size / last
                ahead = rate ** (ITERATIONS - iteration) * size
                if rate >= 1 or ahead > wanted * (1 - rate):
                    return None, iteration
                if rate * size < wanted * (1 - rate):
                    return z, iteration
            last = size
        return None, ITERATIONS

    def _predict(self, h: float) -> Array:
        """Where Newton's method begins: on the polynomial of the last step, or at the state."""
        if self._before is None:
            return np.zeros((3, len(self.y)))
        t, _, coefficients = self._before
        x = 1 + C * h / (self.t - t)
        z: Array = (x[:, None] ** np.arange(1, 4) - 1) @ coefficients
        return z

    def interpolant(self) -> Interpolant:
        """The collocation polynomial of the last step."""
        assert self._before is not None
        (t, y, coefficients), h = self._before, self.t - self._before[0]

        def at(times: Array) -> Array:
            x = ((times - t) / h)[:, None]
            states: Array = y + x ** np.arange(1, 4) @ coefficients
            return states

        return at


def _size(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x))))
