"""Corners of the law of springs, and fronts that move along the rod: steps end there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.events import Switching
from rodgen.scene import Scene
from rodgen.scene import course as course_of
from tests.physics.sets import sets

LINK = {"links": 1, "length": 2.0, "mass": 3.0, "bending_stiffness": 8.0, "boundary": "clamped"}
STOP = "k*d + 5*k*max(d - 0.1, 0)"  # six times as stiff beyond 0.1 rad
# A root spring of 2 EI/L against the moment of inertia M L^2/3.
OMEGA = np.sqrt((2 * 8.0 / 2.0) / (3.0 * 2.0**2 / 3))


def _struck(spring: str, links: int = 1, **integrate: Any) -> Scene:
    table = {
        "name": "stop",
        "rod": LINK | {"spring": spring, "links": links},
        "initial": {"omega": 1.0},
        "events": [{"quantity": "phi_0", "value": 0.0, "direction": "rising", "name": "back"}],
        "integrate": {"span": [0.0, 25.0], "rtol": 1e-6, "atol": 1e-8} | integrate,
    }
    return Scene.from_dict(table)


def _period() -> float:
    """Of a link that swings through rest at 1 rad/s: half a period of the soft spring, and what it
    takes up to the stop, into it, and back."""
    stiff, centre = np.sqrt(6.0) * OMEGA, 0.5 / 6.0  # 6 d - 0.5 is the moment over k beyond
    up_to = np.arcsin(0.1 * OMEGA) / OMEGA
    speed = np.sqrt(1.0 - (0.1 * OMEGA) ** 2)
    into = np.arctan2(speed / stiff, 0.1 - centre) / stiff
    return float(np.pi / OMEGA + 2 * (up_to + into))


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("method", "target"),
    sets([("dop853", "numpy")], slow=[("gauss", "c")], nightly=[("radau", "numpy")]),
)
def test_a_link_against_a_stop(method: str, target: str) -> None:
    sol = rodgen.simulate(_struck(STOP, method=method, output_every=5.0), target=target)
    periods = _period() * np.arange(1, len(sol.events) + 1)
    assert len(periods) > 4
    # What the tolerance leaves of 25 s of even swinging.
    np.testing.assert_allclose([event.t for event in sol.events], periods, atol=2e-5)


@pytest.mark.nightly
def test_a_straight_rod_rests_on_a_corner() -> None:
    """What steps make of the angles of a rod that flies straight is no motion across it."""
    rod = {"links": 5, "length": 1.0, "mass": 1.0, "bending_stiffness": 100.0}
    table = {
        "name": "straight",
        "rod": rod | {"spring": "k*max(d, 0) + 2*k*min(d, 0)"},
        "loads": {"follower": {"force": 3.0}, "gravity": {}},
        "initial": {"phi": 0.7, "omega": 0.3},
        "integrate": {"span": [0.0, 1.0], "method": "dop853", "output_every": 0.5},
    }
    scene = Scene.from_dict(table)
    plain = Scene.from_dict(table | {"rod": rod | {"spring": "1.5*k*d"}})
    found, smooth = (rodgen.simulate(one, target="numpy") for one in (scene, plain))
    assert found.stats.steps < 2 * smooth.stats.steps


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
    with pytest.warns(rodgen.StepWarning, match="force_per_length"):
        rodgen.simulate(_burning(), target="numpy")


def test_cuts_that_bring_nothing_pause_for_ever_longer() -> None:
    """Late in a stretch too, where what has been gone says nothing of how it goes on."""

    class Chattering:
        def crossings(self, t: np.ndarray, *_: Any) -> list[Any]:
            return [(0, 0, (float(t[0]), float(t[1])))]

        def switching(self, number: int) -> bool:
            return number == 0

    watch: Any = Chattering()
    switching, t, cuts, calm = Switching(10.0, 0.0, since=5.0), 5.0, 0, []
    while t < 10.0:
        step = np.array([t, t + 1e-3])
        if switching.seen(watch, step, step, None):
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
