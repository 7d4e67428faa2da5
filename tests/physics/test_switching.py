"""Runs whose loads and rates switch by the motion, corners of the law of springs, and fronts that
move along the rod: steps end there, on either side."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.events import SwitchProgress
from rodgen.integrate.files import saver
from rodgen.integrate.files.saver import Saver
from rodgen.integrate.stepper import ChatterError
from rodgen.scene import Scene
from rodgen.scene import time_laws as course_of
from tests.palette import cases
from tests.physics.bars import bar
from tests.sets import sets
from tests.told import numbers

# A rod that turns evenly, phi = t, and integrals of what has corners and jumps, known exactly.
STATES: dict[str, Any] = {
    "clock": {"rate": 1.0},
    "bounded": {"rate": "max(0, 1 - clock)"},
    "bent": {"rate": "abs(phi(0.5) - 0.5)"},
    "jumps": {"rate": "1 if clock < 0.3 else 3*clock if clock < 1.7 else -1"},
    "saturated": {"rate": "min(0.7, clock, 1.9 - clock)"},
    "tabled": {"rate": "interp(phi(1), [0.2, 0.9], [1, 8])"},
}
ENDS = [2.0, 0.5, 1.25, 0.3 + 1.5 * (1.7**2 - 0.3**2) - 0.3, 0.835, 0.2 + 3.15 + 8 * 1.1]
ROD = {"links": 2, "length": 2.0, "mass": 3.0, "bending_stiffness": 30.0}


def _scene(**integrate: Any) -> Scene:
    table = {"name": "switching", "rod": ROD, "states": STATES, "initial": {"omega": 1.0}}
    return Scene.from_dict(table | {"integrate": {"span": [0.0, 2.0], "rtol": 1e-4} | integrate})


@pytest.mark.compiler
@cases("method, target", ["dop853", "gauss", "radau"], ["numpy", "c"])
def test_switches_cost_no_digits(method: str, target: str) -> None:
    """Between them all rates are polynomials, that every method has exactly."""
    sol = rodgen.simulate(_scene(method=method, output_every=0.5), target=target)
    # A jump is met a billionth of a step early.
    np.testing.assert_allclose(sol.y[-1, -len(ENDS) :], ENDS, rtol=0, atol=1e-9)
    assert sol.stats.nsteps < 120
    assert sol(1.0)[-5] == pytest.approx(0.5, abs=1e-12)


def test_a_load_that_switches_keeps_the_balance() -> None:
    """A thrust that is turned off when the rod has come to an angle: corners cost no energy."""
    table = {
        "name": "relay",
        "rod": ROD,
        "loads": {"follower": {"force": "30 if phi(0) < 0.8 else 0", "angle": -0.1}},
        "initial": {"omega": 1.0},
        "integrate": {"span": [0.0, 2.0], "rtol": 1e-10, "atol": 1e-12, "method": "dop853"},
    }
    sol = rodgen.simulate(Scene.from_dict(table), target="numpy")
    off = sol.phi[:, 0] > 0.8
    assert off.any()
    assert not off.all()
    assert sol.energy_error < 1e-8  # of some 30 J, and quadrature of the power


@pytest.mark.slow
@pytest.mark.compiler
def test_a_run_that_is_put_down_anywhere_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    """Before a switch, on the way onto it, and behind it."""
    scene = _scene(method="dop853", output_every=0.1)
    whole = rodgen.simulate(scene, target="c")
    out, taken, stops = tmp_path / "run.nc", [], iter(range(3, 40, 4))

    for stop in stops:
        out.unlink(missing_ok=True)
        seen = 0

        def tick(saver: Saver, now: float, stop: int = stop) -> None:
            nonlocal seen
            seen += 1
            if seen == stop:
                saver._checkpoint()
                raise KeyboardInterrupt

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Saver, "tick", tick)
            patch.setattr("rodgen.integrate.methods.compiled_integrator.FIRST", 1)
            patch.setattr("rodgen.integrate.methods.compiled_integrator.MOST", 1)
            try:
                rodgen.simulate(scene, target="c", out=out, checkpoint=1e9)
            except rodgen.Interrupted:
                taken.append(stop)
            else:
                break
        assert saver.checkpoint_path(out).exists()
        assert (rodgen.resume(out).y == whole.y).all()
    assert len(taken) > 3


# Corners and fronts -----------------------------------------------------------------------------


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("method", "target"),
    sets([("dop853", "numpy")], slow=[("gauss", "c")], nightly=[("radau", "numpy")]),
)
def test_a_link_against_a_stop(method: str, target: str) -> None:
    """A link that swings through rest at 1 rad/s, against a spring that is six times as stiff
    beyond 0.1 rad: half a period of the soft spring, and what it takes up to the stop, into it, and
    back."""
    event = {"quantity": "phi_0", "value": 0.0, "direction": "rising", "name": "back"}
    given = {"span": [0.0, 25.0], "rtol": 1e-6, "atol": 1e-8, "output_every": 5.0}
    scene = bar("clamped", initial={"omega": 1.0}, events=[event], integrate=given)
    stop = {"rod.bending_stiffness": 8.0, "rod.spring": "k*d + 5*k*max(d - 0.1, 0)"}
    sol = rodgen.simulate(scene.replace(stop), method=method, target=target)
    # A root spring of 2 EI/L against the moment of inertia M L^2/3.
    soft = np.sqrt((2 * 8.0 / 2.0) / (3.0 * 2.0**2 / 3))
    stiff, centre = np.sqrt(6.0) * soft, 0.5 / 6.0  # 6 d - 0.5 is the moment over k beyond
    up_to = np.arcsin(0.1 * soft) / soft
    speed = np.sqrt(1.0 - (0.1 * soft) ** 2)
    into = np.arctan2(speed / stiff, 0.1 - centre) / stiff
    periods = (np.pi / soft + 2 * (up_to + into)) * np.arange(1, len(sol.events) + 1)
    assert len(periods) > 4
    # What the tolerance leaves of 25 s of even swinging.
    np.testing.assert_allclose([event.t for event in sol.events], periods, atol=2e-5)


FRONT = {"name": "front", "rod": {"links": 4, "length": 2.0, "mass": 3.0, "bending_stiffness": 9.0}}


def _burning(**tables: Any) -> Scene:
    loads = {"distributed_follower": {"force_per_length": "40 if s < t/2 else 10"}}
    settings = {"span": [0.0, 1.5], "rtol": 1e-4, "output_every": 0.5}
    return Scene.from_dict(FRONT | {"loads": loads, "integrate": settings} | tables)


def test_steps_end_where_a_front_passes_a_point_of_a_link() -> None:
    """Between them the force is constant, and the impulse exact whatever the tolerance."""
    scene = _burning()
    places, weights = np.polynomial.legendre.leggauss(5)
    s = ((np.arange(4)[:, None] + (places + 1) / 2) / 4).ravel()
    np.testing.assert_allclose(scene.breaks(), 2 * s[s < 0.75], rtol=1e-15)
    sol = rodgen.simulate(scene, target="numpy", method="dop853")
    share = np.tile(weights / 2, 4) * 2.0 / 4
    pushed = share @ (10.0 * 1.5 + 30.0 * np.maximum(1.5 - 2 * s, 0.0))
    half = sol.y.shape[1] // 2
    assert sol.y[-1, half] == pytest.approx(-pushed / 3.0, rel=1e-12)


def test_a_front_in_the_mass_is_met() -> None:
    rod = FRONT["rod"] | {"mass_per_length": "3 if s > t else 1"}
    rod.pop("mass")
    scene = Scene.from_dict(FRONT | {"rod": rod, "integrate": {"span": [0.0, 0.5]}})
    assert len(scene.breaks()) == 10


def test_too_many_fronts_are_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(course_of, "MOST_FRONTS", 3)
    with pytest.warns(rodgen.DoubtWarning, match="force_per_length"):
        rodgen.simulate(_burning(), target="numpy")


# Chattering -------------------------------------------------------------------------------------


@pytest.mark.compiler
@cases("method, target", ["dop853", "gauss", "radau", "rk45"], ["numpy", "c"])
def test_a_law_that_drives_back_onto_where_it_switches_ends_the_run(
    method: str, target: str
) -> None:
    """At 0.01 s, where the relay has brought its state to zero and holds it there."""
    states = {"relay": {"rate": "-1 if relay > 0 else 1", "initial": 0.01}}
    table = {"name": "relay", "rod": ROD, "states": states, "integrate": {"span": [0.0, 0.05]}}
    with pytest.raises(rodgen.RunError, match=r"states\.relay\.rate") as caught:
        rodgen.simulate(Scene.from_dict(table), target=target, method=method)
    assert caught.value.solution.status == "chatters"
    # The dense output of a step across it has told the time: within a thousandth.
    assert numbers(caught.value)[0] == pytest.approx(0.01, rel=1e-3)


def test_rods_side_by_side_name_the_law_that_chatters() -> None:
    states = {"relay": {"rate": "-1 if relay > 0.25 else 1", "initial": 0.26}}
    table = {"name": "relay", "rod": ROD, "states": states, "integrate": {"span": [0.0, 0.05]}}
    scene = Scene.from_dict(table)
    model = rodgen.build(scene, "numpy")
    p = np.tile(model.parameters(**scene.parameters), (2, 1))
    given = {"span": [0.0, 0.05], "output_every": 0.01}
    made = rodgen.simulate_many(model, p, scene.initial_state(), keep=["max(relay)"], **given)
    assert made.status.tolist() == ["chatters", "chatters"]
    assert "states.relay.rate" in made.message[1]
    assert 0.25 in numbers(made.message[1])


def test_an_error_of_chatter_is_the_same_in_another_process() -> None:
    error = ChatterError("a law")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


@pytest.mark.parametrize(
    "rate",
    [
        "-1 if relay > 0 else -2",  # passes
        "-1 if relay > 0 else 0",  # comes to rest
        "-1 if relay > 0.001*cos(9000*t) else -0.5",  # passes often
        "-abs(relay)",  # has a corner there
    ],
)
def test_what_passes_a_switch_or_rests_on_it_is_no_chatter(rate: str) -> None:
    states = {"relay": {"rate": rate, "initial": 0.01}}
    table = {"name": "relay", "rod": ROD, "states": states, "integrate": {"span": [0.0, 0.05]}}
    assert rodgen.simulate(Scene.from_dict(table), target="numpy").status == "finished"


class Crossing:
    """A law that switches in every step; cause: its text, if it may jump there."""

    def __init__(self, cause: str):
        self._cause = cause

    def crossings(self, t: np.ndarray, *_: Any) -> list[Any]:
        return [(0, 0, (float(t[0]), float(t[1])))]

    def is_switch(self, number: int) -> bool:
        return number == 0

    def cause(self, number: int) -> str:
        return self._cause


def test_a_law_that_jumps_a_thousand_times_on_a_thousandth_of_the_way_ends_the_run() -> None:
    watch: Any = Crossing("a law")
    switching = SwitchProgress(10.0, 0.0)

    def look(at: float) -> None:
        switching.find_crossings(watch, np.array([at, at + 1e-3]), np.empty((2, 0)), None)
        switching.head_for({0: 1.0})

    for cut in range(1000):
        look(1e-9 * cut)
    with pytest.raises(ChatterError):
        look(1e-6)


def test_cuts_that_bring_nothing_pause_for_ever_longer() -> None:
    """Late in a stretch too, where what has been gone says nothing of how it goes on."""

    watch: Any = Crossing("")
    switching, t, cuts, calm = SwitchProgress(10.0, 0.0, since=5.0), 5.0, 0, []
    while t < 10.0:
        step = np.array([t, t + 1e-3])
        if switching.find_crossings(watch, step, step, None):
            assert cuts < 20_000
            switching.head_for({0: 1.0})
            switching.arrive(t + 1e-9)
            cuts, t = cuts + 1, t + 1e-9
        else:
            calm.append(t)
            t += 1e-3
    # Thousand cuts each, and pauses of 10 ms, 20 ms and so on: nine fill five seconds.
    assert 8000 <= cuts <= 10_000
    pauses = np.split(calm, np.flatnonzero(np.diff(calm) > 1.0000005e-3) + 1)
    lengths = [round(1e3 * len(one) * 1e-3) for one in pauses]
    assert lengths[:4] == pytest.approx([10, 20, 40, 80], abs=1)
