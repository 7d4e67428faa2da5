"""A run without an end: the steps of `simulate`, one span after the other."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import rodgen
from live.tests.open_runs import gone_on, live_of, parts
from rodgen.loading.generated_module import call_module
from rodgen.scene import Scene
from rodgen_live import live_steps
from rodgen_live.grid_recorder import GridRecorder
from rodgen_live.open_run import LiveError
from tests.palette import cases
from tests.physics.bars import PULSE, bar
from tests.sets import sets

PYTHON = ("lsoda", "radau", "dop853", "gauss", "cvode", "rk4")
COMPILED = ("dop853", "gauss", "radau", "rk4", "euler", "semi_implicit_euler", "thesis_runge_kutta")
BORDERS = (6.7, 7.28, 7.3, 8.0)  # ends of a second span, with a pulse at 7.3 s
MISSILE: dict[str, Any] = {
    "name": "missile",
    "rod": {"links": 6, "length": 5.0, "bending_stiffness": 100.0, "mass": 50.0},
    "loads": {
        "follower": {"force": "300*min(t/0.3, 1)", "angle": 0.01},  # a break point at 0.3 s
        "gravity": {},
        "internal_damping": {"coefficient": 0.01},
        "external_damping": {"coefficient": 0.5},
    },
    "initial": {"phi": "1.4+0.1*s", "velocity": [3.0, 5.0]},
    "integrate": {"span": [0.0, 1.0], "output_every": 0.01, "step": 0.002, "rtol": 1e-6},
}


WAYS = [*zip(COMPILED, "c" * 7, strict=True), *((m, "numpy") for m in (*PYTHON, "bdf"))]
OFTEN = ("dop853", "c"), ("lsoda", "numpy"), ("gauss", "c")


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("method", "target"),
    sets(OFTEN[:2], slow=[*OFTEN[2:], ("rk4", "c"), ("radau", "c")], nightly=WAYS),
)
def test_steps_are_those_of_a_run_with_an_end(method: str, target: str) -> None:
    """To the bit, whatever times are asked for: up to the end of the span steps are the same. Works
    of steps in Python are sums of as many terms, up to 3e4 J in all, in another order: a thousand
    roundings of 1e-16 of that."""
    if method == "cvode":
        pytest.importorskip("sksundae")
    scene = Scene.from_dict(MISSILE).with_integrate(method=method, rtol=1e-6, span=[0.0, 0.5])
    live = live_of(scene, target)
    t, y, work = parts(gone_on(live, 0.5))
    sol = rodgen.simulate(scene, model=live.model)
    np.testing.assert_array_equal(t, sol.t)
    np.testing.assert_array_equal(y, sol.y)
    rounded = 3e4 * 1e-13 * (target == "numpy")
    np.testing.assert_allclose(work, np.stack([*sol.work.values()], axis=1), rtol=0, atol=rounded)
    assert live.works == tuple(sol.work)
    assert (live.counts.nsteps, live.counts.nfev) == (sol.stats.nsteps, sol.stats.nfev)


@pytest.mark.compiler
@pytest.mark.parametrize(("method", "target"), sets(OFTEN[:1], slow=OFTEN[1:], nightly=WAYS))
def test_one_step_is_one(method: str, target: str) -> None:
    """Across breaks and ends of spans, after others, with one sample at its end each time."""
    scene = Scene.from_dict(MISSILE).with_integrate(span=[0.0, 0.31], step=0.01)
    scene = scene.with_integrate(method=method, rtol=1e-6)  # which gauss takes for its step
    live = live_of(scene, target)
    if method == "cvode":
        pytest.importorskip("sksundae")
    live.advance(0.25, 60.0)
    before, steps = live.t, live.counts.nsteps
    for k in range(1, 40):
        t, y, work = parts(live.one_step())
        assert live.counts.nsteps == steps + k
        assert (t.shape, y.shape, work.shape) == ((1,), (1, len(live.y)), (1, len(live.works)))
        assert t[0] == live.t > before
        np.testing.assert_array_equal(y[0], live.y)
        before = live.t
    behind = live.advance(before + 0.05, 60.0).t
    assert len(behind) in (4, 5)
    assert (behind > before).all()


@pytest.mark.compiler
def test_works_of_single_steps_are_those_of_the_run() -> None:
    """A sum of fixed steps does not depend on where samples are."""
    scene = Scene.from_dict(MISSILE).with_integrate(method="rk4", step=0.01)
    live = live_of(scene)
    for _ in range(50):
        t, y, work = parts(live.one_step())
    sol = rodgen.simulate(scene, model=live.model)
    assert t[0] == sol.t[50]
    np.testing.assert_array_equal(y[0], sol.y[50])
    np.testing.assert_array_equal(work[0], [values[50] for values in sol.work.values()])


def test_samples_stand_where_the_grid_has_them() -> None:
    """Of a time in the grid one more is there than of the double before it."""
    for start, every in ((0.0, 0.1), (-3.3, 0.7), (1e6, 1 / 60), (0.1, 1e-3)):
        tape = GridRecorder(start, every, 1, ())
        for k in (0, 1, 2, 3, 7, 1000, 123_457, 10**8 + 1):
            at = start + every * k
            assert tape.count_until(at) == k + 1
            assert tape.count_until(float(np.nextafter(at, -np.inf))) == k
    assert tape.count_until(-np.inf) == tape.count_until(np.nan) == 0
    assert tape.count_until(np.inf) > 10**15


def test_clock_holds_a_run_that_is_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten million steps are asked for; it gives up after 0.05 s of a clock that goes on by 1 ms
    with every look."""
    live = live_of(Scene.from_dict(MISSILE).with_integrate(method="rk4", step=1e-6), "numpy")
    ticks = itertools.count()
    clock = SimpleNamespace(perf_counter=lambda: 1e-3 * next(ticks))
    monkeypatch.setattr(live_steps, "time", clock)
    samples = live.advance(10.0, 0.05)
    assert 1 < live.counts.nsteps < 50
    assert (samples.t <= live.t).all()
    assert live.seconds == pytest.approx(0.05, rel=0.1)
    assert not len(live.advance(-1.0, 0.05).t)


# Loads that change in time ---------------------------------------------------------------------


def tip(force: dict[str, str], span: float, **integrate: Any) -> Scene:
    """A bar at rest under a force on its tail."""
    given = {"span": [0.0, span], "output_every": 0.1, **integrate}
    return bar(loads={"tip": force}, integrate=given)


@pytest.mark.compiler
@cases("border, method, target", BORDERS, ["dop853", "radau"], ["c", "numpy"])
def test_pulse_after_a_rest_is_felt(border: float, method: str, target: str) -> None:
    """Be it before the end of the second span or behind it, with the rest in the span
    before. An impulse J at the end of a bar turns it by 6 J/(M L); it turns meanwhile by 0.05 rad/s
    for 0.01 s, squared."""
    live = live_of(tip(PULSE, border / 2, method=method), target, 0.1)
    samples = gone_on(live, 8.5, 0.5)
    assert samples.y[-1, -1] == pytest.approx(6 * 0.05 / (3.0 * 2.0), rel=1e-5)


@pytest.mark.compiler
@cases("span, target", (0.4, 0.5, 2.5), ["c", "numpy"])
def test_switched_load_is_stepped_onto(span: float, target: str) -> None:
    """Along a straight bar of 3 kg: 9 N for a second, then -3 N; parabolas, which every method of
    order 2 has to rounding, if no step reaches across the switch, be it at the border of a span."""
    scene = tip({"x": "9 if t <= 1 else -3"}, span, method="dop853", rtol=1e-6)
    t, y, work = parts(gone_on(live_of(scene, target, 0.03), 3.0))
    after = np.maximum(t - 1.0, 0.0)
    x = np.where(t <= 1.0, 1.5 * t**2, 1.5 + 3.0 * after - 0.5 * after**2)
    v = np.where(t <= 1.0, 3.0 * t, 3.0 - after)
    np.testing.assert_allclose(y[:, 0], x, atol=1e-13)
    np.testing.assert_allclose(y[:, 3], v, atol=1e-13)
    np.testing.assert_allclose(work[:, 0], 3.0 * v**2 / 2, atol=2e-12)


@pytest.mark.compiler
@pytest.mark.parametrize("span", sets([4.0, 1.25], slow=[2.5, 1.0]))
def test_pole_is_told_as_a_run_with_an_end_tells_it(span: float) -> None:
    """Inside the first or the third span, or at the end of the first or the second."""
    scene = tip({"x": "1/(2.5 - t)"}, span, method="dop853")
    live = live_of(scene, every=0.25)
    with pytest.raises(LiveError) as caught:
        live.advance(9.0, 60.0)
    with pytest.raises(rodgen.RunError) as expected:
        rodgen.simulate(scene, model=live.model, span=[0.0, 4.0])
    assert "loads.tip.x = '1/(2.5 - t)'" in str(caught.value)
    assert str(caught.value).partition(": ")[2] == str(expected.value).partition(": ")[2]
    assert live.t == pytest.approx(2.5)
    assert len(caught.value.samples.t) == 10


# How it fails ----------------------------------------------------------------------------------


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("target", "method"), sets([("c", "rk4")], slow=[("numpy", "rk4")], nightly=[("c", "euler")])
)
def test_blow_up_is_told_and_can_be_mended(target: str, method: str) -> None:
    """With a step beyond the stability limit: in the words of `simulate`, with its samples; a
    smaller step goes on, here after a restart to a state that is no wreck."""
    scene = Scene.from_dict(MISSILE).with_integrate(method=method, step=0.05, span=[0.0, 60.0])
    scene = scene.replace({"rod.bending_stiffness": 1e5})
    live = live_of(scene, target)
    with pytest.raises(LiveError) as caught:
        live.advance(60.0, 60.0)
    with pytest.raises(rodgen.RunError) as expected, pytest.warns(rodgen.DoubtWarning) as warned:
        rodgen.simulate(scene, model=live.model)
    assert str(caught.value) == str(expected.value)
    np.testing.assert_array_equal(caught.value.samples.y, expected.value.solution.y)
    assert live.warnings() == [str(warning.message) for warning in warned]
    steps = live.counts.nsteps
    with pytest.raises(LiveError) as again:
        live.one_step()
    assert not len(again.value.samples.t)
    assert live.counts.nsteps == steps
    live.change(scene.with_integrate(method="rk4", step=1e-4))
    live.restart()
    assert live.warnings() == []
    assert gone_on(live, 0.1).t[-1] == 0.1


@pytest.mark.compiler
def test_failed_run_goes_on_where_it_is() -> None:
    """A tolerance below rounding stops bdf; dop853 goes on from there, and what comes out is the
    motion still, to ten times the tolerance of either."""
    scene = Scene.from_dict(MISSILE).with_integrate(method="bdf", rtol=2.3e-14, atol=1e-60)
    live = live_of(scene)
    with pytest.raises(LiveError) as caught:
        live.advance(1.0, 60.0)
    samples = caught.value.samples
    assert 0.01 < samples.t[-1] <= live.t < 1.0
    mended = scene.with_integrate(method="dop853", rtol=1e-9, atol=1e-10)
    live.change(mended)
    assert live.settings.method == "dop853"
    y = np.concatenate((samples.y, gone_on(live, 1.0).y))
    expected = rodgen.simulate(mended, model=live.model, rtol=1e-12).y
    np.testing.assert_allclose(y, expected, rtol=1e-8, atol=1e-8)


@pytest.mark.compiler
def test_steps_that_go_nowhere_are_stopped() -> None:
    """A link on a spring at 5e15 rad/s, whose stable steps of 1e-15 s would take a year."""
    given = {"span": [0.0, 4.0], "method": "dop853"}
    scene = bar("clamped", initial={"phi": 0.5}, integrate=given)
    live = live_of(scene.replace({"rod.bending_stiffness": 1e32}))
    while live.counts.nsteps < 9000:
        live.advance(1.0, 1e-4)
    with pytest.raises(LiveError):
        live.advance(1.0, 60.0)
    assert 10_000 <= live.counts.nsteps < 20_000


def test_jumps_of_masses_are_accounted_for() -> None:
    """A front of burning that moves along the rod, and a tank that is dropped."""
    table = {
        "name": "rocket",
        "parameters": {"slow": 1.0, "late": 0.0},
        "rod": {
            "links": 4,
            "length": 2.0,
            "bending_stiffness": 100.0,
            "mass_per_length": "4 if slow*s < t - late else 9",
        },
        "bodies": [{"name": "tank", "at": 0.6, "mass": "9 if t < 0.25 else 4"}],
        "loads": {"follower": {"force": 50.0, "angle": 0.1}, "gravity": {}},
        "initial": {"phi": "0.3*sin(4*s)", "omega": "2*s"},
        "integrate": {"method": "dop853", "rtol": 1e-10, "atol": 1e-11},
    }
    live = live_of(Scene.from_dict(table), every=0.05)
    samples = live.advance(0.9, 60.0)
    energy = sum(call_module(live.model, "energy", samples.t, samples.y, live.p))
    balance = energy - live.energy_start - samples.work.sum(axis=1)
    np.testing.assert_allclose(balance, 0.0, atol=1e-7)
