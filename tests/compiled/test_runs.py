"""Runs by compiled steps against the same runs in Python, and what they promise."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate import Solution
from rodgen.model.methods import FIXED_STEP
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.compiled.conftest import WITHOUT_LOADS
from tests.palette import cases

METHODS = ("dop853", "radau", "gauss", "rk4")


def _both(scene: Scene, **how: Any) -> list[Solution]:
    return [rodgen.simulate(scene, target=target, **how) for target in ("c", "numpy")]


def test_fixed_steps_agree_with_python(missile: Scene) -> None:
    for method in FIXED_STEP:
        compiled, walked = _both(missile, method=method, step=5e-4, span=[0.25, 0.4])
        # The same sums of rates of either target: rounding, carried along for 300 steps.
        np.testing.assert_allclose(compiled.y, walked.y, rtol=0, atol=1e-9)
        assert compiled.stats.steps == walked.stats.steps
        assert compiled.stats.rhs == walked.stats.rhs


@pytest.mark.parametrize(
    "method", ["dop853", pytest.param("radau", marks=pytest.mark.nightly), "gauss"]
)
def test_adaptive_methods_agree_with_python(missile: Scene, method: str) -> None:
    """Radau is SciPy's, Gauss's coefficients are worked out another way."""
    compiled, walked = _both(missile, method=method, rtol=1e-8, atol=1e-10)
    # Errors of some hundred steps at these tolerances, in rates of up to 100 rad/s.
    np.testing.assert_allclose(compiled.phi, walked.phi, rtol=0, atol=1e-6)
    for term, work in compiled.work.items():
        scale = max(1.0, np.abs(work).max())
        np.testing.assert_allclose(work, walked.work[term], rtol=0, atol=1e-6 * scale)


def _balances(scene: Scene, method: str, model: ModuleType | None = None) -> Solution:
    """Work is integrated with the state, energy follows from it: two routes."""
    accuracy = {"step": 1e-4} if method == "rk4" else {"rtol": 1e-9, "atol": 1e-11}
    scene = scene.with_integrate(method=method, **accuracy)
    sol = rodgen.simulate(scene, target=None if model else "c", model=model)
    scale = max(np.ptp(work) for work in sol.work.values())
    assert sol.energy_error < 1e-7 * scale
    return sol


@pytest.mark.parametrize("method", METHODS)
def test_energy_balances(missile: Scene, smooth: Scene, model: ModuleType, method: str) -> None:
    assert _balances(smooth, method, model).work.keys() == {"internal_damping", "tip_load"}
    dampings = {"internal_damping", "external_damping"}
    assert _balances(missile, method).work.keys() == {"follower", *dampings}


@pytest.mark.slow
@cases("method, boundary, inertia", METHODS, BOUNDARIES, INERTIAS)
def test_energy_balances_under_every_load(
    missile: Scene, method: str, boundary: str, inertia: str
) -> None:
    loads = {"loads.tip": {"x": 3.0, "y": 2.0}, "loads.follower.force": 300.0}
    rod = {"rod.boundary": boundary, "rod.inertia": inertia}
    initial = {} if boundary == "free" else {"initial": {"phi": 0.3}}
    sol = _balances(missile.replace({"parameters": {}, **loads, **rod, **initial}), method)
    assert sol.work.keys() == {"follower", "internal_damping", "external_damping", "tip_load"}


def test_samples_come_from_dense_output_and_change_no_step(missile: Scene) -> None:
    few, many = (
        rodgen.simulate(missile, target="c", method="dop853", output_every=every)
        for every in (1.0, 1e-4)
    )
    assert many.stats.steps == few.stats.steps
    assert many.y[-1].tobytes() == few.y[-1].tobytes()
    exact = rodgen.simulate(missile, target="c", rtol=1e-12, atol=1e-13, output_every=1e-4)
    assert np.abs(many.phi - exact.phi).max() < 1e-7


@pytest.mark.parametrize("method", METHODS)
def test_break_points_are_stepped_onto(missile: Scene, method: str) -> None:
    """A force that is switched at 0.3 s: nothing of the run before it may know of it, and the
    error is that of a smooth run."""
    accuracy = {"step": 1e-4} if method == "rk4" else {"rtol": 1e-10, "atol": 1e-12}
    numbers = {"parameters.P": 0.0, "parameters.old": 300.0, "parameters.new": -100.0}
    scene = missile.replace(numbers).with_integrate(method=method, **accuracy)
    whole = rodgen.simulate(scene, target="c")
    steady = scene.replace({"parameters.new": 300.0}).with_integrate(span=[0.0, 0.3])
    first = rodgen.simulate(steady, target="c")
    at = len(first.t) - 1
    assert whole.t[at] == pytest.approx(0.3, abs=1e-15)
    # One is a sum of steps of output_every, the other the end of a span.
    np.testing.assert_allclose(whole.y[at], first.y[-1], rtol=1e-12, atol=1e-12)
    exact = rodgen.simulate(scene, target="numpy", method="dop853", rtol=1e-12, atol=1e-13)
    assert np.abs(whole.phi - exact.phi).max() < 1e-7


def test_gauss_keeps_energy_over_many_steps(smooth: Scene, model: ModuleType) -> None:
    span = {"integrate": {"span": [0.0, 200.0], "output_every": 0.2}}
    scene = smooth.replace({**WITHOUT_LOADS, **span, "initial": {"phi": "0.3*cos(pi*s)"}})
    sol = rodgen.simulate(scene, model=model, method="gauss", rtol=1e-6, atol=1e-6)
    drift = np.abs(sol.energy.total / sol.energy.total[0] - 1)
    assert drift.max() < 1e-3
    assert drift[-100:].max() < 2 * drift[:500].max() + 1e-6


def test_a_run_of_nothing_that_moves(smooth: Scene, model: ModuleType) -> None:
    """Straight, at rest, without loads: no size to choose a step by, and exact zeros."""
    span = {"integrate": {"span": [0.0, 100.0], "output_every": 10.0}}
    scene = smooth.replace({**WITHOUT_LOADS, **span, "initial": {}})
    for method in ("dop853", "radau", "gauss", "auto"):
        sol = rodgen.simulate(scene, model=model, method=method)
        assert not sol.y.any()
        assert sol.stats.steps < 1e4
