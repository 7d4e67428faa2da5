"""What steps that grow would miss: pulses, and loads that change many times while the rod hardly
moves; and what a relative tolerance must not depend on."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.errors import DoubtWarning
from rodgen.scene import Scene
from tests.palette import cases
from tests.physics.bars import PULSE, bar
from tests.sets import sets
from tests.told import numbers

TURN = 2 * np.pi

STRUCK = bar(loads={"tip": PULSE}, integrate={"span": [0.0, 10.0], "output_every": 1.0})


@cases(
    "method, target",
    *(["dop853", "gauss", "radau", "lsoda"], ["c", "numpy"]),
    where=lambda method, target: (method, target) != ("lsoda", "c"),
)
def test_pulse_upon_a_rod_at_rest_is_felt(method: str, target: str) -> None:
    """An impulse J at one end of a bar turns it by 6 J/(M L); it is short, so the bar stays where
    it is meanwhile: to the turn during the pulse, 0.05 rad/s for 0.01 s, squared. Gauss's method
    promises no rates: what it has of them is in their integral."""
    sol = rodgen.simulate(STRUCK, method=method, target=target)
    near = 2e-4 if method == "gauss" else 1e-5
    assert sol.omega[-1, 0] == pytest.approx(6 * 0.05 / (3.0 * 2.0), rel=near)
    assert abs(sol.omega[7, 0]) < 1e-20  # before it, where its tail is exp(-900)


@pytest.mark.parametrize("target", sets(["c"], slow=["numpy"]))
def test_what_rises_before_a_pulse_counts_is_felt_too(target: str) -> None:
    """Gauss's method has no stage at the end of a step: one that ends where the pulse is already
    a thousandth of its height would leave out 4e-5 of the turn, whatever the tolerance."""
    sol = rodgen.simulate(STRUCK, method="gauss", target=target, rtol=1e-10, atol=1e-12)
    tight = rodgen.simulate(STRUCK, method="dop853", target=target, rtol=1e-12, atol=1e-14)
    assert sol.phi[-1, 0] == pytest.approx(tight.phi[-1, 0], rel=1e-7)  # 5e-10 are seen


def test_fixed_step_that_is_too_long_for_a_pulse_is_warned_of() -> None:
    with pytest.warns(DoubtWarning) as warned:
        rodgen.simulate(STRUCK, method="rk4", step=0.1, target="numpy")
    assert any(7.2 <= number < 7.4 for number in numbers(warned[0].message))
    with warnings.catch_warnings():
        warnings.simplefilter("error", DoubtWarning)
        rodgen.simulate(STRUCK, method="rk4", step=0.002, target="numpy", span=[7.2, 7.4])


def _chain(turns: int) -> Scene:
    """Two links on a pin without springs, after so many turns."""
    phi = [0.1 + turns * TURN, 0.5 + turns * TURN]
    scene = bar("pinned", loads={"gravity": {"g": 9.81}})
    rod = {"rod.links": 2, "rod.bending_stiffness": 0.0, "initial.phi": phi}
    return scene.replace({**rod, "integrate": {"span": [0.0, 3.0], "output_every": 1.0}})


@cases("method, target", ["dop853", "gauss"], ["c", "numpy"])
def test_turns_cost_no_digits(method: str, target: str) -> None:
    """After 10^5 turns the tolerance is that of the motion, not of the turns: with it, Gauss's
    method would be off by 1e-4 and more. The angles have a rounding of 1e-10 then."""
    few, many = (
        rodgen.simulate(_chain(turns), method=method, target=target, rtol=1e-7, atol=1e-9)
        for turns in (0, 100_000)
    )
    np.testing.assert_allclose(many.phi - 100_000 * TURN, few.phi, rtol=0, atol=2e-5)


def test_a_rod_of_next_to_no_mass_is_refused() -> None:
    """A denormal divided by what is not is zero, and what is divided by that is no number."""
    for name in ("mass", "length"):
        with pytest.raises(rodgen.InputError, match=f"{name} = 5e-324"):
            STRUCK.replace({f"rod.{name}": 5e-324})


# Loads that change many times -------------------------------------------------------------------

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
def test_load_that_changes_often_is_followed(method: str, target: str) -> None:
    """One that is on half of the time, and one that swings."""
    span = 2.0 if target == "c" else 0.05
    got = momentum(free(SWITCHED, span, method), target)
    # Of rtol 1e-8, what hundreds of short steps add up.
    assert got == pytest.approx(3 * span / 2, rel=1e-6)
    span = 2.0 if target == "c" else 0.02
    got = momentum(free(SWINGING, span, method), target)
    impulse = span + (1 - math.cos(1e4 * span)) / 1e4
    # Half a swing has 2e-4 N s, of which three points of gauss, which judges positions, see all but
    # a hundredth; what is taken for another swing is off by a share of the whole impulse.
    assert got == pytest.approx(impulse, abs=2e-6 if method == "gauss" else 4e-7)


@pytest.mark.compiler
def test_fixed_step_that_cannot_see_a_load_is_warned_of() -> None:
    scene = free(SWINGING, 0.1, "rk4", step=5e-4)
    with pytest.warns(DoubtWarning) as warned:
        rodgen.simulate(scene, target="c")
    # Its period, in some digits.
    told = numbers(warned[0].message)
    assert any(number == pytest.approx(2 * math.pi / 1e4, rel=0.05) for number in told)
    rodgen.simulate(free(SWINGING, 0.1, "rk4", step=1e-4), target="c")  # nothing is said


@pytest.mark.compiler
def test_load_that_cannot_be_followed_is_warned_of() -> None:
    scene = free("sin(1e9*t)", 1.0, "rk4", step=0.1)
    with pytest.warns(DoubtWarning, match=r"loads\.tip\.x = 'sin\(1e9\*t\)'"):
        rodgen.simulate(scene, target="c")


def test_slow_loads_do_not_bound_steps() -> None:
    for text in ("300*min(t/0.5, 1)", "300*tanh(1000*(t-1))", "cos(t)**2 + sin(t)**2", "exp(-t)"):
        assert free(text, 5.0, "dop853").time_laws.half_period() == np.inf
    swing = free("2 + sin(5*t)", 5.0, "dop853").time_laws.half_period()
    assert swing == pytest.approx(math.pi / 5, rel=1e-2)
