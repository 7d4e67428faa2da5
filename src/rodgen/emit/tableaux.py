"""Coefficients of the methods that are compiled into a module, worked out in high precision."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import mpmath
import numpy as np
import sympy
from numpy.typing import NDArray
from scipy.integrate import DOP853

from rodgen.scene.structure import COLLOCATION

DIGITS = 40
DIRECTIONS = 33


def tableaux() -> dict[str, Any]:
    """What the templates of the step loops need, as numbers that print to the last digit."""
    return {"dop853": _dop853(), "collocation": {name: _collocation(name) for name in COLLOCATION}}


def _dop853() -> dict[str, Any]:
    """Dormand and Prince's method of order 8 with its estimates of order 5 and 3 and dense output
    of order 7 (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.5, II.6)."""
    return {
        "stages": [(float(c), _terms(row)) for c, row in zip(DOP853.C, DOP853.A, strict=True)][1:],
        "more": [
            (13 + at, float(c), _terms(row))
            for at, (c, row) in enumerate(zip(DOP853.C_EXTRA, DOP853.A_EXTRA, strict=True))
        ],
        "weights": _terms(DOP853.B),
        "error5": _terms(DOP853.E5),
        "error3": _terms(DOP853.E3),
        "dense": [_terms(row) for row in DOP853.D],
        "limits": _limits(DOP853.A, DOP853.B),
    }


def _limits(A: NDArray[np.float64], b: NDArray[np.float64]) -> list[float]:
    """Radius of the stability region of a Runge-Kutta method in directions from the imaginary to
    the negative real axis: up to there the amplification is at most one, but for rounding."""
    coefficients, stage = [1.0], np.ones(len(b))
    for _ in b:
        coefficients.append(float(b @ stage))
        stage = A @ stage
    radii = np.arange(1, 12001) / 1000
    limits = []
    for angle in np.linspace(math.pi / 2, math.pi, DIRECTIONS):
        z = radii * np.exp(1j * angle)
        outside = np.abs(np.polyval(coefficients[::-1], z)) > 1 + 1e-6
        limits.append(float(radii[max(0, int(np.argmax(outside)) - 1)]))
    return limits


def _terms(row: Sequence[float]) -> list[tuple[int, float]]:
    """Coefficients that are not zero, each with its stage."""
    return [(at, float(value)) for at, value in enumerate(row) if value != 0]


# Power of the step in the error that two steps in a row tell, and by how much that is weighed, so
# that the error of a run is a tenth of the tolerance (measured, see docs/methods.md).
TWO_STEPS = {"gauss": (6.0, 7.0), "radau": (5.0, 4.5)}


def _collocation(name: str) -> Mapping[str, Any]:
    """Collocation at three nodes, transformed as in RADAU5 (Hairer, Wanner: Solving Ordinary
    Differential Equations II, IV.8): with z the stages less the state, A^-1 = T L T^-1, L holding
    a real number and a pair of complex ones."""
    with mpmath.workdps(DIGITS):
        c = _nodes(name)
        powers = mpmath.matrix(3, 3)
        integrals = mpmath.matrix(3, 3)
        for row in range(3):
            for k in range(3):
                powers[row, k] = c[row] ** k
                integrals[row, k] = c[row] ** (k + 1) / (k + 1)
        A = integrals * mpmath.inverse(powers)
        b = mpmath.lu_solve(powers.T, mpmath.matrix([mpmath.mpf(1) / (k + 1) for k in range(3)]))
        inverse = mpmath.inverse(A)
        values, vectors = mpmath.eig(inverse)
        real = min(range(3), key=lambda at: abs(values[at].imag))
        pair = max(range(3), key=lambda at: -values[at].imag)
        T = mpmath.matrix(3, 3)
        scale = vectors[2, pair]  # the last row of T is (1, 1, 0)
        for row in range(3):
            T[row, 0] = (vectors[row, real] / vectors[2, real]).real
            T[row, 1] = (vectors[row, pair] / scale).real
            T[row, 2] = (vectors[row, pair] / scale).imag
        end = inverse.T * b  # the step's end: y + sum end_i z_i
        gamma = 1 / values[real].real
        return {
            "c": _floats(c),
            "A": _rows(A),
            "b": _floats(b),
            "T": _rows(T),
            "TI": _rows(mpmath.inverse(T)),
            "real": float(values[real].real),
            "complex": (float(values[pair].real), float(-values[pair].imag)),
            "end": _floats(end),
            "error": _floats(_error(c, b, inverse, gamma)),
            "dense": _rows(_dense(c)),
            "slope": _floats(_slope(c)),
            "missing": _rows(_missing(c)),
            "power": TWO_STEPS[name][0],
            "weight": TWO_STEPS[name][1],
        }


def _nodes(name: str) -> list[Any]:
    """Zeros of the polynomial that makes the method one of order 6 (gauss) or of order 5 and
    L-stable (radau)."""
    x = sympy.Symbol("x")
    polynomial = {
        "gauss": sympy.diff((x * (x - 1)) ** 3, x, 3),
        "radau": sympy.diff(x**2 * (x - 1) ** 3, x, 2),
    }[name]
    roots = sympy.Poly(polynomial, x).nroots(n=DIGITS)
    found = sorted(mpmath.mpf(str(root)) for root in roots)
    return [mpmath.mpf(1) if abs(root - 1) < mpmath.mpf(10) ** -30 else root for root in found]


def _error(c: Any, b: Any, inverse: Any, gamma: Any) -> Any:
    """The end of the step by the quadrature of order 3 that also weighs the start by gamma, less
    the end itself, as sum error_i z_i / gamma beside h f(start)."""
    powers = mpmath.matrix(3, 3)
    for k in range(3):
        for at in range(3):
            powers[k, at] = c[at] ** k
    moments = mpmath.matrix([mpmath.mpf(1) / (k + 1) for k in range(3)])
    moments[0] -= gamma
    other = mpmath.lu_solve(powers, moments)
    return inverse.T * (other - b) / gamma


def _dense(c: Any) -> Any:
    """Coefficients of x, x^2, x^3 of the collocation polynomial less the state, from z."""
    powers = mpmath.matrix(3, 3)
    for row in range(3):
        for k in range(3):
            powers[row, k] = c[row] ** (k + 1)
    return mpmath.inverse(powers)


def _slope(c: Any) -> Any:
    """The slope of the collocation polynomial at the end of the step, from z, where the method
    does not make it that of the equations there."""
    if abs(c[2] - 1) < mpmath.mpf(10) ** -30:
        return mpmath.zeros(3, 1)
    return _dense(c).T * mpmath.matrix([1, 2, 3])


def _missing(c: Any) -> Any:
    """Coefficients of x to x^5 of what the collocation polynomial lacks, in three parts: with
    M(x) of zeros c, the integrals of M, of (x - 1/2) M, and of the parabola that takes the values
    of the first of them at c."""
    zeros = [-c[0] * c[1] * c[2], c[0] * c[1] + c[0] * c[2] + c[1] * c[2], -sum(c), mpmath.mpf(1)]
    turned = [(zeros[k - 1] if k else 0) - (zeros[k] / 2 if k < 4 else 0) for k in range(5)]
    first, second = ([part[k] / (k + 1) for k in range(len(part))] for part in (zeros, turned))
    powers = mpmath.matrix([[at**k for k in range(3)] for at in c])
    values = [sum(part * at ** (k + 1) for k, part in enumerate(first)) for at in c]
    parabola = mpmath.lu_solve(powers, mpmath.matrix(values))
    third = [parabola[k] / (k + 1) for k in range(3)]
    return mpmath.matrix([[*part, *[0] * (5 - len(part))] for part in (first, second, third)])


def _floats(values: Any) -> list[float]:
    return [float(value) for value in values]


def _rows(matrix: Any) -> list[list[float]]:
    return [[float(matrix[r, c]) for c in range(matrix.cols)] for r in range(matrix.rows)]
