"""Where a load wakes up after a rest: begin, peak and end by hand."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen import SceneError
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


BUMP = "exp(-((t - 3)*100)**2)"


@pytest.mark.parametrize(
    ("text", "a", "b"),
    [
        (f"-(2*{BUMP}/5 - 7)", -0.4, 7.0),
        (f"g*(1 + {BUMP}*g)", 9.0, 3.0),
        (f"4 - +{BUMP}", -1.0, 4.0),
        (f"0*{BUMP} + 1", 1.0, 0.0),
        (f"{BUMP}/(g - 3)**2 if t < 0 else {BUMP}", 1.0, 0.0),
    ],
)
def test_pulses_are_a_matter_of_what_changes(text: str, a: float, b: float) -> None:
    """By hand, what it is multiplied by and what is added; where it is multiplied by zero it is
    not taken apart, and has no pulse."""
    whole = Expression(text, "t", numbers=(("g", 3.0),))
    core, *found = whole.affine()
    assert found == pytest.approx([a, b], abs=1e-15)
    times = np.linspace(0.0, 10.0, 101)
    np.testing.assert_allclose(a * core(times) + b, whole(times), rtol=1e-15, atol=1e-15)
    alone = Expression(BUMP, "t").pulses(0.0, 10.0)
    assert len(alone) == 1
    assert whole.pulses(0.0, 10.0) == (() if text.startswith("0") else alone)


def test_a_swing_is_one_beside_the_whole_load() -> None:
    """A ripple that is smaller than a millionth of the load from sample to sample is none."""
    assert Expression("2*sin(50*t)", "t").swing(0.0, 10.0) == pytest.approx(np.pi / 50, rel=0.1)
    assert Expression("300 + 1e-5*sin(50*t)", "t").swing(0.0, 10.0) == np.inf


def test_other_values_of_the_numbers_are_checked_and_leave_the_first_alone() -> None:
    first = Expression("a*t + 1/a", "t", numbers=(("a", 2.0), ("b", 1.0)))
    other = first.with_values({"a": 4.0, "b": 7.0})
    assert (float(first(1.0)), float(other(1.0))) == (2.5, 4.25)
    assert other == Expression("a*t + 1/a", "t", numbers=(("a", 4.0),))
    with pytest.raises(SceneError):
        first.with_values({"a": 0.0})
