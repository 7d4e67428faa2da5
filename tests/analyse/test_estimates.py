"""What is taken out of, and said of, long motions: a mean in the 0-1 test, errors of exponents, a
start in a section; and what deflation drives Newton's method away from."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

import rodgen
from rodgen.analyse.branches.deflation import _newton
from rodgen.analyse.chaos.lyapunov import Exponents, half_differences, standard_errors
from rodgen.analyse.chaos.poincare import zero_one_test
from rodgen.analyse.curves.curve import ContinuationProblem
from rodgen.arrays import Array
from tests.analyse.rods import ONES, rod

ROD = rod(2, "pinned")


def test_a_series_and_what_is_added_to_it_are_as_chaotic() -> None:
    """The mean drives the walk round in a circle, which is taken out of its displacement: K(x + a)
    is K(x) but for what is left of the circle at the ends of the lags."""
    x = [0.3]
    while len(x) < 2000:
        x.append(3.97 * x[-1] * (1 - x[-1]))
    plain = zero_one_test(x)
    assert plain > 0.95
    for added in (3.0, -3.0, 20.0):
        assert zero_one_test(np.array(x) + added) == pytest.approx(plain, abs=0.03)


@pytest.mark.parametrize(
    ("exponent", "error", "zero_one", "chaotic"),
    [
        (4.0, 1.0, 0.02, True),  # by its error alone
        *((2.5, 1.0, 0.98, True), (2.5, 1.0, 0.6, None), (2.5, 1.0, 0.02, False)),
        *((0.5, 1.0, 0.98, None), (0.5, 1.0, 0.6, None), (0.5, 1.0, 0.3, False)),
    ],
)
def test_a_decisive_test_judges_what_an_error_leaves_open(
    exponent: float, error: float, zero_one: float, chaotic: bool | None
) -> None:
    one, no = np.ones(1), np.nan
    of = Exponents(one * exponent, one * error, one, one, one, 0.0, zero_one, no, {}, (), scene=ROD)
    assert of.chaotic is chaotic


def test_standard_errors_of_a_series_with_a_long_memory() -> None:
    """x' = r x + noise: the variance of the mean of N is that of one times (1 + r)/(1 - r)/N. The
    memory, 50 pieces, is not short beside batches of 80. Their few numbers take a tenth off."""
    r, pieces, series = 0.98, 2000, 400
    noise = np.random.default_rng(0).standard_normal((2 * pieces, series))
    x = lfilter([1.0], [1.0, -r], noise, axis=0)[pieces:]
    true = np.sqrt((1 + r) / (1 - r) / (1 - r**2) / pieces)
    assert x.mean(axis=0).std() == pytest.approx(true, rel=0.1)  # 1/sqrt(2 * 400) is 0.035
    assert np.median(standard_errors(x)) == pytest.approx(true, rel=0.2)


def test_trends_are_what_half_the_time_would_have_changed() -> None:
    rates = np.stack((np.linspace(0, 1, 40), np.full(40, 2.0)), axis=1)
    np.testing.assert_allclose(
        np.abs(half_differences(rates)), np.abs(rates[:20].mean(0) - rates.mean(0))
    )


def test_the_start_of_a_section_is_left_out_from_the_start_of_its_run_on() -> None:
    """Of a pendulum that swings from three seconds on: crossings from five on."""
    keys = ONES | {"bending_stiffness": 0.0, "initial": {"phi": -1.5}}
    scene = rod(1, "pinned", {"gravity": {}}, integrate={"span": [3.0, 8.0]}, **keys)
    every, late = (
        rodgen.poincare_section(scene, "phi_0", either=-np.pi / 2, transient=left)["t"].values
        for left in (0.0, 2.0)
    )
    assert every.min() < 5.0
    np.testing.assert_array_equal(late, every[every >= 5.0])


class Parabola(ContinuationProblem):
    """(x - 1) (x - 2) = 0, whatever the parameter."""

    weights = np.ones(2)

    def evaluate(self, u: Array) -> tuple[Array, Array]:
        x = float(u[0])
        return np.array([(x - 1) * (x - 2)]), np.array([[2 * x - 3, 0.0]])


def test_deflation_drives_newtons_method_away_from_what_it_knows() -> None:
    """From one and the same guess next to the first zero to the other as well."""
    guess = np.array([1.1, 1.0])
    one, _ = _newton(Parabola(), guess, [])
    other, _ = _newton(Parabola(), guess, [one])
    np.testing.assert_allclose([one, other], [[1.0, 1.0], [2.0, 1.0]], rtol=1e-12)
