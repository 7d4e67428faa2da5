"""Gauss's method in equal steps: symmetric, so that its energy has no drift."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene, SceneError
from rodgen.integrate.diagnosis import drift_warning
from tests.compiled.conftest import SMOOTH

BENT: dict[str, Any] = {
    "name": "bent",
    "rod": {
        "links": 3,
        "length": 1.0,
        "bending_stiffness": 1.0,
        "mass": 1.0,
        "boundary": "clamped",
    },
    "initial": {"phi": "0.8*s"},
    "integrate": {"method": "gauss", "span": [0.0, 1.0], "step": 4e-3, "output_every": 0.1},
}


@pytest.fixture(scope="module")
def bent() -> Scene:
    return Scene.from_dict(BENT)


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_going_back_leads_to_the_start(bent: Scene, target: str) -> None:
    """A symmetric step undoes itself when velocities are turned; one of error control does not."""
    there = rodgen.simulate(bent, target=target)
    half = there.y.shape[1] // 2
    phi, omega = there.y[-1, :half], -there.y[-1, half:]
    initial = {"phi": phi.tolist(), "omega": omega.tolist()}
    back = Scene.from_dict(BENT | {"initial": initial})

    def missed(**how: Any) -> float:
        end = rodgen.simulate(back, target=target, **how).y[-1]
        return float(np.abs(end[:half] - there.y[0, :half]).max())

    # The error there is 1e-5; what the way back leaves is rounding, which 250 steps carry along.
    assert missed() < 1e-11
    assert missed(rtol=1e-6, atol=1e-8) > 1e-8


def test_both_targets_take_the_same_steps() -> None:
    table = SMOOTH | {"integrate": SMOOTH["integrate"] | {"method": "gauss", "step": 0.01}}
    scene = Scene.from_dict(table)
    compiled, walked = (rodgen.simulate(scene, target=target) for target in ("c", "numpy"))
    assert compiled.stats.steps == walked.stats.steps == 100
    assert not compiled.stats.rejected
    np.testing.assert_allclose(compiled.y, walked.y, rtol=0, atol=1e-11)
    exact = rodgen.simulate(scene, target="c", method="dop853", rtol=1e-12, atol=1e-13)
    # (h/2)^6: to 7e-9 in angles at this step.
    np.testing.assert_allclose(compiled.phi, exact.phi, rtol=0, atol=1e-7)


def test_states_inside_a_step_are_of_its_order_whatever_step_derivatives_are_of() -> None:
    """Both targets alike, to what rounding leaves in Newton's method; and beside DOP853."""
    off = []
    for h in (0.006, 0.003):
        times = ((np.arange(0.96 / h) + 0.2) * h).tolist()
        span = {"method": "gauss", "step": h, "span": [0.0, 0.96], "t_eval": times}
        scene = Scene.from_dict(SMOOTH | {"integrate": span})
        compiled, walked = (rodgen.simulate(scene, target=target) for target in ("c", "numpy"))
        assert compiled.stats.jacobian == walked.stats.jacobian < 20
        np.testing.assert_allclose(compiled.y, walked.y, rtol=0, atol=1e-11)
        how: dict[str, Any] = {"method": "dop853", "rtol": 1e-13, "atol": 1e-14}
        exact = rodgen.simulate(scene, target="c", **how)
        off.append(np.abs(compiled.y - exact.y).max())
    # With the derivatives of an older step in what a step lacks it was of order 5.
    assert np.log2(off[0] / off[1]) > 5.5


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_the_last_step_is_as_long_as_what_is_left(bent: Scene, target: str) -> None:
    """Three steps of 4 ms and one of 2 ms: those of a run to 12 ms and of another from there."""
    whole = rodgen.simulate(bent, target=target, span=[0.0, 0.014], output_every=0.014)
    first = rodgen.simulate(bent, target=target, span=[0.0, 0.012], output_every=0.012)
    how: dict[str, Any] = {"span": [0.012, 0.014], "output_every": 0.002, "step": 0.002}
    second = rodgen.simulate(bent, target=target, y0=first.y[-1], **how)
    assert (whole.stats.steps, first.stats.steps, second.stats.steps) == (4, 3, 1)
    np.testing.assert_allclose(whole.y[-1], second.y[-1], rtol=0, atol=1e-12)
    # One that would be a millionth of the others is not taken.
    nearly = rodgen.simulate(
        bent, target=target, span=[0.0, 0.012 * (1 + 1e-8)], output_every=0.012
    )
    assert nearly.stats.steps == 3


def test_a_step_of_another_length_has_the_error_of_order_six(bent: Scene) -> None:
    exact = rodgen.simulate(bent, method="dop853", rtol=1e-12, atol=1e-13, target="c").y[-1]
    steps = np.array([2e-3, 2.5e-3, 4e-3])
    off = [np.abs(rodgen.simulate(bent, target="c", step=h).y[-1] - exact).max() for h in steps]
    assert np.polyfit(np.log(steps), np.log(off), 1)[0] == pytest.approx(6, abs=0.3)


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_a_step_without_a_solution_ends_the_run(bent: Scene, target: str) -> None:
    with pytest.raises(rodgen.RunError, match=r"stopped at t = \d.*try a smaller step"):
        rodgen.simulate(bent, target=target, step=1.0, span=[0.0, 100.0])


def test_a_step_beside_a_tolerance_is_refused(bent: Scene) -> None:
    for name in ("rtol", "atol"):
        with pytest.raises(SceneError, match=rf"integrate\.{name} = 1e-05: must be absent beside"):
            Scene.from_dict(BENT | {"integrate": BENT["integrate"] | {name: 1e-5}})
    # Asked for beside the scene, a tolerance takes the place of its step.
    assert bent.with_integrate(rtol=1e-5).integrate.step is None
    assert not bent.with_integrate(rtol=1e-5).integrate.fixed
    with pytest.raises(SceneError, match=r"integrate\.rtol"):
        bent.with_integrate(rtol=1e-5, step=1e-3)


def test_what_auto_finds_has_error_control(bent: Scene) -> None:
    """A step that stands in the scene is for methods that have to have one."""
    assert bent.integrate.fixed
    found = bent.with_integrate(method="auto").integrated_by("gauss")
    assert (found.integrate.method, found.integrate.fixed) == ("gauss", False)
    assert bent.integrated_by("gauss").integrate.fixed  # the scene asks for it


@pytest.mark.nightly
def test_energy_is_bounded_over_many_steps(bent: Scene) -> None:
    """A tenth of the run is as good as all of it, where error control drifts with time."""
    steps = 200_000
    span: dict[str, Any] = {"span": [0.0, 2e-3 * steps], "output_every": 2e-3 * steps / 4000}
    sol = rodgen.simulate(bent, target="c", step=2e-3, **span)
    assert sol.stats.steps == steps
    off = np.abs(sol.energy.total - sol.energy.total[0])
    assert off[-400:].max() < 2 * off[:400].max()
    adaptive = rodgen.simulate(bent, target="c", rtol=1e-6, atol=1e-8, **span)
    drift = np.abs(adaptive.energy.total - adaptive.energy.total[0])
    assert drift[-400:].min() > 5 * drift[:400].max()


def test_model_names_the_method(bent: Scene) -> None:
    model: ModuleType = rodgen.build(bent, "c")
    assert model.COMPILED[-1] == "gauss_equal_steps"


def test_who_is_warned_that_energy_is_not_kept() -> None:
    """Long runs by the method that feeds a rod in which nothing damps."""
    table = BENT | {"integrate": {"method": "semi_implicit_euler", "step": 1e-3, "span": [0, 100]}}
    assert "does not keep its energy" in (drift_warning(Scene.from_dict(table)) or "")
    damped = table | {"loads": {"internal_damping": {"coefficient": 0.1}}}
    short = table | {"integrate": table["integrate"] | {"span": [0, 1]}}
    other = table | {"integrate": table["integrate"] | {"method": "rk4"}}
    for quiet in (damped, short, other):
        assert drift_warning(Scene.from_dict(quiet)) is None
