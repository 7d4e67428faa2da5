"""Loads that change many times while the rod hardly moves: none of it may be lost."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene, StepWarning
from tests.physics.live_runs import bar
from tests.physics.sets import numbers, sets

SWITCHED = "3 if sin(2*pi*1500*t) > 0 else 0"  # 6000 times, of 4001 samples at first
SWINGING = "1 + sin(1e4*t)"
WAYS = sets(
    [("dop853", "c"), ("gauss", "numpy")],
    slow=[("radau", "c"), ("lsoda", "numpy")],
    nightly=[("gauss", "c"), ("radau", "numpy"), ("bdf", "numpy")],
)


def free(load: str, span: float, method: str, **integrate: Any) -> Scene:
    """A bar under a force along x on its tail: whatever it does else, the force's impulse is
    its momentum."""
    given = {"span": [0.0, span], "method": method, "rtol": 1e-8, **integrate}
    return bar(loads={"tip": {"x": load, "y": 0.0}}, integrate=given)


def momentum(scene: Scene, target: str) -> float:
    """Along x, at the end."""
    sol = rodgen.simulate(scene, target=target)
    _, _, phi, vx, _, omega = sol.y[-1]
    return float(3.0 * (vx - omega * math.sin(phi)))  # of the middle of 3 kg on 2 m


@pytest.mark.compiler
@pytest.mark.parametrize(("method", "target"), WAYS)
def test_load_that_switches_is_followed(method: str, target: str) -> None:
    """It is on half of the time."""
    span = 2.0 if target == "c" else 0.05
    got = momentum(free(SWITCHED, span, method), target)
    # Of rtol 1e-8, what hundreds of short steps add up.
    assert got == pytest.approx(3 * span / 2, rel=1e-6)


@pytest.mark.compiler
@pytest.mark.parametrize(("method", "target"), WAYS)
def test_load_that_swings_is_followed(method: str, target: str) -> None:
    span = 2.0 if target == "c" else 0.02
    got = momentum(free(SWINGING, span, method), target)
    impulse = span + (1 - math.cos(1e4 * span)) / 1e4
    # Half a swing has 2e-4 N s, of which three points of gauss, which judges positions, see all but
    # a hundredth; what is taken for another swing is off by a share of the whole impulse.
    assert got == pytest.approx(impulse, abs=2e-6 if method == "gauss" else 4e-7)


@pytest.mark.compiler
def test_fixed_step_that_cannot_see_a_load_is_warned_of() -> None:
    scene = free(SWINGING, 0.1, "rk4", step=5e-4)
    with pytest.warns(StepWarning) as warned:
        rodgen.simulate(scene, target="c")
    # Its period, in some digits.
    told = numbers(warned[0].message)
    assert any(number == pytest.approx(2 * math.pi / 1e4, rel=0.05) for number in told)
    rodgen.simulate(free(SWINGING, 0.1, "rk4", step=1e-4), target="c")  # nothing is said


@pytest.mark.compiler
def test_load_that_cannot_be_followed_is_warned_of() -> None:
    scene = free("sin(1e9*t)", 1.0, "rk4", step=0.1)
    with pytest.warns(StepWarning, match=r"loads\.tip\.x = 'sin\(1e9\*t\)'"):
        rodgen.simulate(scene, target="c")


def test_slow_loads_do_not_bound_steps() -> None:
    for text in ("300*min(t/0.5, 1)", "300*tanh(1000*(t-1))", "cos(t)**2 + sin(t)**2", "exp(-t)"):
        assert free(text, 5.0, "dop853").course.swing() == np.inf
    assert free("2 + sin(5*t)", 5.0, "dop853").course.swing() == pytest.approx(
        math.pi / 5, rel=1e-2
    )
