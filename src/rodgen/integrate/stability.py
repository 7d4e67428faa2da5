"""How long a step explicit methods can take: what becomes of the fastest motion."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import numpy as np
from scipy.integrate import DOP853, RK23, RK45
from scipy.optimize import brentq

from rodgen.integrate.spectrum import Complex, Dominant, spectrum
from rodgen.integrate.stepper import Array, StepError

# Spectral radius of a step h, by h lambda and h times lambda's partner.
Growth = Callable[[Complex, Complex], Array]

UNDAMPED = 1e-5  # a damping ratio below this may be an error of the differences
SLACK = 1e-9  # of the spectral radius, where a method neither damps nor drives
GROWN = 2.0  # times that a motion may be made larger by the method in a run
FARTHEST = 12.0  # |h lambda|, beyond the regions of all methods here


def _polynomial(A: Array, b: Array) -> Growth:
    """|R(z)| with R(z) = 1 + sum z^(k+1) b A^k 1 (E. Hairer, G. Wanner 1996, IV.2)."""
    coefficients, power = [1.0], np.ones(len(b))
    A = np.pad(A, ((0, 0), (0, len(b) - A.shape[1])))  # SciPy leaves out columns of zeros
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
    "rk23": _polynomial(RK23.A, RK23.B),
    "rk45": _polynomial(RK45.A, RK45.B),
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


def largest(method: str, model: ModuleType, t: float, y: Array, p: Array) -> float:
    """That step for the fastest motion about a state; infinite where there is no limit."""
    if method not in LIMITS:
        return np.inf
    try:
        fastest = spectrum(model, t, y, p)
    except StepError:  # the run itself will say so
        return np.inf
    return limit(method, fastest.value, fastest.partner) or np.inf


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
