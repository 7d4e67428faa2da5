"""The fastest motion of a rod about a state, by an O(n) iteration."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigs

from rodgen.integrate.stepper import Array, StepError

Complex = NDArray[np.complex128]

DENSE = 30  # states up to which the whole matrix costs less than products with it
SHIFT = 1e-5  # rad: errors of a difference are its square, and rounding over it
TOLERANCE = 1e-4  # of ARPACK's residual; eigenvalues came out 100 times closer
SPACE = 24  # Krylov vectors between restarts
# Restarts, of which 5 to 15 are the rule: near critical damping the fastest roots are double or
# next to it, where an iteration comes to within a percent and then no further.
RESTARTS = 40


@dataclass(frozen=True)
class Dominant:
    """The eigenvalue of largest modulus of the Jacobian of the rates.

    value: lambda [1/s], its imaginary part not negative; partner: the other root of
    z^2 + d z + omega^2 = 0, the oscillator that lambda is part of: its conjugate, or the slow
    rate where both are real; mode: positions of the eigenvector (states/2,), its largest entry
    1; evaluations of rhs; converged: False for the best that the iteration found.
    """

    value: complex
    partner: complex
    mode: Complex
    evaluations: int
    converged: bool

    @property
    def rate(self) -> float:
        """|lambda| [1/s]; natural frequency [rad/s] of an oscillation."""
        return abs(self.value)

    @property
    def damping(self) -> float:
        """Share of critical damping, -Re/|lambda|: 1 where the motion does not oscillate."""
        return -self.value.real / self.rate if self.rate else 0.0


def spectrum(model: ModuleType, t: float, y: Array, p: Array) -> Dominant:
    """The fastest motion about the state y (states,) at time t [s], in O(n) per product.

    ARPACK's implicitly restarted Arnoldi iteration (R. B. Lehoucq et al. 1998) on differences of
    rhs; of few states, all eigenvalues of jac. Raises StepError where the rates are not finite.
    """
    return _kept(model, t, np.asarray(y, dtype=float).tobytes(), np.asarray(p).tobytes())


@lru_cache(maxsize=16)
def _kept(model: ModuleType, t: float, state: bytes, parameters: bytes) -> Dominant:
    """The same start is asked for by `auto`, by the warning of a step, and by the next run."""
    y, p = np.frombuffer(state), np.frombuffer(parameters)
    system = _Scaled(model, t, y, p)
    value, vector, converged = _dense(system) if len(y) <= DENSE else _iterated(system)
    half = len(y) // 2
    mode = vector[:half]
    partner = value.conjugate()
    if value.imag == 0 and value:
        x = mode.real
        pull = system.product(np.concatenate((x, np.zeros(half))))[half:] * system.rate
        partner = complex(-(x @ pull) / (x @ x) / value.real) if x.any() else 0j
    mode = mode * system.unit
    largest = mode[np.argmax(np.abs(mode))]
    mode = mode / largest if largest else mode
    if value.imag < 0:
        value, partner, mode = value.conjugate(), partner.conjugate(), mode.conj()
    return Dominant(value, partner, mode, system.evaluations, converged)


class _Scaled:
    """The Jacobian [[0, 1], [A, B]] of (q, v) as that of (rate q, v), lengths in links.

    With rate near the largest frequency both halves of an eigenvector are alike in size, which
    the iteration and the increments of the differences need.
    """

    def __init__(self, model: ModuleType, t: float, y: Array, p: Array):
        self.model, self.t, self.y, self.p = model, t, y, p
        self.half, self.evaluations = len(y) // 2, 0
        self.unit = np.ones(self.half)
        if model.BOUNDARY == "free":
            self.unit[:2] = p[model.PARAMETERS.index("length")] / model.N
        if not np.isfinite(model.rhs(t, y, p)).all():
            raise StepError("the rates are not finite")
        self.rate, self.start = 1.0, np.ones(self.half)
        self.rate, self.start = self._guess()

    def _guess(self) -> tuple[float, Array]:
        """Frequency and shape after a few powers of A, from links that turn to and fro."""
        x = np.where(np.arange(self.half) % 2, -1.0, 1.0) * np.linspace(1.0, 1.5, self.half)
        square = 0.0
        for _ in range(4):
            pull = self.product(np.concatenate((x, np.zeros(self.half))))[self.half :]
            square = float(np.abs(pull).max() / np.abs(x).max())
            if square == 0:
                return 1.0, x
            x = pull / np.abs(pull).max()
        return square**0.5, x

    def product(self, w: Array) -> Array:
        """Jacobian times w (states,) by a central difference."""
        w, half = np.asarray(w).ravel(), self.half
        scale = np.concatenate((self.unit, self.rate * self.unit))
        e = SHIFT / max(np.abs(w).max(), np.finfo(float).tiny)
        step = e * scale * w
        up, down = (self.model.rhs(self.t, self.y + sign * step, self.p) for sign in (1, -1))
        self.evaluations += 2
        difference = (up - down) / (2 * e) / scale
        difference[:half] = self.rate * w[half:]  # q' = v
        return np.asarray(difference)

    def vector(self, raw: Complex) -> Complex:
        """An eigenvector of the module's own Jacobian in the units here."""
        return raw / np.concatenate((self.unit, self.rate * self.unit))


def _dense(system: _Scaled) -> tuple[complex, Complex, bool]:
    values, vectors = np.linalg.eig(system.model.jac(system.t, system.y, system.p))
    at = int(np.argmax(np.abs(values)))
    return complex(values[at]), system.vector(vectors[:, at].astype(complex)), True


def _iterated(system: _Scaled) -> tuple[complex, Complex, bool]:
    size = 2 * system.half
    operator = LinearOperator((size, size), matvec=system.product, dtype=float)
    start = np.concatenate((system.start, system.start))
    values: Complex = np.zeros(0, dtype=complex)
    # A pair and its neighbour; the second try takes what one Krylov space holds.
    for tolerance in (TOLERANCE, 1.0):
        try:
            values, vectors = eigs(
                operator, k=2, v0=start, ncv=SPACE, tol=tolerance, maxiter=RESTARTS
            )
        except ArpackNoConvergence as error:
            values, vectors = error.eigenvalues, error.eigenvectors
        except ArpackError:
            continue
        if len(values):
            at = int(np.argmax(np.abs(values)))
            return complex(values[at]), vectors[:, at], len(values) > 1 and tolerance < 1
    return complex(0, system.rate), start.astype(complex), False
