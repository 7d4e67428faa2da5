"""A run without an end that is changed, kicked and restarted while it goes on."""

from __future__ import annotations

import gc
import math
import tracemalloc
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from live.tests.open_runs import live_of, parts
from rodgen.errors import InputError
from rodgen.loading.generated_module import call_module
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene import Scene
from rodgen_live import open_run as live_module
from tests.palette import cases
from tests.physics.bars import bar
from tests.sets import Make, sets

# Methods of every kind, with what they need to be right to some 1e-9 on slow motions.
METHODS = [
    ("dop853", "c", {"rtol": 1e-11}),
    ("gauss", "c", {"rtol": 1e-11}),
    ("radau", "c", {"rtol": 1e-11}),
    ("rk4", "c", {"step": 1e-3}),
    ("lsoda", "c", {"rtol": 1e-11}),
    ("dop853", "numpy", {"rtol": 1e-11}),
    ("radau", "numpy", {"rtol": 1e-9}),
    ("gauss", "numpy", {"rtol": 1e-11}),
    ("bdf", "c", {"rtol": 1e-9}),
    ("cvode", "numpy", {"rtol": 1e-11}),
]
# Between what is asked for [s], and how many from change to change.
OFTEN, SELDOM = (0.0137, 1), (0.25, 1)
pytestmark = pytest.mark.compiler


def oscillator(stiffness: float, **integrate: Any) -> Scene:
    """A link of 3 kg and 2 m on a spring of 2 EI/L: I phi'' = -2 EI/L phi, with I = M L^2/3."""
    given = {"span": [0.0, 4.0], "atol": 1e-13, **integrate}
    scene = bar("clamped", initial={"phi": 0.5}, integrate=given)
    return scene.replace({"rod.bending_stiffness": stiffness})


def swung(stiffness: float, t: Any, phi: float, omega: float) -> tuple[Any, Any]:
    """Angle and rate of the oscillator at times after it had these."""
    w = math.sqrt(2 * stiffness / 2.0 / (3.0 * 2.0**2 / 3))
    c, s = np.cos(w * t), np.sin(w * t)
    return phi * c + omega / w * s, omega * c - w * phi * s


@pytest.mark.parametrize(
    ("how", "frames"),
    sets(
        [(0, OFTEN), (3, SELDOM), (7, SELDOM)],
        slow=[(1, OFTEN), (2, SELDOM), (4, (0.0137, 16)), (6, OFTEN)],
        nightly=product(range(len(METHODS) - 2), (OFTEN, SELDOM, (0.0137, 16))),
    ),
)
def test_motion_after_changes_is_exact(how: int, frames: tuple[float, int]) -> None:
    """A spring that is made stiffer and weaker: harmonic motions put together where `here` says
    that the change was, within a sample of what was asked for last. Twelve changes, each with an
    error of the tolerance in a state of 0.5 rad and 5 rad/s, and rk4's of (w h)^4/120 in every
    radian: 1e-7. Each puts in half the difference of the stiffness times the angle squared."""
    (method, target, settings), (frame, count) = METHODS[how], frames
    scenes = [oscillator(EI, method=method, **settings) for EI in (30.0, 90.0, 10.0)]
    live = live_of(scenes[0], target)
    to, at, phi, omega, given = 0.0, 0.0, 0.5, 0.0, 0.0
    for k in range(12):
        EI, other_EI = (scenes[j % 3].rod.bending_stiffness for j in (k, k + 1))
        for _ in range(count):
            to += frame
            samples = live.advance(to, 60.0)
            expected = swung(EI, samples.t - at, phi, omega)
            np.testing.assert_allclose(samples.y.T, expected, rtol=0, atol=1e-7)
        live.change(scenes[(k + 1) % 3])
        (now,), y, _ = parts(live.here())
        assert abs(now - to) <= 0.01
        phi, omega = swung(EI, now - at, phi, omega)
        np.testing.assert_allclose(y[0], (phi, omega), rtol=0, atol=1e-7)
        at, given = now, given + (other_EI - EI) * phi**2 / 2  # 2 EI/L times phi^2/2, L = 2 m
        assert live.given == pytest.approx(given, abs=1e-4)
    energy = sum(live.model.energy(live.y, live.p))
    assert energy - live.energy_start == pytest.approx(live.given, abs=1e-4)


# The balance -----------------------------------------------------------------------------------


# A balance over many seconds: one of each kind of steps often, all of them at night.
@pytest.mark.parametrize("how", sets([0], slow=[1], nightly=range(len(METHODS))))
def test_balance_stays_small(make_scene: Make, how: int) -> None:
    """Over changes of every parameter, kicks, and methods that take turns: energies of some 50 J
    with errors of the tolerance in every step, rk4's of the step's fourth power: 1e-5 J. The
    changes put in a thousand times that, each."""
    method, target, settings = METHODS[how]
    if method == "cvode":
        pytest.importorskip("sksundae")
    settings = {"atol": 1e-12, "span": [0.0, 1.0], **settings}
    scene = make_scene(5, terms=THESIS_TERMS, method=method, **settings)
    live = live_of(scene, target)
    changes: list[dict[str, Any]] = [
        *({"rod.bending_stiffness": 60.0}, {"rod.mass": 2.0}, {"rod.length": 2.5}),
        {"loads.gravity": {"g": 3.0}},
        {"loads.follower": {"force": 25.0, "angle": -0.2}},
        {"loads.external_damping": {"coefficient": 1.0}},
        {"integrate.method": "dop853", "integrate.rtol": 1e-10},
        {"integrate.method": "rk4", "integrate.step": 2e-4},
    ]
    to, jumps = 0.0, []
    for k, change in enumerate(changes):
        to += 0.07
        samples = live.advance(to, 60.0)
        energy = sum(live.model.energy(samples.y, live.p))
        balance = energy - live.energy_start - samples.work.sum(axis=1) - live.given
        assert np.abs(balance).max() < 1e-5
        before = live.given
        scene = scene.replace(change)
        live.change(scene)
        jumps.append(live.given - before)
        live.kick(k % 4, 0.5, (0.5, 1.0))
        jumps.append(live.given - before - jumps[-1])
    assert np.sum(np.abs(jumps) > 1e-2) >= 8 + 4
    assert np.abs(samples.work[-1]).max() > 1.0
    live.restart()
    assert (live.t, live.given, live.seconds, live.counts.nsteps) == (0.0, 0.0, 0.0, 0)
    samples = live.advance(0.05, 60.0)
    energy = sum(live.model.energy(samples.y, live.p))
    assert np.abs(energy - live.energy_start - samples.work.sum(axis=1)).max() < 1e-5


@pytest.mark.parametrize("boundary", ["pinned", "clamped", "cantilever"])
def test_balance_stays_small_where_the_base_moves_otherwise(
    make_scene: Make, boundary: str
) -> None:
    """From a change of its course on; errors of steps at this tolerance are 1e-11 of some 5 J."""
    turning = {} if boundary == "pinned" else {"angle": "0.3*sin(2*t)"}
    base = {"x": "0.2*sin(3*t)", "y": "0.1*t", **turning}
    scene = make_scene(4, boundary, ("gravity",), method="dop853").replace({"base": base})
    live, given = live_of(scene, "numpy"), []
    changes = {"base.x": "0.3*sin(5*t)", "base.y": "0.4*t", "rod.mass": 2.0}
    for to, (key, value) in enumerate(changes.items(), 1):
        samples = live.advance(0.1 * to, 60.0)
        energy = sum(call_module(live.model, "energy", samples.t, samples.y, live.p))
        balance = energy - live.energy_start - samples.work.sum(axis=1) - live.given
        assert np.abs(balance).max() < 1e-9
        scene = scene.replace({key: value})
        live.change(scene)
        given.append(live.given)
        live.kick(3, 0.5, (0.5, 1.0))
    assert np.abs(samples.work[-1]).max() > 0.1
    assert np.abs(np.diff(given)).min() > 0.1


# What stays as it is ---------------------------------------------------------------------------


def test_what_is_refused_leaves_the_run_as_it_was(make_scene: Make) -> None:
    """To the bit, beside a twin that nobody has asked; and a restart gives the same bits."""
    scene = make_scene(5, terms=THESIS_TERMS, method="dop853")
    live, twin = live_of(scene), live_of(scene)
    for run in (live, twin):
        first = run.advance(0.2, 60.0)
    for link, share, impulse, field in (
        (5, 0.5, (1.0, 0.0), "kick.link"),
        (-1, 0.5, (1.0, 0.0), "kick.link"),
        (True, 0.5, (1.0, 0.0), "kick.link"),
        (1, 1.5, (1.0, 0.0), "kick.share"),
        (1, math.nan, (1.0, 0.0), "kick.share"),
        (1, 0.5, (math.inf, 0.0), "kick.impulse"),
        (1, 0.5, (1.0, "2"), "kick.impulse"),
        (1, 0.5, (1.0, 0.0, 0.0), "kick.impulse"),
        (1, 0.5, (1e300, 0.0), "kick.impulse"),
    ):
        with pytest.raises(InputError, match=f"^{field} = "):
            live.kick(link, share, impulse)
    for terms, links in ((THESIS_TERMS[:3], 5), (THESIS_TERMS, 4)):
        for asked in (live.change, live.restart):
            with pytest.raises(InputError, match=r"^scene = "):
                asked(make_scene(links, terms=terms))
    for every in (0.0, -1.0, math.nan):
        with pytest.raises(InputError, match=r"^every = "):
            live.sample_every(every)
    live.change(scene.replace({"initial.phi": 1.0}))  # of which a restart alone knows
    for a, b in zip(parts(live.advance(1.3, 60.0)), parts(twin.advance(1.3, 60.0)), strict=True):
        np.testing.assert_array_equal(a, b)
    assert live.given == 0.0
    live.restart()
    np.testing.assert_array_equal(live.y[2:7], 1.0)
    live.kick(0, 0.0, (1.0, 1.0))
    live.restart(scene)
    for a, b in zip(parts(live.advance(0.2, 60.0)), parts(first), strict=True):
        np.testing.assert_array_equal(a, b)


def test_other_times_between_samples() -> None:
    """From the last one on; the motion goes on."""
    live = live_of(oscillator(30.0, method="dop853", rtol=1e-11))
    live.sample_every(0.02)
    first = live.advance(0.31, 60.0)
    (at,) = live.here().t
    live.sample_every(0.125)
    second = live.advance(1.1, 60.0)
    assert live.every == 0.125
    np.testing.assert_allclose(first.t, 0.02 * np.arange(16))
    np.testing.assert_allclose(second.t, at + 0.125 * np.arange(1, 7))
    for samples in (first, second):
        expected = swung(30.0, samples.t, 0.5, 0.0)
        np.testing.assert_allclose(samples.y.T, expected, atol=1e-9)


@pytest.mark.slow
def test_auto_is_asked_now_and_then(monkeypatch: pytest.MonkeyPatch, make_scene: Make) -> None:
    """Once at the start, not for what a slider passes within a while, and once after it."""
    asked, clock = [], [0.0]
    choose = live_module.choose
    monkeypatch.setattr(live_module, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
    monkeypatch.setattr(live_module, "choose", lambda *a: (asked.append(a), choose(*a))[1])
    terms, lumped = ("internal_damping",), {"inertia": "lumped"}
    scene = make_scene(3, "pinned", terms, lumped, method="auto", span=[0.0, 100.0])
    live = live_of(scene)
    assert (live.settings.method, len(asked)) == ("dop853", 1)
    stiff = {"rod.bending_stiffness": 1e7, "loads.internal_damping.coefficient": 1e4}
    for k in range(1, 20):
        live.change(scene.replace({"rod.bending_stiffness": 30.0 + k}))
        live.advance(live.t, 0.001)
    live.change(scene.replace(stiff))
    assert (live.settings.method, len(asked)) == ("dop853", 1)
    clock[0] += live_module.PAUSE
    live.advance(live.t, 0.001)
    assert (live.settings.method, live.choice.method, len(asked)) == ("radau", "radau", 2)
    live.change(scene.replace({**stiff, "integrate.method": "gauss"}))
    assert live.settings.method == "gauss"


@pytest.mark.parametrize(
    ("method", "target"), sets([], slow=[("dop853", "c")], nightly=[("gauss", "numpy")])
)
def test_memory_stays_flat(make_scene: Make, method: str, target: str) -> None:
    """Over spans after spans, with changes, kicks, steps and loads in time. What is found out of
    the loads of a span is kept for a while, some 2e3 bytes; of its samples, which have 1e4 and
    more, nothing. (SciPy's LSODA is not asked: 1.17 keeps the work array of every one.)"""
    scene = make_scene(2, terms=("tip_load", "internal_damping"), method=method, span=[0.0, 0.05])
    scene = scene.with_integrate(rtol=1e-3, atol=1e-6)
    scenes = [scene.replace({"rod.mass": 3.0 + k / 10}) for k in range(3)]
    live = live_of(scene, target, 1e-4)

    def some() -> int:
        """Samples of three spans [bytes]."""
        many = 0
        for k in range(3):
            live.change(scenes[k % 3])
            live.kick(0, 0.5, (0.01 * (-1) ** k, 0.0))
            live.one_step()
            many += live.advance(live.t + 0.05, 60.0).y.nbytes
        live.one_step()  # which leaves out what was stepped over but not asked for
        gc.collect()
        return many

    def kept() -> int:
        """What rodgen and NumPy hold [bytes], without threads that other tests have left."""
        ours = [tracemalloc.Filter(True, f"*/{name}/*") for name in ("src/rodgen*", "numpy")]
        found = tracemalloc.take_snapshot().filter_traces(ours).statistics("filename")
        return sum(one.size for one in found)

    tracemalloc.start()
    try:
        some()
        before = kept()
        samples = some() + some()
        grown = kept() - before
    finally:
        tracemalloc.stop()
    # Of six spans what is found out, and what the interpreter keeps for itself.
    assert grown < 6 * 5e3 + samples / 10
    assert samples > 6e4


# Kicks -----------------------------------------------------------------------------------------


def test_kick_is_an_impulse_on_its_point(make_scene: Make) -> None:
    """M du is the generalised force of J, of which a free rod gains its momentum; positions stay,
    and what it gains in energy is told. To the rounding of a system of condition 1e3."""
    rod = {"bending_stiffness": 300.0}
    live = live_of(make_scene(5, terms=THESIS_TERMS, rod=rod, method="dop853"), "numpy")
    live.advance(0.314, 60.0)
    model, p, y, J = live.model, live.p, live.here().y[0], (1.7, -0.6)
    live.kick(2, 0.3, J)
    after = live.here().y[0]
    np.testing.assert_array_equal(after[:7], y[:7])
    gained = model.mass_matrix(y, p) @ (after - y)[7:]
    np.testing.assert_allclose(gained[:2], J, rtol=1e-12)
    np.testing.assert_allclose(gained, model.generalised_force(y, p, 2, 0.3, J), atol=1e-12)
    energy = [sum(model.energy(state, p)) for state in (y, after)]
    assert live.given == pytest.approx(energy[1] - energy[0], rel=1e-9)


@cases("method, target", ["dop853", "radau", "gauss"], ["c", "numpy"])
def test_kick_at_rest_acts_at_once(method: str, target: str) -> None:
    """Steps of a bar at rest reach to the end of the span, 50 s: the kick acts at the sample that
    was given out last. Then it moves by J/M, as if there had been none of those steps."""
    live = live_of(bar(integrate={"span": [0.0, 50.0], "method": method}), target)
    for frame in range(1, 90):
        live.advance(frame / 60, 60.0)
    assert live.t > 10.0
    assert live.here().t[0] == 1.48
    live.kick(0, 0.5, (6.0, 0.0))
    samples = live.advance(2.0, 60.0)
    np.testing.assert_allclose(samples.t, 0.01 * np.arange(149, 201))
    np.testing.assert_allclose(samples.y[:, 0], 2.0 * (samples.t - 1.48), rtol=1e-9)
