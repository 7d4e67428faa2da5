"""Continuum references against weak forms, shooting, quadrature and published tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import quad, solve_ivp
from scipy.special import jn_zeros

from rodgen.analyse.references.continuum import (
    chain_frequency,
    linear_own_weight,
    linear_tip_force,
    natural_frequency,
    wave_number,
)
from rodgen.analyse.references.elastica import Tip, axial_force, own_weight, tip_force
from rodgen.analyse.references.follower_columns import (
    FlutterPoint,
    beck,
    hauger,
    leipholz,
    thrust,
    thrust_frequencies,
)


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


def _weak_form(first: int, load: Callable[[int, int, int], Any], tilt: int, size: int) -> Any:
    """B, P and M of int y'' v'' + p times the work of the load = w^2 int y v for the polynomials
    xi^first, xi^(first + 1), ..., whose natural conditions are those of a free end. Not the
    differential equation, and it converges superexponentially."""

    def entry(i: int, j: int) -> tuple[Any, Any, Any]:
        bend = mp.mpf(i * (i - 1) * j * (j - 1)) / max(i + j - 3, 1)
        return bend, load(i, j, tilt), mp.mpf(1) / (i + j + 1)

    k = range(first, first + size)
    return [mp.matrix([[entry(i, j)[c] for j in k] for i in k]) for c in range(3)]


def _newton_step(weak_form: Any, p: Any, w: Any) -> list[float]:
    """Relative step of Newton's method to the double root of the weak form."""
    B, P, M = weak_form

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
    onset: Callable[..., FlutterPoint],
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
        assert max(_newton_step(_weak_form(first, load, tilt, size), *at)) < 1e-16


def test_frequencies_under_thrust() -> None:
    """Powers of x are nearly dependent: they are made orthogonal with many digits."""
    with mp.workdps(60):
        B, P, M = _weak_form(0, _at_the_tail, 1, 14)
        T = mp.inverse(mp.cholesky(M))
        B, P = (np.array((T * one * T.T).tolist(), dtype=float) for one in (B, P))
    for p in (-100.0, 0.0, 60.0, 109.0):
        squares = sorted(np.linalg.eigvals(B + p * P), key=abs)
        route = np.sqrt(np.real(squares[2:5]))
        np.testing.assert_allclose(thrust_frequencies(p, 3), route, rtol=1e-6)
    free = [wave_number("free", k) ** 2 for k in (1, 2, 3)]
    np.testing.assert_allclose(thrust_frequencies(0, 3), free, rtol=1e-15)


@pytest.mark.parametrize(
    ("solve", "load"),
    [
        *((solve, load) for solve in (tip_force, own_weight) for load in (0.01, 8.0)),
        *((axial_force, load) for load in (2.4675, 8.0, 60.0)),
        *(pytest.param(solve, 60.0, marks=pytest.mark.slow) for solve in (tip_force, own_weight)),
    ],
)
def test_elastica_by_shooting_from_the_tip(solve: Callable[..., Tip], load: float) -> None:
    """theta'' = -load cos(theta), less towards the tip of its own weight, and -load sin(theta) of a
    column, from the angle of the tip ends at the clamp with zero."""
    tip = solve(load)

    def rates(s: float, w: Any) -> tuple[float, ...]:
        across = np.sin(w[0]) if solve is axial_force else np.cos(w[0])
        share = s if solve is own_weight else 1.0
        return w[1], -load * share * across, np.cos(w[0]), np.sin(w[0])

    run = solve_ivp(rates, (0, 1), (tip.angle, 0.0, 0.0, 0.0), "DOP853", rtol=1e-13, atol=1e-15)
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
