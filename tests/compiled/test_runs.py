"""Runs by compiled steps against the same runs in Python, and what they promise."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.model.methods import FIXED_STEP
from tests.compiled.conftest import WITHOUT_LOADS

METHODS = ("dop853", "radau", "gauss", "rk4")


def test_fixed_steps_agree_with_python(missile: Scene) -> None:
    for method in FIXED_STEP:
        compiled, walked = (
            rodgen.simulate(missile, target=each, method=method, step=5e-4, span=[0.25, 0.4])
            for each in ("c", "numpy")
        )
        # The same sums of rates of either target: rounding, carried along for 300 steps.
        np.testing.assert_allclose(compiled.y, walked.y, rtol=0, atol=1e-9)
        assert compiled.stats.nsteps == walked.stats.nsteps
        assert compiled.stats.nfev == walked.stats.nfev


@pytest.mark.parametrize("method", METHODS)
def test_energy_balances(missile: Scene, smooth: Scene, method: str) -> None:
    """Work is integrated with the state, energy follows from it: two routes."""
    accuracy = {"step": 1e-4} if method == "rk4" else {"rtol": 1e-9, "atol": 1e-11}
    for scene, terms in (
        (smooth, {"internal_damping", "tip_load"}),
        (missile, {"follower", "internal_damping", "external_damping"}),
    ):
        sol = rodgen.simulate(scene, target="c", method=method, **accuracy)
        assert sol.work.keys() == terms
        assert sol.energy_error < 1e-7 * max(np.ptp(work) for work in sol.work.values())


def test_samples_come_from_dense_output_and_change_no_step(missile: Scene) -> None:
    few, many = (
        rodgen.simulate(missile, target="c", method="dop853", output_every=every)
        for every in (1.0, 1e-4)
    )
    assert many.stats.nsteps == few.stats.nsteps
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


@pytest.mark.filterwarnings("ignore:gauss passes")
def test_a_run_of_nothing_that_moves(smooth: Scene, model: ModuleType) -> None:
    """Straight, at rest, without loads: no size to choose a step by, and exact zeros."""
    span = {"integrate": {"span": [0.0, 100.0], "output_every": 10.0}}
    scene = smooth.replace({**WITHOUT_LOADS, **span, "initial": {}})
    for method in ("dop853", "radau", "gauss", "auto"):
        sol = rodgen.simulate(scene, model=model, method=method)
        assert not sol.y.any()
        assert sol.stats.nsteps < 1e4
