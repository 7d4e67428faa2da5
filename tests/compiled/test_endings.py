"""Every way in which a compiled run can end, provoked on purpose."""

from __future__ import annotations

import os
import signal
import threading
import time
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import RunError, Scene, SceneError, StepWarning
from rodgen.integrate import Interrupted
from rodgen.integrate.methods.compiled import FAILURES
from tests.compiled.conftest import changed

ADAPTIVE = ("dop853", "radau", "gauss")


def _fails(scene: Scene, match: str, **how: Any) -> rodgen.Solution:
    with pytest.raises(RunError, match=match) as caught:
        rodgen.simulate(scene, target="c", **how)
    sol = caught.value.solution
    assert sol.status == "failed"
    assert sol.message == str(caught.value)
    assert len(sol.t) == len(sol.y) > 0
    assert np.isfinite(sol.y).all()
    return sol


@pytest.mark.parametrize("method", ADAPTIVE)
def test_load_that_stops_being_a_number(short: Scene, method: str) -> None:
    scene = changed(short, loads={"follower": {"force": "sqrt(0.5 - t)"}})
    sol = _fails(
        scene, r"stopped at t = 0\.[45].*not finite at t = 0\.5.*end the span", method=method
    )
    assert 0.45 <= sol.t[-1] <= 0.5


def test_load_that_overflows_the_state(short: Scene) -> None:
    scene = changed(short, loads={"follower": {"force": "exp(2000*t)"}})
    for method in ADAPTIVE:
        # Steps follow the rotation, which the force doubles every 0.3 ms: a matter of the budget.
        sol = _fails(scene, r"stopped at t = 0\.", method=method, max_steps=100_000)
        assert sol.t[-1] < 0.5


@pytest.mark.filterwarnings("ignore::rodgen.integrate.endings.StepWarning")
@pytest.mark.parametrize("method", ["euler", "rk4", "semi_implicit_euler", "thesis_runge_kutta"])
def test_blow_up_beyond_the_stability_limit(missile: Scene, method: str) -> None:
    _fails(missile, r"stopped at t = \d.*finite.*try a smaller step", method=method, step=0.05)


def test_a_step_beyond_the_limit_is_warned_of_before_the_run(missile: Scene) -> None:
    with (
        pytest.warns(StepWarning, match=r"the step of 0\.05 s is beyond 0\.0\d+ s.*smaller step"),
        pytest.raises(RunError),
    ):
        rodgen.simulate(missile, target="c", method="rk4", step=0.05)


def test_step_budget(missile: Scene) -> None:
    sol = _fails(missile, "budget of 50 steps is used up; raise max_steps", max_steps=50)
    assert sol.stats.steps == 50
    with pytest.raises(SceneError, match=r"integrate\.max_steps"):
        rodgen.simulate(missile, max_steps=0)


@pytest.mark.parametrize("method", ["dop853", "gauss", "radau"])
def test_step_that_becomes_too_small(missile: Scene, method: str) -> None:
    """Of states that are zero and begin to move, no error is small enough for no tolerance."""
    scene = changed(missile, initial={"phi": 0.0, "omega": 0.0, "velocity": [0.0, 0.0]})
    model = rodgen.build(scene, "c")
    p = model.parameters(**scene.parameters)
    run = model.Run(method, 0.0, scene.initial_state(), p, 1e-3, 0.0, 0.0)
    assert run.begin(1.0) == model.PAUSED
    status, _ = run.on(100, np.empty(0), np.empty((0, len(run.state))))
    assert "too small" in FAILURES[status] or "no solution" in FAILURES[status]


@pytest.mark.parametrize("method", ["radau", "gauss"])
def test_newton_that_finds_no_solution(short: Scene, method: str) -> None:
    """Changes of coordinates that are zero are asked for to 1e-300 under a force of 1e12 N: below
    the rounding of the rates, and no step is small enough."""
    scene = changed(short, loads={"follower": {"force": 1e12}}, initial={"phi": 0.0})
    match = "stopped at t = 0 s: Newton's method finds no solution.*looser tolerance"
    sol = _fails(scene, match, method=method, rtol=1e-13, atol=1e-300)
    assert sol.stats.steps == 0
    assert sol.stats.rejected is not None
    assert sol.stats.rejected > 10


def test_states_that_are_no_numbers(missile: Scene) -> None:
    model = rodgen.build(missile, "c")
    p = model.parameters(**missile.parameters)
    for method in model.COMPILED:
        run = model.Run(method, 0.0, np.full(len(model.STATE), np.inf), p, step=1e-3)
        assert run.begin(1.0) == model.NOT_FINITE
        run = model.Run(method, 0.0, missile.initial_state(), p, step=1e-3)
        assert run.begin(1.0) == model.PAUSED
        run.state[:] = np.nan
        status, _ = run.on(10**4, np.zeros(0), np.zeros((0, len(run.state))))
        assert status == model.NOT_FINITE


def test_ctrl_c_keeps_what_was_computed(missile: Scene) -> None:
    scene = changed(missile, integrate={"span": [0.0, 1e4], "output_every": 1.0, "rtol": 1e-10})
    model = rodgen.build(scene, "c")
    sent: list[float] = []

    def send() -> None:
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, send)
    timer.start()
    with pytest.raises(Interrupted) as caught:
        rodgen.simulate(scene, model=model, method="rk4", step=1e-5)
    late = time.perf_counter() - sent[0]
    assert late < 1.0  # 0.2 s are promised on a machine that has time
    sol = caught.value.solution
    assert sol.status == "interrupted"
    assert np.isfinite(sol.y).all()


def test_event_that_stops_a_run(missile: Scene) -> None:
    table = missile.model_dump(exclude_none=True)
    table["events"] = [
        {"quantity": "centre_of_gravity_y", "value": 3.0, "name": "half way"},
        {"quantity": "tip_y", "value": 4.0, "action": "stop", "name": "down"},
    ]
    scene = Scene.from_dict(table)
    ends = []
    for target, method in (("c", "dop853"), ("c", "radau"), ("numpy", "dop853")):
        sol = rodgen.simulate(scene, target=target, method=method, rtol=1e-10, atol=1e-12)
        assert sol.status == "finished"
        assert "ended at t =" in sol.message
        assert "'down'" in sol.message
        assert sol.events[-1].name == "down"
        assert sol.t[-1] == sol.events[-1].t
        assert sol.tip[-1, 1] == pytest.approx(4.0, abs=1e-12)
        assert sol.energy_error < 1e-6
        ends.append(sol.t[-1])
    # The dense outputs of three methods at a tolerance of 1e-10.
    assert np.ptp(ends) < 1e-8


def test_events_are_found_to_rounding() -> None:
    """The centre of gravity of a falling rod: t = sqrt(2 h / g), whatever the steps."""
    scene = Scene.from_dict(
        {
            "name": "fall",
            "rod": {"links": 3, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0},
            "loads": {"gravity": {"g": 9.81}},
            "integrate": {"span": [0.0, 2.0]},
            "events": [
                {"quantity": "centre_of_gravity_y", "value": -float(k)} for k in range(1, 15)
            ],
        }
    )
    exact = np.sqrt(2 * np.arange(1, 15) / 9.81)
    for method, step in (("dop853", None), ("radau", None), ("gauss", None), ("rk4", 0.01)):
        sol = rodgen.simulate(scene, target="c", method=method, step=step)
        np.testing.assert_allclose([e.t for e in sol.events], exact, rtol=0, atol=1e-12)


def test_implicit_steps_leave_a_state_of_rest(missile: Scene) -> None:
    """Errors of exactly zero for a long time, then a load: no step may follow from the zeros."""
    table = missile.model_dump(exclude_none=True)
    table["rod"] |= {"links": 1, "boundary": "clamped"}
    table["initial"], table["integrate"] = {}, {"span": [0.0, 10.0], "rtol": 1e-6}
    for force in ("0.01/(1+exp(-2000*(t-5)))", "0.01*exp(-1/t)"):
        table["loads"] = {"tip": {"y": force}}
        scene = Scene.from_dict(table)
        exact = rodgen.simulate(scene, target="c", method="dop853", rtol=1e-10)
        for method in ("radau", "gauss"):
            for target in ("c", "numpy") if method == "gauss" else ("c",):
                sol = rodgen.simulate(scene, target=target, method=method)
                assert np.abs(sol.phi - exact.phi).max() < 1e-5
                assert sol.stats.rhs > 6 * sol.stats.steps  # every step that is counted was taken


def test_a_budget_of_just_the_steps_is_enough(missile: Scene) -> None:
    for target in ("c", "numpy"):
        how: dict[str, Any] = {"target": target, "method": "rk4", "step": 1e-3}
        sol = rodgen.simulate(missile, max_steps=1000, **how)
        assert sol.t[-1] == 1.0
        with pytest.raises(RunError):
            rodgen.simulate(missile, max_steps=999, **how)


def test_a_jump_at_the_start_is_taken_on_its_far_side(short: Scene) -> None:
    jump = changed(short, loads={"follower": {"force": "0 if t <= 0 else 30"}})
    for method in ("dop853", "rk4", "radau"):
        scenes = (s.with_integrate(method=method, step=1e-3) for s in (jump, short))
        a, b = (rodgen.simulate(scene, target="c") for scene in scenes)
        # Two modules: Newton's iterations end short of the last digits, where they may differ.
        np.testing.assert_allclose(a.y, b.y, rtol=0, atol=1e-9 if method == "radau" else 1e-12)


def test_samples_wider_apart_than_the_span(missile: Scene) -> None:
    sol = rodgen.simulate(missile, target="c", output_every=1e12)
    assert list(sol.t) == [0.0, 1.0]
    assert sol.energy_error < 1e-6


def test_events_of_one_moment_are_all_recorded(missile: Scene) -> None:
    table = missile.model_dump(exclude_none=True)
    one = {"quantity": "tip_y", "value": 5.5, "direction": "rising"}
    table["events"] = [{**one, "action": "stop", "name": "end"}, {**one, "name": "seen"}]
    for target in ("c", "numpy"):
        sol = rodgen.simulate(Scene.from_dict(table), target=target, method="dop853")
        assert [event.name for event in sol.events] == ["seen", "end"]
