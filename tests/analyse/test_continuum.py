"""Continuum references against collocation, shooting, quadrature and published tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import quad, solve_bvp, solve_ivp
from scipy.linalg import eigvals
from scipy.special import jn_zeros

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.references.columns import (
    Onset,
    beck,
    hauger,
    leipholz,
    thrust,
    thrust_frequencies,
)
from rodgen.analyse.references.continuum import (
    chain_frequency,
    linear_own_weight,
    linear_tip_force,
    natural_frequency,
    wave_number,
)
from rodgen.analyse.references.elastica import Tip, axial_force, own_weight, tip_force
from tests.analyse.rods import numbers


def _collocated(p: float, points: int = 22) -> np.ndarray:
    """Omega^2 of y'''' + p (x y')' = Omega^2 y, y'' = y''' = 0 at both ends: Chebyshev collocation
    (Trefethen, Spectral Methods in MATLAB, 2000, ch. 6), boundary conditions in place of the outer
    rows. Rising moduli, those of the two rigid motions first."""
    theta = np.pi * np.arange(points) / (points - 1)
    x = np.cos(theta)
    c = np.where((x == x[0]) | (x == x[-1]), 2.0, 1.0) * (-1.0) ** np.arange(points)
    D = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(points))
    D = 2 * (D - np.diag(D.sum(axis=1)))  # on [0, 1], from its end to its start
    powers = [np.linalg.matrix_power(D, k) for k in range(5)]
    A, B = powers[4] + p * D @ np.diag((x + 1) / 2) @ D, np.eye(points)
    for row, condition in ((0, powers[2]), (1, powers[3]), (-1, powers[2]), (-2, powers[3])):
        A[row], B[row] = condition[0 if row >= 0 else -1], 0
    values = eigvals(A, B)
    values = values[np.isfinite(values) & (np.abs(values) < 1e9)]
    return values[np.argsort(np.abs(values))]


@pytest.mark.parametrize("k", [1, 2, 17, 50])
def test_wave_numbers_solve_their_equations_to_the_last_digit(k: int) -> None:
    with mp.workdps(50):
        free, clamped, pinned = (
            wave_number(name, k, digits=40) for name in ("free", "cantilever", "pinned")
        )
        slope = mp.cosh(free)  # of cos x cosh x at its roots, but for a factor of about 1
        assert abs(mp.cos(free) * mp.cosh(free) - 1) < slope * mp.mpf(10) ** -37
        assert abs(mp.cos(clamped) * mp.cosh(clamped) + 1) < slope * mp.mpf(10) ** -37
        assert abs(mp.tan(pinned) - mp.tanh(pinned)) < mp.mpf(10) ** -37
        # Root k is near (k + 1/2) pi, (k - 1/2) pi, (k + 1/4) pi: none is left out.
        near = [(x / mp.pi - k) for x in (free, clamped, pinned)]
        np.testing.assert_allclose([float(x) for x in near], [0.5, -0.5, 0.25], atol=0.1)


def test_frequencies_have_units() -> None:
    rod = {"mass": 20.0, "length": 5.0, "bending_stiffness": 100.0}
    first = 4.73004074**2 / (2 * np.pi) * np.sqrt(100 / (20 / 5 * 5.0**4))
    assert natural_frequency("free", 1, **rod) == pytest.approx(first, rel=1e-8)
    zeros = jn_zeros(0, 3)  # SciPy's: another algorithm
    found = [chain_frequency(k, length=2.0) for k in (1, 2, 3)]
    np.testing.assert_allclose(found, zeros / (4 * np.pi) * np.sqrt(9.81 / 2), rtol=1e-14)


def _at_the_tail(i: int, j: int, tilt: int) -> Any:
    """y'(1) v(1) - int xi^tilt y' v': of a tangential force at the tail."""
    return j - mp.mpf(i * j) / max(i + j - 1 + tilt, 1)


def _all_along(i: int, j: int, power: int) -> Any:
    """int (1 - xi)^power y'' v: of a tangential force along the rod, whose resultant from a place
    to the free end goes as the power."""
    return j * (j - 1) * mp.beta(i + j - 1, power + 1)


def _newton_step(
    first: int, load: Callable[[int, int, int], Any], tilt: int, size: int, p: Any, w: Any
) -> list[float]:
    """Relative step of Newton's method to the double root of the weak form with the polynomials
    xi^first, xi^(first + 1), ...: int y'' v'' + p times the work of the load = w^2 int y v, whose
    natural conditions are those of a free end. Not the differential equation, and it converges
    superexponentially."""

    def entry(i: int, j: int) -> tuple[Any, Any, Any]:
        bend = mp.mpf(i * (i - 1) * j * (j - 1)) / max(i + j - 3, 1)
        return bend, load(i, j, tilt), mp.mpf(1) / (i + j + 1)

    k = range(first, first + size)
    B, P, M = (mp.matrix([[entry(i, j)[c] for j in k] for i in k]) for c in range(3))

    def det(p: Any, w: Any) -> Any:
        return mp.det(B + p * P - w**2 * M)

    e = mp.mpf(10) ** -15
    at, up, down, right = det(p, w), det(p, w + e), det(p, w - e), det(p + e, w)
    slope = (up - down) / (2 * e)
    twist = ((det(p + e, w + e) - det(p + e, w - e)) / (2 * e) - slope) / e
    jacobian = mp.matrix([[(right - at) / e, slope], [twist, (up - 2 * at + down) / e**2]])
    step = mp.lu_solve(jacobian, mp.matrix([-at, -slope]))
    return [float(abs(step[0] / p)), float(abs(step[1] / w))]


@pytest.mark.parametrize(
    ("onset", "first", "load", "tilt", "size", "published"),
    [
        # Beck 1952, and most books since, to as many digits as they print.
        (beck, 2, _at_the_tail, 0, 13, (20.05, 11.016)),
        # 109.9 is quoted from Beal 1965; 23.1 is the mean of the two frequencies at p = 109.
        pytest.param(thrust, 0, _at_the_tail, 1, 21, (109.9, 23.1), marks=pytest.mark.nightly),
        # 40.05 of Leipholz 1963, in most books since. Critical forces of rods are held against it
        # and Hauger's too, in less time.
        pytest.param(leipholz, 2, _all_along, 1, 15, (40.05, None), marks=pytest.mark.nightly),
        pytest.param(hauger, 2, _all_along, 2, 17, (None, None), marks=pytest.mark.nightly),
    ],
)
def test_flutter(
    onset: Callable[..., Onset],
    first: int,
    load: Callable[[int, int, int], Any],
    tilt: int,
    size: int,
    published: tuple[float | None, float | None],
) -> None:
    """To 16 digits; the weak form agrees to 26 with 26 polynomials."""
    found, at = onset(), onset(digits=30)
    for value, known in zip(found, published, strict=True):
        assert known is None or value == pytest.approx(known, rel=3e-3)
    # Of other rounding and other steps; a float is right to its last digit.
    np.testing.assert_array_equal([float(x) for x in at], found)
    with mp.workdps(70):
        assert max(_newton_step(first, load, tilt, size, *at)) < 1e-16


def test_frequencies_under_thrust() -> None:
    for p in (-100.0, 0.0, 60.0, 109.0):
        route = np.sqrt(_collocated(p)[2:5].real)
        np.testing.assert_allclose(thrust_frequencies(p, 3), route, rtol=1e-6)
    free = [wave_number("free", k) ** 2 for k in (1, 2, 3)]
    np.testing.assert_allclose(thrust_frequencies(0, 3), free, rtol=1e-15)


def _integrated(load: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """x, y, theta at the tip for theta'' = -load(s) cos(theta), by SciPy's collocation."""
    s = np.linspace(0, 1, 101)
    run = solve_bvp(
        lambda s, w: np.array([w[1], -load(s) * np.cos(w[0]), np.cos(w[0]), np.sin(w[0])]),
        lambda a, b: np.array([a[0], b[1], a[2], a[3]]),
        s,
        np.array([1.2 * s * (2 - s), 2.4 * (1 - s), s, 0 * s]),
        tol=1e-10,
        max_nodes=20000,
    )
    assert run.success
    return run.y[[2, 3, 0], -1]


@pytest.mark.parametrize("load", [0.01, 8.0, pytest.param(60.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("solve", "rise"), [(tip_force, 0), (own_weight, 1)])
def test_elastica(solve: Callable[..., Tip], rise: int, load: float) -> None:
    """The tolerance is that of the collocation."""
    found = solve(load)
    np.testing.assert_allclose(found, _integrated(lambda s: load * (1 - s) ** rise), atol=2e-10)


@pytest.mark.parametrize("load", [2.4675, 8.0, 60.0])
def test_columns_by_shooting_from_the_tip(load: float) -> None:
    """theta'' = -load sin(theta) from the angle of the tip ends at the clamp with zero."""
    tip = axial_force(load)
    run = solve_ivp(
        lambda s, w: (w[1], -load * np.sin(w[0]), np.cos(w[0]), np.sin(w[0])),
        (0, 1),
        (tip.angle, 0.0, 0.0, 0.0),
        "DOP853",
        rtol=1e-13,
        atol=1e-15,
    )
    # What the integrator loses near the tip grows by cosh(sqrt(load)), 1200 at the largest.
    np.testing.assert_allclose(run.y[[0, 2, 3], -1], (0.0, tip.x, tip.y), atol=1e-10)


def test_flutter_in_si_units() -> None:
    """EI/L^2 = 4 N, sqrt(EI/(M L^3)) = 0.2 rad/s."""
    force, frequency = beck().dimensional(mass=20.0, length=5.0, bending_stiffness=100.0)
    assert force == pytest.approx(4.0 * beck().load, rel=1e-14)
    assert frequency == pytest.approx(0.2 * beck().frequency / (2 * np.pi), rel=1e-14)


def test_columns_bend_from_eulers_load_on() -> None:
    """theta_1^2 = 8 (load / Euler's - 1) next to it, and all digits are there."""
    euler = mp.mpf(np.pi) ** 2 / 4  # just below: pi is cut off
    assert axial_force(euler) == axial_force(0) == Tip(1.0, 0.0, 0.0)
    with mp.workdps(60):
        angle = axial_force((1 + mp.mpf("1e-12")) * mp.pi**2 / 4, digits=30).angle
        assert abs(angle**2 / mp.mpf("8e-12") - 1) < 1e-11  # the next term


@pytest.mark.parametrize("solve", [tip_force, own_weight])
def test_elastica_to_many_digits(solve: Callable[..., Tip]) -> None:
    short, long = solve("2", digits=17), solve("2", digits=22)
    with mp.workdps(22):
        assert max(abs(a - b) for a, b in zip(short, long, strict=True)) < mp.mpf(10) ** -16
    assert solve(0) == Tip(1.0, 0.0, 0.0)
    assert 1.4 < solve(40).angle < np.pi / 2


def test_small_deflections_are_linear() -> None:
    """By virtual work, the tip moves by the integral of M(s) (1 - s) / EI; so does the elastica,
    which differs by the square of the load."""
    rod = {"length": 2.0, "bending_stiffness": 5.0}
    force, weight = linear_tip_force(force=3.0, **rod), linear_own_weight(load=3.0, **rod)
    assert force.deflection == pytest.approx(quad(lambda s: 3 * (2 - s) ** 2 / 5, 0, 2)[0])
    assert force.slope == pytest.approx(quad(lambda s: 3 * (2 - s) / 5, 0, 2)[0])
    assert weight.deflection == pytest.approx(quad(lambda s: 1.5 * (2 - s) ** 3 / 5, 0, 2)[0])
    assert weight.slope == pytest.approx(quad(lambda s: 1.5 * (2 - s) ** 2 / 5, 0, 2)[0])
    e = 1e-6
    unit = {"length": 1, "bending_stiffness": 1}
    for tip, line in (
        (tip_force(e), linear_tip_force(force=e, **unit)),
        (own_weight(e), linear_own_weight(load=e, **unit)),
    ):
        np.testing.assert_allclose((tip.y, tip.angle), line, rtol=1e-11)


@pytest.mark.nightly
def test_beyond_flutter_there_is_no_frequency() -> None:
    """The error names the load at which it begins, to its six digits."""
    with pytest.raises(AnalysisError) as error:
        thrust_frequencies(110, 1)
    assert thrust().load == pytest.approx(numbers(error.value)[-1], rel=1e-5)
