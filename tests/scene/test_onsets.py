"""Where a load wakes up after a rest: begin, peak and end by hand."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.scene.expression import Expression
from rodgen.scene.zeros import SEEN, onsets

CELL = 10.0 / (SEEN - 1)


@pytest.mark.parametrize(("middle", "width"), [(7.3, 0.01), (2.0, 1e-3), (0.05, 1e-3)])
def test_pulse_after_a_rest(middle: float, width: float) -> None:
    """exp(-x^2) is above a thousandth within |x| < sqrt(ln 1000) = 2.63; slow tails may be cut."""
    pulse = Expression(f"-3*exp(-((t - {middle})/{width})**2)", "t")
    ((begin, peak, end),) = onsets(pulse, 0.0, 10.0)
    assert middle - 3 * width < begin < middle - width
    assert middle + width < end < middle + 3 * width
    assert peak == pytest.approx(middle, abs=2 * CELL + width / 10)


@pytest.mark.parametrize(
    "load", ["7", "sin(t)", "sin(200*t)", "300*min(t/0.5, 1)", "t**2", "1.5*sin(t)**2", "1/t"]
)
def test_what_moves_all_the_time_has_none(load: str) -> None:
    assert onsets(Expression(load, "t"), 0.0, 10.0) == ()


def test_two_pulses_and_a_switch() -> None:
    load = Expression("exp(-((t - 3)*100)**2) + exp(-((t - 6)*100)**2) + tanh((t - 8)*1e9)", "t")
    peaks = [peak for _, peak, _ in onsets(load, 0.0, 10.0)]
    np.testing.assert_allclose(peaks, [3.0, 6.0, 8.0], rtol=0, atol=2e-3)
