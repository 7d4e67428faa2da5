"""Fastest motion about a state, and the longest steps of explicit methods that it allows."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from types import ModuleType
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.methods.python_steppers import explicit_step
from rodgen.integrate.stepper import StepError
from rodgen.model.methods import METHODS, Tableau, stability_polynomial
from rodgen.model.rod import BOUNDARIES
from rodgen.result import Note, doubt

Complex = NDArray[np.complex128]

DENSE = 30  # states up to which the whole matrix costs less than products with it
SHIFT = 1e-5  # rad: errors of a difference are its square, and rounding over it
TOLERANCE = 1e-4  # of ARPACK's residual; eigenvalues came out 100 times closer
SPACE = 24  # Krylov vectors between restarts
# States beyond which products and vectors cost seconds and gigabytes; there, among ever closer
# neighbours, a few vectors come to within a percent.
MANY, FEW = 100_000, 8
# Restarts, of which 5 to 15 are the rule: near critical damping the fastest roots are double or
# next to it, where an iteration comes to within a percent and then no further.
RESTARTS = 40
# Spectral radius of a step h, by h lambda and h times lambda's partner.
Growth = Callable[[Complex, Complex], Array]
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


def extra_states_of(model: ModuleType) -> tuple[str, ...]:
    """Names of the states of a module that are neither positions nor velocities."""
    return tuple(getattr(model, "STATES", ()))


def dominant(model: ModuleType, t: float, y: Array, p: Array) -> Dominant:
    """Find the fastest motion about the state y (states,) at time t [s], in O(n) per product.

    ARPACK's implicitly restarted Arnoldi iteration (R. B. Lehoucq et al. 1998) on differences of
    rhs; of few states, all eigenvalues of jac. Raises StepError where the rates are not finite.
    """
    return _cached_dominant(model, t, np.asarray(y, dtype=float).tobytes(), np.asarray(p).tobytes())


@lru_cache(maxsize=16)
def _cached_dominant(model: ModuleType, t: float, state: bytes, parameters: bytes) -> Dominant:
    """Fastest motion about a start, kept for `auto`, a warning and the next run."""
    y, p = np.frombuffer(state), np.frombuffer(parameters)
    system = _ScaledJacobian(model, t, y, p)
    value, vector, converged = _by_eig(system) if len(y) <= DENSE else _by_arpack(system)
    half = system.half
    mode = vector[:half]
    partner = value.conjugate()
    if value.imag == 0 and value:
        x = mode.real
        pull = system.accelerations(x) * system.rate
        partner = complex(-(x @ pull) / (x @ x) / value.real) if x.any() else 0j
    mode = mode * system.unit
    largest = mode[np.argmax(np.abs(mode))]
    mode = mode / largest if largest else mode
    if value.imag < 0:
        value, partner, mode = value.conjugate(), partner.conjugate(), mode.conj()
    return Dominant(value, partner, mode, system.evaluations, converged)


class _ScaledJacobian:
    """Jacobian [[0, 1], [A, B]] of (q, v) as that of (rate q, v), with lengths in links; states
    that are added follow unscaled.

    With rate near the largest frequency both halves of an eigenvector are alike in size, which the
    iteration and the increments of the differences need.
    """

    def __init__(self, model: ModuleType, t: float, y: Array, p: Array):
        self.model, self.t, self.y, self.p = model, t, y, p
        self.added, self.evaluations = len(extra_states_of(model)), 0
        self.half = (len(y) - self.added) // 2
        self.unit = np.ones(self.half)
        if BOUNDARIES[model.BOUNDARY].translates:
            self.unit[:2] = p[model.PARAMETERS.index("length")] / model.N
        if not np.isfinite(model.rhs(t, y, p)).all():
            raise StepError("the rates are not finite")
        self.rate, self.start = 1.0, np.ones(self.half)
        self.rate, self.start = self._guess()

    def _guess(self) -> tuple[float, Array]:
        """Guess frequency and shape by a few powers of A, from links that turn to and fro."""
        x = np.where(np.arange(self.half) % 2, -1.0, 1.0) * np.linspace(1.0, 1.5, self.half)
        square = 0.0
        for _ in range(4):
            pull = self.accelerations(x)
            square = float(np.abs(pull).max() / np.abs(x).max())
            if square == 0:
                return 1.0, x
            x = pull / np.abs(pull).max()
        return square**0.5, x

    def accelerations(self, x: Array) -> Array:
        """Accelerations over the rate, by positions x (half,)."""
        w = np.concatenate((x, np.zeros(self.half + self.added)))
        return self.product(w)[self.half : 2 * self.half]

    @property
    def scale(self) -> Array:
        """Units of the states here, in those of the module."""
        return np.concatenate((self.unit, self.rate * self.unit, np.ones(self.added)))

    def product(self, w: Array) -> Array:
        """Multiply the Jacobian by w (states,), by a central difference."""
        w, half = np.asarray(w).ravel(), self.half
        scale = self.scale
        e = SHIFT / max(np.abs(w).max(), np.finfo(float).tiny)
        step = e * scale * w
        up, down = (self.model.rhs(self.t, self.y + sign * step, self.p) for sign in (1, -1))
        self.evaluations += 2
        difference = (up - down) / (2 * e) / scale
        difference[:half] = self.rate * w[half : 2 * half]  # q' = v
        return np.asarray(difference)


def _by_eig(system: _ScaledJacobian) -> tuple[complex, Complex, bool]:
    values, vectors = np.linalg.eig(system.model.jac(system.t, system.y, system.p))
    at = int(np.argmax(np.abs(values)))
    vector = np.asarray(vectors[:, at].astype(complex) / system.scale, dtype=complex)
    return complex(values[at]), vector, True


def _by_arpack(system: _ScaledJacobian) -> tuple[complex, Complex, bool]:
    size = 2 * system.half + system.added
    operator = scipy.sparse.linalg.LinearOperator((size, size), matvec=system.product, dtype=float)
    start = np.concatenate((system.start, system.start, np.zeros(system.added)))
    values: Complex = np.zeros(0, dtype=complex)
    # A pair and its neighbour; the second try takes what one Krylov space holds.
    for tolerance in (TOLERANCE, 1.0)[size > MANY :]:
        try:
            space = FEW if size > MANY else SPACE
            how = {"v0": start, "ncv": space, "tol": tolerance, "maxiter": RESTARTS}
            values, vectors = scipy.sparse.linalg.eigs(operator, k=2, **how)
        except scipy.sparse.linalg.ArpackNoConvergence as error:
            values, vectors = error.eigenvalues, error.eigenvectors
        except scipy.sparse.linalg.ArpackError:
            continue
        if len(values):
            at = int(np.argmax(np.abs(values)))
            return complex(values[at]), vectors[:, at], len(values) > 1 and tolerance < 1
    return complex(0, system.rate), start.astype(complex), False


def _growth_of_one(A: Collection[Collection[Any]], b: Collection[Any]) -> Growth:
    """Stability function |R(z)| of a Runge-Kutta method, of every motion by itself."""
    coefficients = stability_polynomial(A, b)
    return lambda z, _: np.asarray(np.abs(np.polyval(coefficients[::-1], z)))


def _growth_of_solver(name: str) -> Growth:
    """Stability function of one of SciPy's explicit methods, which is loaded when it is asked."""

    @cache
    def growth() -> Growth:
        solver = getattr(scipy.integrate, name)
        return _growth_of_one(solver.A, solver.B)

    return lambda z, partner: growth()(z, partner)


def _growth_of_pair(tableau: Tableau) -> Growth:
    """Spectral radius of a step of the oscillator that a motion and its partner make up, of a
    method that moves positions and velocities unlike."""
    step = explicit_step(tableau)

    def radius(z: Complex, partner: Complex) -> Array:
        square, drag = (z * partner).real, -(z + partner).real

        def rates(_: float, y: Array) -> Array:
            return np.stack((y[1], -square * y[0] - drag * y[1]))

        none, one = np.zeros_like(square), np.ones_like(square)
        starts = np.stack((one, none)), np.stack((none, one))
        (a, c), (b, d) = (step(rates, 0.0, y, rates(0.0, y), 1.0) for y in starts)
        middle, determinant = (a + d) / 2, a * d - b * c
        root = middle**2 - determinant
        real = np.abs(middle) + np.sqrt(np.maximum(root, 0))
        return np.asarray(np.where(root < 0, np.sqrt(np.abs(determinant)), real))

    return radius


def _growth_functions() -> Iterator[tuple[str, Growth]]:
    for name, method in METHODS.items():
        tableau = method.tableau
        if tableau and tableau.follow:
            yield name, _growth_of_pair(tableau)
        elif tableau:
            yield name, _growth_of_one(tableau.A, tableau.b)
        elif not method.implicit:
            yield name, _growth_of_solver(method.scipy)


LIMITS = dict(_growth_functions())


def step_limit(method: str, value: complex, partner: complex | None = None) -> float:
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
    return float(scipy.optimize.brentq(excess, grid[beyond - 1], grid[beyond], xtol=1e-12)) / size


def largest_stable_step(method: str, model: ModuleType, t: float, y: Array, p: Array) -> float:
    """The largest stable step [s] of a method about a state, by the fastest motion there; infinite
    where there is no limit, 0 where every step is unstable."""
    if method not in LIMITS:
        return np.inf
    try:
        fastest = dominant(model, t, y, p)
    except StepError:  # the run itself will say so
        return np.inf
    return step_limit(method, fastest.value, fastest.partner)


def _growth_factor(method: str, step: float, fastest: Dominant) -> float:
    """Factor by which a step [s] multiplies the fastest motion."""
    roots = (np.asarray(step * root, dtype=complex) for root in (fastest.value, fastest.partner))
    return min(float(LIMITS[method](*roots)), 1e9)


def step_doubt(
    method: str, step: float, span: float, model: ModuleType, t: float, y: Array, p: Array
) -> Note | None:
    """Return the doubt about a step [s] of an explicit method at a state, or None.

    A step beyond the limit by which nothing grows GROWN times within the span [s] will do.
    """
    if method not in LIMITS:
        return None
    try:
        fastest = dominant(model, t, y, p)
    except StepError:  # the run itself will say so
        return None
    most = step_limit(method, fastest.value, fastest.partner)
    if step <= most or _growth_factor(method, step, fastest) < GROWN ** min(step / span, 1.0):
        return None
    share = 100 * max(round(fastest.damping, 5), 0.0)  # without the errors of the differences
    motion = (
        f"the fastest motion, at {fastest.rate:.3g} rad/s with {share:.2g} % of critical damping"
    )
    words = (
        f"the step of {step:g} s is beyond {most:.2g} s, up to which {method} is stable for "
        f"{motion}; take a smaller step, or an adaptive (dop853) or implicit (radau) method"
    )
    if most == 0:
        words = (
            f"{method} is unstable with every step, not only with {step:g} s, for {motion}; take "
            "semi_implicit_euler, or an adaptive (dop853) or implicit (radau) method"
        )
    return doubt(words, step=step, longest=most, rate=fastest.rate)
