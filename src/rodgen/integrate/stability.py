"""How long a step explicit methods can take: the fastest motion, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigs

from rodgen.integrate.stepper import Array, StepError

Complex = NDArray[np.complex128]
# Spectral radius of a step h, by h lambda and h times lambda's partner.
Growth = Callable[[Complex, Complex], Array]

DENSE = 30  # states up to which the whole matrix costs less than products with it
SHIFT = 1e-5  # rad: errors of a difference are its square, and rounding over it
TOLERANCE = 1e-4  # of ARPACK's residual; eigenvalues came out 100 times closer
SPACE = 24  # Krylov vectors between restarts
UNDAMPED = 1e-5  # a damping ratio below this may be an error of the differences
SLACK = 1e-9  # of the spectral radius, where a method neither damps nor drives
GROWN = 2.0  # times that a motion may be made larger by the method in a run
FARTHEST = 12.0  # |h lambda|, beyond the regions of all methods here


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
    system = _Scaled(model, t, np.asarray(y, dtype=float), p)
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
            values, vectors = eigs(operator, k=2, v0=start, ncv=SPACE, tol=tolerance)
        except ArpackNoConvergence as error:
            values, vectors = error.eigenvalues, error.eigenvectors
        except ArpackError:
            continue
        if len(values):
            at = int(np.argmax(np.abs(values)))
            return complex(values[at]), vectors[:, at], len(values) > 1 and tolerance < 1
    return complex(0, system.rate), start.astype(complex), False


def _polynomial(A: Array, b: Array) -> Growth:
    """|R(z)| with R(z) = 1 + sum z^(k+1) b A^k 1 (E. Hairer, G. Wanner 1996, IV.2)."""
    coefficients, power = [1.0], np.ones(len(b))
    for _ in b:
        coefficients.append(float(b @ power))
        power = A @ power
    return lambda z, _: np.asarray(np.abs(np.polyval(coefficients[::-1], z)))


def _shear(pull: Callable[[Array, Array], Array]) -> Growth:
    """Of v+ = v + a, q+ = q + v+ with h = 1; pull gives a as its shares of q and v, (2, ...).

    Its matrix has the determinant 1 + a_v and the trace 2 + a_q + a_v.
    """

    def radius(z: Complex, partner: Complex) -> Array:
        of_q, of_v = pull((z * partner).real, -(z + partner).real)
        determinant, middle = 1 + of_v, 1 + (of_q + of_v) / 2
        root = middle**2 - determinant
        real = np.abs(middle) + np.sqrt(np.maximum(root, 0))
        return np.asarray(np.where(root < 0, np.sqrt(np.abs(determinant)), real))

    return radius


def _pull_once(square: Array, drag: Array) -> Array:
    return np.stack((-square, -drag))


def _pull_of_thesis(square: Array, drag: Array) -> Array:
    """Its four stages (see thesis_runge_kutta) for a(q, v) = -square q - drag v."""
    q, v = (np.multiply.outer(np.array(share), np.ones_like(square)) for share in ((1, 0), (0, 1)))

    def moved(a: Array) -> Array:
        return np.asarray(-square * (q + v + a) - drag * (v + a))

    first = _pull_once(square, drag)
    second = moved(first / 2)
    third = moved(second / 2)
    return np.asarray((first + 2 * (second + third) + moved(third)) / 6)


_KUTTA = np.diag([0.5, 0.5, 1.0], -1), np.array([1, 2, 2, 1]) / 6
LIMITS: dict[str, Growth] = {
    "euler": _polynomial(np.zeros((1, 1)), np.ones(1)),
    "semi_implicit_euler": _shear(_pull_once),
    "rk4": _polynomial(*_KUTTA),
    "dop853": _polynomial(DOP853.A, DOP853.B),
    "thesis_runge_kutta": _shear(_pull_of_thesis),
}


def limit(method: str, value: complex, partner: complex | None = None) -> float:
    """The largest step [s] up to which a method lets no motion of rate lambda [1/s] grow.

    partner as in Dominant; not given, the conjugate. A motion that grows by itself is taken as
    one that does not: its growth is not the method's. Infinite where nothing moves. For euler
    slower motions with less damping may ask for less than the fastest does.
    """
    pair = (value, value.conjugate() if partner is None else partner)
    z, other = (complex(min(x.real, 0.0), x.imag) for x in pair)
    size = abs(z)
    if size == 0:
        return np.inf
    if method == "euler":  # in closed form, since a weak damping leaves next to nothing
        damping = -z.real / size
        return 2 * damping / size if damping > UNDAMPED else 0.0

    def excess(r: Array | float) -> Array:
        at = [np.asarray(r * (root / size), dtype=complex) for root in (z, other)]
        return LIMITS[method](*at) - 1 - SLACK

    grid = np.linspace(0.0, FARTHEST, 2401)
    beyond = int(np.argmax(excess(grid) > 0))
    return float(brentq(excess, grid[beyond - 1], grid[beyond], xtol=1e-12)) / size


def _growth(method: str, step: float, fastest: Dominant) -> float:
    """By what a step [s] multiplies the fastest motion."""
    roots = (np.asarray(step * root, dtype=complex) for root in (fastest.value, fastest.partner))
    return min(float(LIMITS[method](*roots)), 1e9)


def warn_of_step(
    method: str, step: float, span: float, model: ModuleType, t: float, y: Array, p: Array
) -> str | None:
    """What is wrong with a step [s] of an explicit method at a state, in a sentence, or None.

    A step beyond the limit by which nothing grows GROWN times within the span [s] will do.
    """
    if method not in LIMITS:
        return None
    try:
        fastest = spectrum(model, t, y, p)
    except StepError:  # the run itself will say so
        return None
    most = limit(method, fastest.value, fastest.partner)
    if step <= most or _growth(method, step, fastest) < GROWN ** min(step / span, 1.0):
        return None
    share = 100 * max(round(fastest.damping, 5), 0.0)  # without the errors of the differences
    motion = (
        f"the fastest motion, at {fastest.rate:.3g} rad/s with {share:.2g} % of critical damping"
    )
    if most == 0:
        return (
            f"{method} is unstable with every step, not only with {step:g} s, for {motion}; take "
            "semi_implicit_euler, or an adaptive (dop853) or implicit (radau) method"
        )
    return (
        f"the step of {step:g} s is beyond {most:.2g} s, up to which {method} is stable for "
        f"{motion}; take a smaller step, or an adaptive (dop853) or implicit (radau) method"
    )
