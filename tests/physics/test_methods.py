"""Every method against the others, and the orders of those of fixed step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.methods import fixed_step, scipy_methods
from rodgen.scene import Scene
from rodgen.scene.structure import TERMS
from rodgen.scene.tables import ADAPTIVE, FIXED_STEP

Make = Callable[..., Scene]
SMOOTH = ("follower", "gravity", "internal_damping")


def test_scene_and_integrators_know_the_same_methods() -> None:
    assert tuple(fixed_step.METHODS) == FIXED_STEP
    assert set(scipy_methods.METHODS) | {"gauss", "cvode"} == set(ADAPTIVE)


@pytest.mark.parametrize(
    ("method", "order"), [("euler", 1), ("semi_implicit_euler", 1), ("rk4", 4)]
)
def test_measured_order(make_scene: Make, method: str, order: int) -> None:
    """Slope of the error against the step, fitted over four steps; the reference is Radau's."""
    scene = make_scene(3, "free", SMOOTH, output_every=0.5, span=[0.0, 0.5])
    exact = rodgen.simulate(scene, method="radau", rtol=1e-12, atol=1e-13).y[-1]
    counts = np.array([1000, 2000, 4000, 8000]) if order == 1 else np.array([80, 120, 180, 270])
    errors = [
        np.abs(rodgen.simulate(scene, method=method, step=0.5 / c).y[-1] - exact).max()
        for c in counts
    ]
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.2)


def test_semi_implicit_euler_keeps_energy_bounded_where_euler_does_not(make_scene: Make) -> None:
    scene = make_scene(2, "cantilever", initial={"phi": 0.05, "omega": 0.0}, span=[0.0, 5.0])
    start = rodgen.simulate(scene).energy.total[0]
    drift = {
        method: abs(rodgen.simulate(scene, method=method, step=2e-3).energy.total[-1] / start - 1)
        for method in ("euler", "semi_implicit_euler")
    }
    assert drift["semi_implicit_euler"] < 0.05
    assert drift["euler"] > 10 * drift["semi_implicit_euler"]


@pytest.mark.parametrize("method", ADAPTIVE)
def test_adaptive_methods_agree_with_rk4(make_scene: Make, method: str) -> None:
    scene = make_scene(3, "free", SMOOTH, output_every=0.1, span=[0.0, 0.5])
    rk4 = rodgen.simulate(scene, method="rk4", step=5e-4)
    loose = {"rk23": 1e-8, "bdf": 1e-9}.get(method, 1e-10)
    sol = rodgen.simulate(scene, method=method, rtol=loose, atol=loose / 10)
    # Errors of the steps add up: some thousand steps at the tolerance.
    np.testing.assert_allclose(sol.y, rk4.y, atol=3e3 * loose + 1e-7)
    assert sol.stats.rhs > sol.stats.steps > 0
    if method in ("radau", "bdf"):
        assert sol.stats.jacobian > 0
        assert sol.stats.factorisations > 0


def test_samples_between_steps_are_as_good_as_those_on_them(make_scene: Make) -> None:
    scene = make_scene(3, "free", SMOOTH, span=[0.0, 0.3])
    fine = rodgen.simulate(scene, output_every=0.3 / 7)
    exact = rodgen.simulate(scene, method="radau", rtol=1e-12, atol=1e-13, output_every=0.3 / 7)
    np.testing.assert_allclose(fine.y, exact.y, atol=1e-7)
    on_steps = rodgen.simulate(scene, method="rk4", step=1e-3, output_every=0.1)
    between = rodgen.simulate(scene, method="rk4", step=0.97e-3, output_every=0.1)
    np.testing.assert_allclose(on_steps.y, between.y, atol=1e-6)


@pytest.mark.parametrize("how", [{"rtol": 1e-11}, {"method": "rk4", "step": 2.5e-4}], ids=str)
def test_break_points_are_stepped_onto(make_scene: Make, how: dict[str, Any]) -> None:
    """A force that jumps in the middle of the span: two runs joined give the same."""
    scene = make_scene(3, "free", ("follower",))
    table = scene.model_dump(exclude_none=True)
    table["loads"]["follower"]["force"] = "40 if t < 0.437 else -20"
    jumping = Scene.from_dict(table)
    assert jumping.breaks() == [pytest.approx(0.437, abs=1e-12)]
    whole = rodgen.simulate(jumping, **how)
    table["loads"]["follower"]["force"] = 40.0
    table["integrate"]["span"] = [0.0, 0.437]
    first = rodgen.simulate(Scene.from_dict(table), rtol=1e-11)
    table["loads"]["follower"]["force"] = -20.0
    table["integrate"]["span"] = [0.437, 1.0]
    end = first.y[-1]
    table["initial"] = {
        "position": end[:2].tolist(),
        "phi": end[2:5].tolist(),
        "velocity": end[5:7].tolist(),
        "omega": end[7:].tolist(),
    }
    second = rodgen.simulate(Scene.from_dict(table), rtol=1e-11)
    # rk4's error at this step is 1e-8; one stage on the wrong side of the jump makes it 1e-3.
    np.testing.assert_allclose(whole.y[-1], second.y[-1], rtol=0, atol=1e-7)


def test_runs_are_reproducible(make_scene: Make) -> None:
    scene = make_scene(4, "free", TERMS)
    one, two = rodgen.simulate(scene), rodgen.simulate(scene)
    np.testing.assert_array_equal(one.y, two.y)
