"""The 0-1 test on maps whose motion is known."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.analyse.chaos.zero_one import spaced, zero_one_test


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
    assert zero_one_test(spaced(fine)) > 0.9


def test_series_that_say_nothing() -> None:
    assert zero_one_test(np.full(200, 3.0)) == 0.0
    assert np.isnan(zero_one_test(np.append(np.ones(200), np.nan)))
