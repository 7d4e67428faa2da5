"""Runs that cannot be finished: what is said, and what is kept."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

import rodgen
from rodgen.errors import DoubtWarning
from rodgen.integrate import Interrupted, RunError
from rodgen.integrate.methods.python_steppers import ScipyStep
from rodgen.scene import Scene
from tests.sets import Make, sets


def _with_force(scene: Scene, force: str, **integrate: object) -> Scene:
    return scene.replace({"loads.follower": {"force": force}}).with_integrate(**integrate)


def _blames(error: RunError, load: str, at: float, within: float) -> None:
    """A load is named, and the time at which it is not finite, behind that where the run ends."""
    times = [float(number) for number in re.findall(r"t = (\S+) s", str(error))]
    assert load in str(error)
    assert times[1:] == pytest.approx([at], abs=within)


def test_explicit_method_beyond_its_stability_limit_is_stopped(make_scene: Make) -> None:
    scene = make_scene(3, "free", ("follower",), span=[0.0, 5.0])
    with pytest.warns(DoubtWarning, match="euler"), pytest.raises(RunError) as caught:
        rodgen.simulate(scene, method="euler", step=0.05)
    sol = caught.value.solution
    assert sol.status == "failed"
    assert 0 < sol.t[-1] < 5.0
    assert np.isfinite(sol.y).all()
    assert len(sol.t) == len(sol.y) == len(sol.work["follower"])


POLES = {
    "1/t": 0.0,
    "1/sin(t)": 0.0,
    "1/(t - t)": 0.0,
    "1/(t - 0.5)": 0.5,  # the end of a step
    "1/(t - 0.2505)": 0.2505,  # the middle of a step
    "1/(t - 0.30013)": 0.30013,  # nowhere that a step of fixed length would see
    "40 if t < 0.2 else 1/abs(t - 0.4)": 0.4,
    "1/(t - 0.3) if t > 0.3 else 0": 0.3,  # a break point, finite before
    "sqrt(0.5 - t)": 0.5,  # no number from then on
}


BY_EQUAL_STEPS = [("rk4", force) for force in POLES]
BREAK = "1/(t - 0.3) if t > 0.3 else 0"


# Methods that choose their steps creep up to a pole, which takes time.
@pytest.mark.parametrize(
    ("method", "force"),
    sets(
        [*BY_EQUAL_STEPS[-4:-2], ("dop853", "sqrt(0.5 - t)")],
        slow=[*BY_EQUAL_STEPS, ("rk45", BREAK), ("lsoda", BREAK)],
        nightly=product(["rk45", "lsoda"], POLES),
    ),
)
def test_division_by_zero_in_a_load_is_reported_with_its_time(
    make_scene: Make, method: str, force: str
) -> None:
    at = POLES[force]
    scene = _with_force(make_scene(3, "free", ("follower",)), force, method=method, step=1e-3)
    with pytest.raises(RunError) as caught:
        rodgen.simulate(scene)
    # Of what is no number from a time on, the time is that of a step.
    within = 0.01 if "sqrt" in force else 1e-8
    _blames(caught.value, f"loads.follower.force = {force!r}", at, within)
    assert caught.value.solution.t[-1] <= at
    assert np.isfinite(caught.value.solution.y).all()


def test_pole_far_ahead_is_not_blamed(make_scene: Make) -> None:
    """Euler's method leaves its stability limit long before the force is not finite."""
    scene = make_scene(3, "free", ("follower",), span=[0.0, 500.0])
    scene = _with_force(scene, "40 + 1/(t - 499.3)", method="euler", step=0.05)
    with pytest.warns(DoubtWarning), pytest.raises(RunError) as caught:
        rodgen.simulate(scene)
    assert "loads." not in str(caught.value)


def test_zero_that_divides_nothing_in_the_end_stops_no_run(make_scene: Make) -> None:
    scene = _with_force(make_scene(3, "free", ("follower",)), "min(1/(t - 0.5)**2, 100)")
    sol = rodgen.simulate(scene)
    assert sol.status == "finished"
    assert abs(sol.energy_balance).max() < 1e-6


@pytest.mark.parametrize("where", sets(["rhs"], slow=["interpolant", "power"]))
def test_interrupt_at_any_place_leaves_whole_samples(
    make_scene: Make, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the middle of taking in a step: what is kept is what the whole run has."""
    scene = make_scene(3, "free", ("follower",), span=[0.0, 2.0], output_every=0.005)
    whole = rodgen.simulate(scene)
    model = rodgen.build(scene)
    calls = {"left": 700 if where == "rhs" else 1 if where == "power" else 60}

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
    assert sol.status == "interrupted"
    count = len(sol.t)
    assert 1 < count < len(whole.t)
    np.testing.assert_array_equal(sol.y, whole.y[:count])
    np.testing.assert_allclose(sol.work["follower"], whole.work["follower"][:count], rtol=1e-12)


def test_too_many_links_for_the_dense_form_are_refused(make_scene: Make) -> None:
    with pytest.raises(rodgen.InputError, match="links = 100000"):
        rodgen.build(make_scene(100_000), form="dense")


@pytest.mark.filterwarnings("ignore:gauss passes")
@pytest.mark.parametrize(
    ("method", "target"),
    sets(
        [("gauss", "numpy")], slow=[("radau", "c")], nightly=[("dop853", "numpy"), ("gauss", "c")]
    ),
)
def test_rates_beyond_all_numbers_stop_a_run(make_scene: Make, method: str, target: str) -> None:
    scene = make_scene(3, "free", rod={"length": 1e-59}, span=[0.0, 0.1])
    with pytest.raises(RunError) as caught:
        rodgen.simulate(scene, method=method, target=target)
    assert caught.value.solution.status == "failed"
