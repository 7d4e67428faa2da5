"""Headers of native/ with the coefficients of the compiled methods, computed in high precision;
`make docs NAME=reference` writes them, `make check ONLY=reference` compares them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import mpmath
import numpy as np
import sympy
from numpy.typing import NDArray
from scipy.integrate import DOP853

from rodgen.model.methods import (
    COLLOCATION,
    COMPILED,
    HALVED,
    LARGEST_LAST,
    MOST_PARTS,
    TABLEAUX,
    CollocationRule,
    Tableau,
    stability_polynomial,
)

DIGITS = 40
DIRECTIONS = 33
LONGEST_SUM = 12  # as in run.h


def headers() -> dict[str, str]:
    """Texts of the generated headers of native/ by file name: numbers of the methods, and their
    coefficients."""
    return {"methods.h": _methods(), "tableaux.h": _tableaux()}


def _methods() -> str:
    names = [f"    RODGEN_{name.upper()} = {number}," for number, name in enumerate(COMPILED)]
    count = f"    RODGEN_METHODS = {len(COMPILED)} /* how many there are */"
    return "\n".join([*_banner("Methods of a run"), "enum {", *names, count, "};", ""])


def _tableaux() -> str:
    dop853 = _dop853()
    parts = {
        f"struct stage stages[{len(dop853['stages'])}]": map(_stage_initialiser, dop853["stages"]),
        "struct sum weights": _sum_initialiser(dop853["weights"]),
        "struct sum error5": _sum_initialiser(dop853["error5"]),
        "struct sum error3": _sum_initialiser(dop853["error3"]),
        f"struct stage more[{len(dop853['more'])}]": map(_stage_initialiser, dop853["more"]),
        f"struct sum dense[{len(dop853['dense'])}]": map(_sum_initialiser, dop853["dense"]),
        "double largest_last": LARGEST_LAST,
        "double halved": HALVED,
        "int most_parts": str(MOST_PARTS),
        f"double limits[{DIRECTIONS}]": map(repr, dop853["limits"]),
    }
    lines = [
        *_banner("Tableaux of the methods, as run.h has their parts"),
        "static const struct tableau fixed_tableaux[] = {",
        *(
            f"    [RODGEN_{name.upper()}] = {_tableau_initialiser(of)},"
            for name, of in TABLEAUX.items()
        ),
        "};",
        "",
        "/* largest_last: of the last part of the dense output, up to which it is taken; halved:",
        "   by what half a step divides it; most_parts: of a step; limits: largest stable step",
        "   times the modulus of an eigenvalue, in directions from the imaginary to the negative",
        "   real axis. */",
        "static const struct {",
        *(f"    {part};" for part in parts),
        "} dop853 = {",
        *(f"    {_initialiser(values)}," for values in parts.values()),
        "};",
    ]
    for name, method in COLLOCATION.items():
        lines += ["", f"static const struct collocation {name} = {{"]
        lines += [f"    .{key} = {_initialiser(of)}," for key, of in _collocation(method).items()]
        lines += ["};"]
    return "\n".join(lines) + "\n"


def _banner(title: str) -> list[str]:
    return [
        f"/* {title}.",
        "",
        "   From rodgen.model.methods by tests/tableaux.py (`make docs NAME=reference`);",
        "   tests/reference.py guards it. Do not edit. */",
        "",
    ]


def _stage_initialiser(stage: tuple[float, list[tuple[int, float]]]) -> str:
    share, terms = stage
    return f"{{{share!r}, {_sum_initialiser(terms)}}}"


def _sum_initialiser(terms: list[tuple[int, float]]) -> str:
    """Initialiser of struct sum: a sum of stages."""
    if len(terms) > LONGEST_SUM:
        raise ValueError(f"a sum of {len(terms)} stages: at most {LONGEST_SUM}, see run.h")
    places, values = zip(*terms, strict=True)
    return f"{{{len(terms)}, {_initialiser(map(repr, places))}, {_initialiser(values)}}}"


def _initialiser(values: Any) -> str:
    """Numbers, or texts of them, in nested braces; a text is left as it is."""
    if isinstance(values, str):
        return values
    if isinstance(values, float):
        return repr(values)
    return f"{{{', '.join(map(_initialiser, values))}}}"


def _tableau_initialiser(tableau: Tableau) -> str:
    """Initialiser of a method of fixed step: number of its stages, whether positions follow the
    velocities, times of the stages, and a sum for every stage after the first and for the step."""
    sums = (_sum_initialiser(_terms(list(map(float, row)))) for row in tableau.rows)
    times = [float(c) for c in tableau.c]
    return _initialiser([repr(len(tableau.b)), repr(int(tableau.follow)), times, list(sums)])


def _dop853() -> dict[str, Any]:
    """Dormand and Prince's method of order 8 with its estimates of order 5 and 3 and dense output
    of order 7 (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.5, II.6)."""
    return {
        "stages": [(float(c), _terms(row)) for c, row in zip(DOP853.C, DOP853.A, strict=True)][1:],
        "more": [
            (float(c), _terms(row)) for c, row in zip(DOP853.C_EXTRA, DOP853.A_EXTRA, strict=True)
        ],
        "weights": _terms(DOP853.B),
        "error5": _terms(DOP853.E5),
        "error3": _terms(DOP853.E3),
        "dense": [_terms(row) for row in DOP853.D],
        "limits": _stability_limits(DOP853.A, DOP853.B),
    }


def _stability_limits(A: NDArray[np.float64], b: NDArray[np.float64]) -> list[float]:
    """Radius of the stability region of a Runge-Kutta method in directions from the imaginary to
    the negative real axis: up to there the amplification is at most one, but for rounding."""
    coefficients = stability_polynomial(A, b)
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


def _collocation(method: CollocationRule) -> Mapping[str, Any]:
    """Collocation at three nodes, transformed as in RADAU5 (Hairer, Wanner: Solving Ordinary
    Differential Equations II, IV.8): with z the stages less the state, A^-1 = T L T^-1, L holding
    a real number and a pair of complex ones."""
    with mpmath.workdps(DIGITS):
        c = _nodes(*method.powers)
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
            "pair": (float(values[pair].real), float(-values[pair].imag)),
            "end": _floats(end),
            "error": _floats(_error_weights(c, b, inverse, gamma)),
            "dense": _rows(_dense_weights(c)),
            "slope": _floats(_slope_weights(c)),
            "missing": _rows(_correction_terms(c)),
            "power": float(method.power),
            "weight": method.weight,
        }


def _nodes(a: int, b: int) -> list[Any]:
    """Zeros of the derivative of order a of x^a (x - 1)^b."""
    x = sympy.Symbol("x")
    roots = sympy.Poly(sympy.diff(x**a * (x - 1) ** b, x, a), x).nroots(n=DIGITS)
    found = sorted(mpmath.mpf(str(root)) for root in roots)
    return [mpmath.mpf(1) if abs(root - 1) < mpmath.mpf(10) ** -30 else root for root in found]


def _error_weights(c: Any, b: Any, inverse: Any, gamma: Any) -> Any:
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


def _dense_weights(c: Any) -> Any:
    """Coefficients of x, x^2, x^3 of the collocation polynomial less the state, from z."""
    powers = mpmath.matrix(3, 3)
    for row in range(3):
        for k in range(3):
            powers[row, k] = c[row] ** (k + 1)
    return mpmath.inverse(powers)


def _slope_weights(c: Any) -> Any:
    """The slope of the collocation polynomial at the end of the step, from z, where the method
    does not make it that of the equations there."""
    if abs(c[2] - 1) < mpmath.mpf(10) ** -30:
        return mpmath.zeros(3, 1)
    return _dense_weights(c).T * mpmath.matrix([1, 2, 3])


def _correction_terms(c: Any) -> Any:
    """Coefficients of x to x^5 of three terms that the collocation polynomial lacks: with M(x) of
    zeros c, the integrals of M, of (x - 1/2) M, and of the parabola that takes the values of the
    first of them at c."""
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
