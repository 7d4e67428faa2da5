"""Gauss's method in equal steps: symmetric, so that its energy has no drift."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate import Solution
from rodgen.integrate.diagnosis import drift_doubt
from rodgen.system import System
from tests.compiled.conftest import SMOOTH, WITHOUT_LOADS
from tests.told import refused

EQUAL = {"method": "gauss", "span": [0.0, 1.0], "step": 4e-3, "output_every": 0.1}
BENT = {"initial": {"phi": "0.8*s"}, "integrate": EQUAL}


@pytest.fixture(scope="module")
def bent(smooth: Scene) -> Scene:
    """A rod on a pin that swings by itself."""
    return smooth.replace(WITHOUT_LOADS | BENT)


@pytest.fixture(scope="module")
def models(model: ModuleType, bent: Scene) -> list[ModuleType]:
    """Of both targets."""
    return [model, rodgen.build(bent, "numpy")]


@pytest.mark.slow
def test_going_back_leads_to_the_start(bent: Scene, models: list[ModuleType]) -> None:
    """A symmetric step undoes itself when velocities are turned; one of error control does not."""
    for model in models:
        there = rodgen.simulate(bent, model=model)
        half = there.y.shape[1] // 2
        turned = np.concatenate((there.y[-1, :half], -there.y[-1, half:]))
        # The error there is 1e-5; what the way back leaves is rounding, which 250 steps carry.
        for how, least, most in (({}, 0.0, 1e-11), ({"rtol": 1e-6, "atol": 1e-8}, 1e-8, np.inf)):
            end = rodgen.simulate(System(bent).at(y0=turned), model=model, **how).y[-1]
            assert least < np.abs(end[:half] - there.y[0, :half]).max() < most


def test_both_targets_take_the_same_steps(smooth: Scene, models: list[ModuleType]) -> None:
    """Whatever steps derivatives are of, states inside a step are of its order."""
    off = []
    for h in (0.006, 0.003):
        times = ((np.arange(0.96 / h) + 0.2) * h).tolist()
        how: dict[str, Any] = {"span": [0.0, 0.96], "t_eval": times}
        compiled, walked = (
            rodgen.simulate(smooth, model=each, method="gauss", step=h, **how) for each in models
        )
        exact = rodgen.simulate(
            smooth, model=models[0], method="dop853", rtol=1e-13, atol=1e-14, **how
        )
        assert compiled.stats.nsteps == walked.stats.nsteps == round(0.96 / h)
        assert not compiled.stats.rejected
        assert compiled.stats.njev == walked.stats.njev < 20
        # To what rounding leaves in Newton's method.
        np.testing.assert_allclose(compiled.y, walked.y, rtol=0, atol=1e-11)
        off.append(np.abs(compiled.y - exact.y).max())
    # With the derivatives of an older step in what a step lacks it was of order 5.
    assert np.log2(off[0] / off[1]) > 5.5


def test_the_last_step_is_as_long_as_what_is_left(bent: Scene, models: list[ModuleType]) -> None:
    """Three steps of 4 ms and one of 2 ms: those of a run to 12 ms and of another from there."""
    for model in models:

        def run(start: float, end: float, model: ModuleType = model, **how: Any) -> Solution:
            span = {"span": [start, end], "output_every": end - start}
            system = System(bent).at(y0=how.pop("y0", None))
            return rodgen.simulate(system, model=model, **span, **how)

        whole, first = run(0.0, 0.014), run(0.0, 0.012)
        second = run(0.012, 0.014, y0=first.y[-1], step=0.002)
        assert (whole.stats.nsteps, first.stats.nsteps, second.stats.nsteps) == (4, 3, 1)
        np.testing.assert_allclose(whole.y[-1], second.y[-1], rtol=0, atol=1e-12)
        # One that would be a millionth of the others is not taken.
        assert run(0.0, 0.012 * (1 + 1e-8)).stats.nsteps == 3


def test_a_step_without_a_solution_ends_the_run(bent: Scene, models: list[ModuleType]) -> None:
    fast = bent.replace({"initial.omega": "30*s"})
    for model in models:
        with pytest.raises(rodgen.RunError) as caught:
            rodgen.simulate(fast, model=model, step=1.0, span=[0.0, 100.0])
        assert caught.value.solution.t[-1] < 100.0


def test_a_step_beside_a_tolerance(bent: Scene) -> None:
    """Both in a scene or both beside it are refused; a tolerance beside it takes the place of its
    step. What auto finds has error control: the step is for methods that have to have one."""
    for name in ("rtol", "atol"):
        told = refused(bent.replace, {f"integrate.{name}": 1e-5})
        assert told[:2] == (f"integrate.{name}", 1e-5)
    told = refused(bent.with_integrate, rtol=1e-5, step=1e-3)
    assert told[:2] == ("integrate.rtol", 1e-5)
    assert bent.integrate.has_fixed_step
    assert bent.with_method("gauss").integrate.has_fixed_step
    assert bent.with_integrate(rtol=1e-5).integrate.step is None
    for changed in (
        bent.with_integrate(rtol=1e-5),
        bent.with_integrate(method="auto").with_method("gauss"),
    ):
        assert (changed.integrate.method, changed.integrate.has_fixed_step) == ("gauss", False)


def test_who_is_warned_that_energy_is_not_kept() -> None:
    """Long runs by the method that feeds a rod in which nothing damps."""
    euler = {"method": "semi_implicit_euler", "step": 1e-3, "span": [0, 100]}
    scene = Scene.from_dict(SMOOTH | {"loads": {}, "parameters": {}, "integrate": euler})
    assert drift_doubt(System(scene))
    for quiet in (
        {"loads.internal_damping": {"coefficient": 0.1}},
        {"integrate.span": [0, 1]},
        {"integrate.method": "rk4"},
    ):
        assert drift_doubt(System(scene.replace(quiet))) is None
