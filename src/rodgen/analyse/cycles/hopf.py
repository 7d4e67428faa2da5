"""Hopf points of equilibria along a number of a scene, and their normal form: whether the cycles
that begin there are stable and lie beyond (supercritical), or unstable and before (subcritical).

With A = J at the equilibrium, A q = i w q, A^T p = -i w p, <p, q> = 1, and B, C the second and
third derivatives of the rates,

  2 c = <p, C(q, q, q~) - 2 B(q, A^-1 B(q, q~)) + B(q~, (2 i w - A)^-1 B(q, q))>,

z' = s z + c z |z|^2 on the centre manifold (Y. A. Kuznetsov, Elements of Applied Bifurcation
Theory, 3rd ed., 2004, section 5.4). B and C are differences of the generated Jacobian, of sixth
order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.optimize import brentq

from rodgen.analyse.cycles.flow import Flow
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.progress import tell

Complex = NDArray[np.complex128]
Places = NDArray[np.intp]
FORCES = 81  # values in the range at which the growth of small motions is looked at
STEP = 0.02  # rad: of differences of sixth order, whose error is its sixth power
FIRST = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60
SECOND = np.array([2, -27, 270, -490, 270, -27, 2]) / 180
SMOOTH = 1e-3  # by which coefficients of two steps may differ
SLOW = 1e-6  # of the middle of all moduli: below it nothing oscillates
NEUTRAL = 1e-7  # of the frequency: growth or decay below it is none
BESIDE = 1e-5  # of the range of values, around a Hopf point that is known
ITERATIONS = 30
REST = 1e-13  # of the correction of an equilibrium


@dataclass(frozen=True)
class Hopf:
    """value: of the number of the scene; frequency [rad/s]; slope: of the eigenvalue s by it;
    coefficient: c of the normal form; x: the equilibrium (size,); way: q (size,), whose
    largest angle is 1."""

    value: float
    frequency: float
    slope: complex
    coefficient: complex
    x: Array = field(repr=False)
    way: Complex = field(repr=False)

    @property
    def lyapunov(self) -> float:
        """The first Lyapunov coefficient, Re c over the frequency, for q of this length."""
        return self.coefficient.real / self.frequency

    @property
    def supercritical(self) -> bool:
        """Whether the cycles that begin here attract on the centre manifold."""
        return self.coefficient.real < 0

    def beside(self, amplitude: float) -> tuple[Array, float, float]:
        """A state (size,), the value and the period [s] of the cycle whose angles differ from the
        equilibrium by so much at most [rad]."""
        square = (amplitude / 2) ** 2
        aside = -self.coefficient.real / self.slope.real * square
        turned = self.frequency + self.coefficient.imag * square + self.slope.imag * aside
        x = self.x + amplitude * self.way.real
        return x, self.value + aside, 2 * np.pi / turned


def equilibrium(flow: Flow, t: float, x: Array) -> Array:
    """The state (size,) near x at which the rates vanish; without turning, where that does not
    count. Raises AnalysisError."""
    for _ in range(ITERATIONS):
        J = jacobian(flow, t, x)
        change = np.linalg.lstsq(J, -flow.rates(t, x), rcond=1e-12)[0]
        if not np.isfinite(change).all() or np.abs(change).max() > 1e3:
            break
        x = x + change
        if np.abs(change).max() <= REST * (1 + np.abs(x).max()):
            return x
    raise AnalysisError("no equilibrium was found from which cycles could begin")


def jacobian(flow: Flow, t: float, x: Array) -> Array:
    """Derivatives of the rates (size, size)."""
    kept = flow.quotient.kept
    J: Array = flow.model.jac(t, flow.quotient.lifted(x), flow.p)[np.ix_(kept, kept)]
    return J


def hopf_point(at: Callable[[float], Flow], t: float, x: Array, low: float, high: float) -> Hopf:
    """The first Hopf point from low towards high on the equilibrium that is near x at low; at: the
    flow at a value. Raises AnalysisError where there is none."""
    values = np.linspace(low, high, FORCES)
    x = equilibrium(at(values[0]), t, x)
    before = fastest_growing(jacobian(at(values[0]), t, x))
    for a, b in pairwise(values.tolist()):
        tell(f"looking for a Hopf point at {b:.6g}")
        after_x = equilibrium(at(b), t, x)
        after = fastest_growing(jacobian(at(b), t, after_x))
        signs = {_growth(before), _growth(after)}
        if signs == {-1, 1} or signs == {0, 1}:
            if 0 in signs:
                raise AnalysisError(
                    f"no Hopf point: near {b:.9g} oscillations meet and do not cross, as they do "
                    "without damping; give the scene some"
                )
            return _located(at, t, x, float(a), float(b), fastest_growing)
        before, x = after, after_x
    raise AnalysisError(
        f"no Hopf point from {low:.9g} to {high:.9g}: no oscillation about the equilibrium begins "
        "to grow there"
    )


def fastest_growing(J: Array) -> complex | None:
    """The eigenvalue of an oscillation that grows most. What is slow beside the middle of all is
    none, as rounding turns a rod that may turn; beside the fastest, damping hides slow flutter."""
    s = np.linalg.eigvals(J)
    s = s[s.imag > SLOW * np.median(np.abs(s))]
    return complex(s[s.real.argmax()]) if len(s) else None


def _growth(s: complex | None) -> int | None:
    """Whether an oscillation grows (1), decays (-1), or neither but for rounding."""
    if s is None:
        return None
    return 0 if abs(s.real) <= NEUTRAL * abs(s) else int(np.sign(s.real))


def hopf_near(
    at: Callable[[float], Flow], t: float, x: Array, value: float, frequency: float, unit: float
) -> Hopf:
    """The Hopf point near a value, on an equilibrium near x, of an oscillation of about a frequency
    [rad/s]; unit: the range of values. Raises AnalysisError where it is not there."""

    def nearest(J: Array) -> complex:
        s = np.linalg.eigvals(J)
        return complex(s[np.abs(s - 1j * frequency).argmin()])

    rest = equilibrium(at(value), t, x)
    low, high = value - BESIDE * unit, value + BESIDE * unit
    try:
        return _located(at, t, rest, low, high, nearest)
    except ValueError:
        raise AnalysisError(f"no Hopf point: no oscillation crosses at {value:.9g}") from None


def _located(
    at: Callable[[float], Flow],
    t: float,
    x: Array,
    low: float,
    high: float,
    pair: Callable[[Array], complex | None],
) -> Hopf:
    def found(value: float) -> tuple[Array, complex]:
        rest = equilibrium(at(value), t, x)
        s = pair(jacobian(at(value), t, rest))
        if s is None:
            raise AnalysisError("the oscillation ceases before it begins to grow")
        return rest, s

    value = float(brentq(lambda v: found(v)[1].real, low, high, xtol=1e-14, rtol=1e-13))
    rest, s = found(value)
    step = 1e-4 * max(abs(value), abs(high - low))
    slope = (found(value + step)[1] - found(value - step)[1]) / (2 * step)
    if not abs(slope.real) > 0:
        raise AnalysisError(f"the oscillation at {value:.9g} does not cross: it only touches")
    flow = at(value)
    of = flow.quotient
    rates = np.union1d(of.led, of.velocity)
    way, c = normal_form(lambda y: jacobian(flow, t, y), rest, s.imag, of.angles, rates)
    return Hopf(value, s.imag, slope, c, rest, way)


def normal_form(
    J: Callable[[Array], Array], x: Array, frequency: float, angles: Places, rates: Places
) -> tuple[Complex, complex]:
    """The critical vector q (size,), its largest angle 1, and c; angles, rates: which of the states
    are angles, and rates of them or of places. Raises AnalysisError where the equations are not
    smooth."""
    A = J(x)
    q, p = _vectors(A, frequency)
    q = q / q[angles[np.abs(q[angles]).argmax()]]
    p = p / (p.conj() @ q).conj()
    # Rates are as large as the frequency: the others tell how far a direction goes.
    units = np.ones(len(x))
    units[rates] = frequency
    steps = (STEP, STEP / 2)
    coefficients = [_coefficient(J, x, A, q, p, frequency, units, step) for step in steps]
    c, finer = coefficients
    if abs(c - finer) > SMOOTH * abs(finer):
        raise AnalysisError(
            "no normal form: the equations are not smooth there, as with external damping or drag"
        )
    return q, c


def _vectors(A: Array, frequency: float) -> tuple[Complex, Complex]:
    s, left, right = scipy.linalg.eig(A, left=True)
    k = int(np.abs(s - 1j * frequency).argmin())
    return right[:, k], left[:, k]


def _coefficient(
    J: Callable[[Array], Array],
    x: Array,
    A: Array,
    q: Complex,
    p: Complex,
    frequency: float,
    units: Array,
    step: float,
) -> complex:
    def along(way: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """First and second derivatives of J along a direction."""
        size = float(np.abs(way / units).max())
        if not size:
            return np.zeros_like(A), np.zeros_like(A)
        h = step / size
        stack = np.array([J(x + k * h * way) for k in range(-3, 4)])
        first, second = (np.tensordot(w, stack, 1) for w in (FIRST, SECOND))
        return first / h, second / h**2

    (Ba, Caa), (Bb, Cbb) = along(q.real), along(q.imag)
    third = (Caa + Cbb) @ q
    qq, mixed = (Ba + 1j * Bb) @ q, (Ba + 1j * Bb) @ q.conj()
    still = np.linalg.lstsq(A, mixed.real, rcond=1e-10)[0]
    double = np.linalg.solve(2j * frequency * np.eye(len(A)) - A, qq)
    first = along(still)[0] @ q
    conjugate = along(double.real)[0] @ q.conj() + 1j * (along(double.imag)[0] @ q.conj())
    return complex(p.conj() @ (third - 2 * first + conjugate)) / 2
