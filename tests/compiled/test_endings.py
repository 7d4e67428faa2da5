"""Every way in which a compiled run can end, provoked on purpose."""

from __future__ import annotations

import os
import signal
import threading
import time
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import RunError, Scene
from rodgen.integrate import Interrupted
from tests.compiled.conftest import NO_LOADS
from tests.told import numbers, refused

ADAPTIVE = ("dop853", "radau", "gauss")


@pytest.fixture(scope="module")
def built(missile: Scene) -> ModuleType:
    return rodgen.build(missile, "c")


def _fails(scene: Scene, **how: Any) -> rodgen.Solution:
    """What is there of a run that fails, whose message says when and what can be done."""
    with pytest.raises(RunError) as caught:
        rodgen.simulate(scene, target="c", **how)
    sol = caught.value.solution
    assert sol.status == "failed"
    assert sol.message == str(caught.value)
    assert len(sol.t) == len(sol.y) > 0
    assert np.isfinite(sol.y).all()
    return sol


def test_load_that_stops_being_a_number(missile: Scene) -> None:
    scene = missile.replace({"parameters.root": 30.0, "parameters.end": 0.4321})
    for method in ADAPTIVE:
        sol = _fails(scene, method=method)
        assert 0.4 <= sol.t[-1] <= 0.4321
        # When the run stopped, and when the load does: both to the digits that are printed.
        stopped, *when = numbers(sol.message)
        assert stopped == pytest.approx(0.4321, rel=1e-3)
        assert pytest.approx(0.4321, rel=1e-5) in when


def test_load_that_overflows_the_state(missile: Scene) -> None:
    scene = missile.replace({"parameters.grown": 1.0, "parameters.rate": 2000.0})
    for method in ADAPTIVE:
        # Steps follow the rotation, which the force doubles every 0.3 ms: a matter of the budget.
        sol = _fails(scene, method=method, max_steps=20_000)
        stopped, *_ = numbers(sol.message)
        assert sol.t[-1] <= stopped < 0.355  # where doubles end, exp(710)


@pytest.mark.filterwarnings("ignore::rodgen.errors.DoubtWarning")
def test_blow_up_beyond_the_stability_limit(missile: Scene) -> None:
    for method in ("euler", "rk4", "semi_implicit_euler", "thesis_runge_kutta"):
        sol = _fails(missile, method=method, step=0.2, span=[0.0, 20.0])
        assert 0.0 <= sol.t[-1] < 20.0


def test_step_budget(missile: Scene) -> None:
    sol = _fails(missile, max_steps=5)
    assert sol.stats.nsteps == 5
    assert "max_steps" in sol.message
    told = refused(rodgen.simulate, missile, max_steps=0)
    assert told[:2] == ("integrate.max_steps", 0)
    for target in ("c", "numpy"):  # a budget of just the steps is enough
        how: dict[str, Any] = {"target": target, "method": "rk4", "step": 1e-2}
        assert rodgen.simulate(missile, max_steps=100, **how).t[-1] == 1.0
        with pytest.raises(RunError):
            rodgen.simulate(missile, max_steps=99, **how)


def test_step_that_becomes_too_small(missile: Scene, built: ModuleType) -> None:
    """Of states that are zero and turn by the rounding of a force of 1e12 N along the rod, no error
    is small enough for no tolerance."""
    force = {"parameters.old": 1e12, "loads.follower.angle": 0.0}
    scene = missile.replace({**force, "initial": {}})
    p = built.parameters(**scene.parameters)
    for method in ADAPTIVE:
        run = built.Run(method, 0.0, scene.initial_state(), p, 1e-3, 0.0, 0.0)
        assert run.begin(1.0) == built.PAUSED
        status, _ = run.advance(1000, np.empty(0), np.empty((0, len(run.state))))
        assert status in (-2, -3)  # the step is too small, or Newton's method has no solution


@pytest.mark.filterwarnings("ignore:gauss passes")
def test_newton_that_finds_no_solution(missile: Scene) -> None:
    """Changes of coordinates that are zero are asked for to 1e-300 under a force of 1e12 N: below
    the rounding of the rates, and no step is small enough."""
    force = {"parameters.P": 0.0, "parameters.old": 1e12, "parameters.new": 1e12}
    scene = missile.replace({**force, "initial": {"velocity": [3.0, 5.0]}})
    for method in ("radau", "gauss"):
        sol = _fails(scene, method=method, rtol=1e-13, atol=1e-300)
        assert sol.t[-1] == sol.stats.nsteps == 0
        assert (sol.stats.rejected or 0) > 10


def test_states_that_are_no_numbers(missile: Scene, built: ModuleType) -> None:
    p = built.parameters(**missile.parameters)
    for method in built.COMPILED:
        run = built.Run(method, 0.0, np.full(len(built.STATE), np.inf), p, step=1e-3)
        assert run.begin(1.0) == built.NOT_FINITE
        run = built.Run(method, 0.0, missile.initial_state(), p, step=1e-3)
        assert run.begin(1.0) == built.PAUSED
        run.state[:] = np.nan
        status, _ = run.advance(10**4, np.zeros(0), np.zeros((0, len(run.state))))
        assert status == built.NOT_FINITE


def test_ctrl_c_keeps_what_was_computed(missile: Scene, built: ModuleType) -> None:
    scene = missile.with_integrate(span=[0.0, 1e4], output_every=1.0, method="rk4", step=1e-5)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.monotonic()
    with pytest.raises(Interrupted) as caught:
        rodgen.simulate(scene, model=built)
    assert time.monotonic() - begin < 60.0  # 0.2 s after the signal, on a machine that has time
    sol = caught.value.solution
    assert sol.status == "interrupted"
    assert sol.t[-1] < 1e4
    assert np.isfinite(sol.y).all()


def test_event_that_stops_a_run(missile: Scene) -> None:
    """Behind one of the same moment, which is recorded too."""
    events = [
        {"quantity": "centre_of_gravity_y", "value": 3.0, "name": "half way"},
        {"quantity": "tip_y", "value": 4.0, "action": "stop", "name": "down"},
        {"quantity": "tip_y", "value": 4.0, "name": "seen"},
    ]
    scene = missile.replace({"events": events})
    ends = []
    for target, method in (("c", "dop853"), ("c", "radau"), ("numpy", "dop853")):
        sol = rodgen.simulate(scene, target=target, method=method, rtol=1e-10, atol=1e-12)
        assert sol.status == "finished"
        assert "'down'" in sol.message
        assert [event.name for event in sol.events[-2:]] == ["seen", "down"]
        assert sol.t[-1] == sol.events[-1].t < 1.0
        assert sol.tip[-1, 1] == pytest.approx(4.0, abs=1e-12)
        assert sol.energy_error < 1e-6
        ends.append(sol.t[-1])
    # The dense outputs of three methods at a tolerance of 1e-10.
    assert np.ptp(ends) < 1e-8


def test_events_are_found_to_rounding(missile: Scene, built: ModuleType) -> None:
    """The centre of gravity of a falling rod: t = sqrt(2 h / g), whatever the steps."""
    heights = np.arange(1, 15)
    events = [{"quantity": "centre_of_gravity_y", "value": -float(h)} for h in heights]
    given = {"initial": {}, "integrate.span": [0.0, 2.0], "events": events}
    falling = missile.replace({**NO_LOADS, **given})
    exact = np.sqrt(2 * heights / 9.81)
    for method, step in (("dop853", None), ("radau", None), ("gauss", None), ("rk4", 0.01)):
        sol = rodgen.simulate(falling, model=built, method=method, step=step)
        np.testing.assert_allclose([e.t for e in sol.events], exact, rtol=0, atol=1e-12)


def test_implicit_steps_leave_a_state_of_rest() -> None:
    """Errors of exactly zero for a long time, then a load: no step may follow from the zeros."""
    rod = {"links": 1, "length": 5.0, "bending_stiffness": 100.0, "mass": 50.0}
    force = "late/(1 + exp(-2000*(t - 5))) + smooth*exp(-1/t)"
    for late, smooth in ((0.01, 0.0), (0.0, 0.01)):
        scene = Scene(
            name="rest",
            rod={**rod, "boundary": "clamped"},
            loads={"tip": {"y": force}},
            parameters={"late": late, "smooth": smooth},
            integrate={"span": [0.0, 10.0], "rtol": 1e-6},
        )
        exact = rodgen.simulate(scene, target="c", method="dop853", rtol=1e-10)
        for target, method in (("c", "radau"), ("c", "gauss"), ("numpy", "gauss")):
            sol = rodgen.simulate(scene, target=target, method=method)
            assert np.abs(sol.phi - exact.phi).max() < 1e-5
            assert sol.stats.nfev > 6 * sol.stats.nsteps  # every step that is counted was taken


def test_a_jump_at_the_start_is_taken_on_its_far_side(missile: Scene, built: ModuleType) -> None:
    given = {"parameters.P": 0.0, "parameters.new": 30.0, "integrate.step": 1e-3}
    scenes = [missile.replace({**given, "parameters.jump": at}) for at in (0.0, -1.0)]
    for method in ("dop853", "rk4", "radau"):
        settings = (scene.replace({"integrate.method": method}) for scene in scenes)
        a, b = (rodgen.simulate(scene, model=built) for scene in settings)
        # Newton's iterations end short of the last digits, where they may differ.
        np.testing.assert_allclose(a.y, b.y, rtol=0, atol=1e-9 if method == "radau" else 1e-12)


def test_samples_wider_apart_than_the_span(missile: Scene, built: ModuleType) -> None:
    sol = rodgen.simulate(missile, model=built, output_every=1e12)
    assert list(sol.t) == [0.0, 1.0]
    assert sol.energy_error < 1e-6
