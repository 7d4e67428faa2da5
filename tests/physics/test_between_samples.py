"""States between the samples of a run: as exact as the samples, whatever the method."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import rodgen
from rodgen.integrate.dense_output import DenseOutput
from rodgen.integrate.trajectory import Changes
from rodgen.model.methods import ADAPTIVE, FIXED_STEP
from rodgen.scene import Scene
from tests.sets import sets
from tests.told import refused

TIMES = np.linspace(0.0, 1.0, 101)
RTOL, ATOL = 1e-6, 1e-8
STEPS = {"rk4": 2e-3, "thesis_runge_kutta": 2e-3, "euler": 5e-4, "semi_implicit_euler": 1e-3}
# A load that switches off between two samples, a swinging one, and an event that is recorded.
TABLE = {
    "name": "between",
    "rod": {"links": 5, "length": 2.0, "bending_stiffness": 3.0, "mass": 3.0, "boundary": "pinned"},
    "loads": {"follower": {"force": "4 if t < 0.53 else 1"}, "gravity": {}}
    | {"tip": {"y": "sin(9*t)"}},
    "initial": {"phi": "0.4*cos(pi*s)"},
    "events": [{"quantity": "phi_4", "value": 0.0}],
    "integrate": {"span": [0.0, 1.0], "output_every": 0.25, "rtol": RTOL, "atol": ATOL},
}
SCENE = Scene.from_dict(TABLE)


@cache
def _exact() -> np.ndarray:
    """States (states, K) at TIMES, to ten digits."""
    tight = {"rtol": 1e-12, "atol": 1e-13}
    return rodgen.simulate(SCENE, target="numpy", method="dop853", output_every=0.01, **tight).y.T


def _error(states: np.ndarray, at: np.ndarray) -> float:
    return float(np.abs(states - _exact()[:, at]).max())


WAYS = sets(
    [("numpy", "dop853")],
    slow=[("c", "gauss")],
    nightly=[("c", "dop853"), ("c", "radau"), *(("numpy", m) for m in ADAPTIVE)],
)


@pytest.mark.compiler
@pytest.mark.parametrize(("target", "method"), WAYS)
def test_error_is_that_of_the_tolerance(target: str, method: str) -> None:
    """Between 5 samples as at 101: the run itself, asked for all, is the measure."""
    if method == "cvode":
        pytest.importorskip("sksundae")
    every = np.arange(len(TIMES))
    dense = rodgen.simulate(SCENE, target=target, method=method, output_every=0.01)
    sol = rodgen.simulate(SCENE, target=target, method=method)
    states = sol(TIMES)
    assert states.shape == (10, 101)
    # Rates, which reach 40 rad/s, bound the absolute size of what the tolerance allows; errors of
    # two runs of the same tolerance differ by a small factor.
    assert _error(states, every) <= 3 * max(_error(dense.y.T, every), RTOL)


def test_its_tolerance_is_a_tenth_of_that_of_the_run() -> None:
    """Both parts of it: what is begun anew at a sample adds its error to that of the sample."""
    run = DenseOutput(rodgen.simulate(SCENE, target="numpy", method="dop853"))
    assert run.settings.rtol == pytest.approx(0.1 * RTOL)
    assert run.settings.atol == pytest.approx(0.1 * ATOL)


@pytest.mark.parametrize("method", sets(["rk4"], nightly=FIXED_STEP))
def test_error_of_fixed_steps_is_that_of_the_run(method: str) -> None:
    sol = rodgen.simulate(SCENE, target="numpy", method=method, step=STEPS[method])
    # What is asked for at once meets an end of the last step alone.
    some = np.array([13, 40, 60, 77])
    assert _error(sol(TIMES[some]), some) <= 2 * _error(sol.y.T, np.arange(0, 101, 25))


@pytest.fixture(scope="module")
def sol() -> rodgen.Solution:
    """With a sample each 0.01 s."""
    return rodgen.simulate(SCENE, target="numpy", output_every=0.01)


def test_shapes_and_samples_are_those_of_scipy(sol: rodgen.Solution) -> None:
    assert sol(0.405).shape == (10,)
    assert sol([]).shape == (10, 0)
    np.testing.assert_array_equal(sol(sol.t), sol.y.T)
    np.testing.assert_array_equal(sol(0), SCENE.initial_state())
    mixed = np.array([0.905, 0.105, 0.405, 0.105])
    np.testing.assert_allclose(sol(mixed)[:, 2], sol(0.405), rtol=0, atol=10 * RTOL)
    np.testing.assert_array_equal(sol(mixed)[:, 1], sol(mixed)[:, 3])


def test_other_times_are_refused(sol: rodgen.Solution) -> None:
    for t in (-1e-9, 1.0 + 1e-9, np.nan, np.inf, "now", 1j, [[0.5]]):
        assert refused(sol, t).field == "t"


def test_a_run_ended_by_an_event_ends_there() -> None:
    table = {**TABLE, "events": [{"quantity": "phi_4", "value": -0.5, "action": "stop"}]}
    sol = rodgen.simulate(Scene.from_dict(table), target="numpy", t_eval=[0.01, 0.9])
    (event,) = sol.events
    np.testing.assert_array_equal(sol(event.t), event.y)
    assert sol(event.t / 2)[4] > -0.5
    assert refused(sol, event.t + 1e-6).field == "t"


def test_a_run_that_failed_is_known_up_to_its_last_sample() -> None:
    with pytest.raises(rodgen.RunError) as found:
        rodgen.simulate(SCENE, target="numpy", method="dop853", max_steps=20, output_every=0.01)
    sol = found.value.solution
    between = (sol.t[-1] + sol.t[-2]) / 2
    assert np.isfinite(sol(between)).all()
    assert refused(sol, 1.0).field == "t"


def test_a_step_that_fails_between_samples_carries_the_run(sol: rodgen.Solution) -> None:
    lost = replace(sol, y=np.full_like(sol.y, np.nan))
    with pytest.raises(rodgen.RunError) as found:
        lost((sol.t[0] + sol.t[1]) / 2)
    assert found.value.solution is lost


def test_a_changed_run_is_refused(sol: rodgen.Solution) -> None:
    p = np.tile(sol.model.parameters(**SCENE.parameters), (len(sol.t), 1))
    changed = sol.isel(slice(None))
    changed.changes = Changes(p, np.zeros(len(sol.t)))
    assert refused(changed, 0.405)


def test_it_follows_from_a_file(sol: rodgen.Solution, tmp_path: Path) -> None:
    """From all samples or some: what was read integrates again."""
    sol.save(tmp_path / "run.nc")
    back = rodgen.load(tmp_path / "run.nc")
    assert back.stats.target == "numpy"
    np.testing.assert_array_equal(back(0.123), sol(0.123))
    few = rodgen.load(tmp_path / "run.nc", max_samples=2)
    np.testing.assert_allclose(few(0.123), sol(0.123), rtol=0, atol=20 * RTOL)


def test_a_window_far_from_the_start_has_its_own_switches(sol: rodgen.Solution) -> None:
    """Of a piece of a run, as a live one gives: its own times count, not the span."""
    piece = sol.isel(slice(52, 55))
    assert (DenseOutput(piece).first, DenseOutput(piece).last) == (sol.t[52], sol.t[54])
    np.testing.assert_allclose(piece(0.537), sol(0.537), rtol=0, atol=0)
