"""The 0-1 test on maps whose motion is known; Poincaré sections against a stroboscope of the linear
motion and an exact crossing."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from rodgen.analyse.chaos.poincare import decimate, zero_one_test
from rodgen.scene import Scene
from tests.analyse.rods import ONES, rod


def _logistic(r: float, count: int = 2000) -> np.ndarray:
    x, found = 0.3, []
    for _ in range(count + 500):
        x = r * x * (1 - x)
        found.append(x)
    return np.array(found[500:])


@pytest.mark.parametrize("r", [3.2, 3.5, 3.55, 3.835])
def test_periodic_maps_are_regular(r: float) -> None:
    """Windows of period 2, 4, 8 and 3 (Gottwald and Melbourne 2009, figure 1)."""
    assert abs(zero_one_test(_logistic(r))) < 0.05


@pytest.mark.parametrize("r", [3.7, 3.97, 4.0])
def test_chaotic_maps_are_chaotic(r: float) -> None:
    assert zero_one_test(_logistic(r)) > 0.95


def test_quasiperiodic_motion_is_regular() -> None:
    k = np.arange(3000)
    assert abs(zero_one_test(np.sin(0.7 * k) + np.cos(np.sqrt(5) * k) + 3.0)) < 0.05


def test_samples_that_are_too_close_are_taken_apart() -> None:
    """A chaotic series between whose values there are ninety-nine others looks regular."""
    values = _logistic(3.97, 300)
    fine = np.interp(np.arange(29900) / 100, np.arange(300), values)
    assert zero_one_test(fine) < 0.5
    assert zero_one_test(decimate(fine)) > 0.9


def test_series_that_say_nothing() -> None:
    assert zero_one_test(np.full(200, 3.0)) == 0.0
    assert np.isnan(zero_one_test(np.append(np.ones(200), np.nan)))


SMALL = 1e-3  # rad


def _pendulum() -> Scene:
    """One pinned link of 1 kg and 1 m that hangs, and swings a little."""
    start = {"phi": -np.pi / 2 + SMALL}
    settings = {"span": [0.0, 20.0], "rtol": 1e-11, "atol": 1e-13}
    return rod(1, "pinned", {"gravity": {"g": 9.81}}, **ONES, initial=start, integrate=settings)


def test_a_section_of_a_swing_is_a_stroboscope() -> None:
    """Every period from three quarters of the first on, as it swings to where it began: by the
    pendulum's elliptic integral, 1 + SMALL^2/16 of the small swing's period."""
    period = 2 * np.pi * np.sqrt(2 / (3 * 9.81)) * (1 + SMALL**2 / 16)
    found = rodgen.poincare_section(_pendulum(), "phi_0", rising=-np.pi / 2)
    times = period * (0.75 + np.arange(found.sizes["crossing"]))
    assert found.sizes["crossing"] == int((20.0 - 0.75 * period) // period) + 1
    # 1e-9: the run's own errors over 12 periods.
    np.testing.assert_allclose(found["t"].values, times, rtol=1e-9)
    np.testing.assert_allclose(found["phi"].values[:, 0], -np.pi / 2, atol=1e-14)
    np.testing.assert_allclose(found["omega"].values[:, 0], 2 * np.pi / period * SMALL, rtol=1e-6)
    strobe = rodgen.simulate(_pendulum(), span=[0.0, 20.0], t_eval=times)
    np.testing.assert_allclose(found["y"].values, strobe.y, atol=1e-11)
    np.testing.assert_allclose(found["tip"].values[:, 1], -1.0, atol=1e-12)


def test_a_section_of_a_run_is_that_of_its_scene() -> None:
    run = rodgen.simulate(_pendulum(), span=[0.0, 5.0])
    of_scene = rodgen.poincare_section(_pendulum(), "phi_0", falling=-np.pi / 2)
    of_run = rodgen.poincare_section(run, "phi_0", falling=-np.pi / 2)
    np.testing.assert_allclose(of_run["t"].values, of_scene["t"].values[: of_run.sizes["crossing"]])
    assert of_run["t"].values.max() < 5.0
