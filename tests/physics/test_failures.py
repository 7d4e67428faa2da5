"""Runs that cannot be finished: what is said, and what is kept."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import rodgen
from rodgen.integrate import Interrupted, RunError
from rodgen.integrate.scipy_methods import ScipyStep
from rodgen.scene import Scene

Make = Callable[..., Scene]


def _with_force(scene: Scene, force: str, **integrate: object) -> Scene:
    table = scene.model_dump(exclude_none=True)
    table["loads"]["follower"] = {"force": force}
    table["integrate"] |= integrate
    return Scene.from_dict(table)


def test_explicit_method_beyond_its_stability_limit_is_stopped(make_scene: Make) -> None:
    scene = make_scene(6, "free", ("follower",), span=[0.0, 5.0])
    with pytest.raises(RunError, match=r"stopped at t = \d") as caught:
        rodgen.simulate(scene, method="euler", step=0.05)
    sol = caught.value.solution
    assert sol.status == "failed"
    assert 0 < sol.t[-1] < 5.0
    assert np.isfinite(sol.y).all()
    assert len(sol.t) == len(sol.y) == len(sol.work["follower"])


@pytest.mark.parametrize("method", ["dop853", "rk45", "radau", "bdf", "lsoda", "rk4"])
def test_force_that_is_not_finite_is_stopped_at_its_time(make_scene: Make, method: str) -> None:
    scene = make_scene(3, "free", ("follower",))
    scene = _with_force(scene, "sqrt(0.5 - t)", step=1e-3, method=method)
    with pytest.raises(RunError, match=r"stopped at t = 0\.[45].*finite") as caught:
        rodgen.simulate(scene)
    assert 0.45 < caught.value.solution.t[-1] <= 0.5
    assert np.isfinite(caught.value.solution.y).all()


def test_steps_that_go_nowhere_are_stopped(make_scene: Make) -> None:
    """LSODA creeps up to a pole with steps of 1e-18 s and would do so for ever."""
    scene = _with_force(make_scene(3, "free", ("follower",)), "1/(t - 0.5)**2", method="lsoda")
    with pytest.raises(RunError, match=r"stopped at t = 0\.[45].*(no further|finite|gave up)"):
        rodgen.simulate(scene)


def test_division_by_zero_in_a_load_is_stopped(make_scene: Make) -> None:
    scene = _with_force(make_scene(3, "free", ("follower",)), "1/(t - t)")
    with pytest.raises(RunError, match="stopped at t = 0 s"):
        rodgen.simulate(scene)


def test_interrupt_keeps_what_was_computed(make_scene: Make) -> None:
    def press_ctrl_c(t: float) -> None:
        raise KeyboardInterrupt

    scene = make_scene(4, "free", ("follower",), span=[0.0, 500.0])
    with pytest.raises(Interrupted) as caught:
        rodgen.simulate(scene, progress=press_ctrl_c)
    sol = caught.value.solution
    assert sol.status == "interrupted"
    assert 0 < sol.t[-1] < 500.0
    assert np.isfinite(sol.y).all()
    assert np.abs(sol.energy_balance).max() < 1e-6


@pytest.mark.parametrize("where", ["interpolant", "power", "rhs"])
def test_interrupt_at_any_place_leaves_whole_samples(
    make_scene: Make, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the middle of taking in a step: what is kept is what the whole run has."""
    scene = make_scene(4, "free", ("follower",), span=[0.0, 2.0], output_every=0.005)
    whole = rodgen.simulate(scene)
    model = rodgen.build(scene)
    calls = {"left": 700 if where == "rhs" else 3 if where == "power" else 60}

    def failing(right: Callable[..., object]) -> Callable[..., object]:
        def function(*arguments: object) -> object:
            calls["left"] -= 1
            if calls["left"] == 0:
                raise KeyboardInterrupt
            return right(*arguments)

        return function

    if where == "interpolant":
        right = ScipyStep.interpolant
        monkeypatch.setattr(ScipyStep, "interpolant", failing(right))
    else:
        setattr(model, where, failing(getattr(model, where)))
    with pytest.raises(Interrupted) as caught:
        rodgen.simulate(scene, model=model)
    sol = caught.value.solution
    count = len(sol.t)
    assert 1 < count < len(whole.t)
    np.testing.assert_array_equal(sol.y, whole.y[:count])
    np.testing.assert_allclose(sol.work["follower"], whole.work["follower"][:count], rtol=1e-12)


def test_too_many_links_for_the_dense_form_are_refused(make_scene: Make) -> None:
    with pytest.raises(rodgen.SceneError, match="links"):
        rodgen.simulate(make_scene(100_000))
