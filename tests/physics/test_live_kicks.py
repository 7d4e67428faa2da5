"""Kicks to a run without an end: what an impulse does at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.live import Live
from rodgen.scene import Scene

Make = Callable[..., Scene]
ALL = ("follower", "gravity", "internal_damping", "external_damping")
pytestmark = pytest.mark.compiler


def live_of(scene: Scene, target: str = "c") -> Live:
    return Live(scene, rodgen.build(scene, target), 0.01)


def momentum(live: Live, y: Any) -> tuple[Any, float]:
    """Linear momentum, and angular momentum about the origin, of uniform links of a rod."""
    rod, hold = live.scene.rod, live.scene.hold
    l, m, half = rod.length / rod.links, rod.mass / rod.links, len(y) // 2
    at, v = (y[:2], y[half : half + 2]) if hold.translates else (np.zeros(2), np.zeros(2))
    linear, angular = np.zeros(2), 0.0
    for i in range(rod.links):
        phi, omega = y[2 * hold.translates + i], y[half + 2 * hold.translates + i]
        along = l * np.array([np.cos(phi), np.sin(phi)])
        turned = omega * np.array([-along[1], along[0]])
        centre, speed = at + along / 2, v + turned / 2
        linear = linear + m * speed
        angular += m * (centre[0] * speed[1] - centre[1] * speed[0]) + m * l**2 / 12 * omega
        at, v = at + along, v + turned
    return linear, angular


@pytest.mark.parametrize(("link", "share"), [(0, 0.0), (2, 0.3), (3, 1.0)])
def test_kick_gives_a_free_rod_its_impulse(make_scene: Make, link: int, share: float) -> None:
    """Momentum J, angular momentum r x J, and the energy J times the mean of the velocities of the
    point before and after; to the rounding of a system of condition 1e3."""
    live = live_of(make_scene(4, terms=ALL, rod={"bending_stiffness": 300.0}))
    live.advance(0.314, 60.0)
    y, (Jx, Jy) = live.here().y[0], (1.7, -0.6)
    assert live.here().t[0] > 0.3
    live.kick(link, share, (Jx, Jy))
    after = live.here().y[0]
    ends = live.model.joints(y, live.p)[link : link + 2]
    x, z = ends[0] + share * (ends[1] - ends[0])
    np.testing.assert_array_equal(after[:6], y[:6])
    linear, angular = (b - a for a, b in zip(momentum(live, y), momentum(live, after), strict=True))
    np.testing.assert_allclose(linear, (Jx, Jy), rtol=1e-12)
    assert angular == pytest.approx(x * Jy - z * Jx, rel=1e-12)
    assert live.given == pytest.approx(
        impulse_work(live, y, after, link, share, (Jx, Jy)), rel=1e-9
    )


def impulse_work(
    live: Live, before: Any, after: Any, link: int, share: float, impulse: tuple[float, float]
) -> float:
    """Work of an impulse: it times the mean of the velocities of its point, from the positions of
    the joints a microsecond before and after (errors of 1e-12, and of 1e-16/1e-6 by rounding)."""
    half, speeds = len(before) // 2, []
    for y in (before, after):
        ends = []
        for side in (1e-6, -1e-6):
            moved = np.concatenate((y[:half] + side * y[half:], y[half:]))
            ends.append(live.model.joints(moved, live.p)[link : link + 2])
        speeds.append(((ends[0] - ends[1]) / 2e-6).T @ (1 - share, share))
    return float(np.dot(impulse, np.mean(speeds, axis=0)))


@pytest.mark.parametrize("boundary", ["free", "cantilever", "clamped", "pinned"])
@pytest.mark.parametrize("inertia", ["uniform", "lumped"])
def test_kick_puts_in_its_work(make_scene: Make, boundary: str, inertia: str) -> None:
    """However the rod is held."""
    scene = make_scene(4, boundary, ("gravity",), rod={"inertia": inertia})
    live = live_of(scene, "numpy")
    live.advance(0.1, 60.0)
    for link, share in ((0, 1.0), (1, 0.25), (3, 0.5)):
        given, y = live.given, live.here().y[0]
        live.kick(link, share, (0.3, 0.4))
        expected = impulse_work(live, y, live.here().y[0], link, share, (0.3, 0.4))
        assert live.given - given == pytest.approx(expected, rel=1e-8, abs=1e-9)
        assert link == 0 or live.given != given  # the cantilever holds its first link


def test_kick_turns_a_pinned_link() -> None:
    """omega = J a / I_0 with I_0 = M L^2/3, the impulse across the link; along it, none."""
    table = {
        "name": "bar",
        "rod": {"links": 1, "length": 2.0, "bending_stiffness": 1.0, "mass": 3.0,
                "boundary": "pinned"},
        "initial": {"phi": 0.4},
    }  # fmt: skip
    live = live_of(Scene.from_dict(table))
    live.kick(0, 0.75, (-2.0 * math.sin(0.4), 2.0 * math.cos(0.4)))
    live.kick(0, 0.75, (5.0 * math.cos(0.4), 5.0 * math.sin(0.4)))
    omega = 2.0 * (0.75 * 2.0) / (3.0 * 2.0**2 / 3)
    assert live.y[1] == pytest.approx(omega, rel=1e-14)
    assert live.given == pytest.approx(3.0 * 2.0**2 / 3 * omega**2 / 2, rel=1e-14)
    samples = live.advance(1.0, 60.0)
    assert samples.t[0] == 0.0  # the sample at the start has felt it as well
    np.testing.assert_allclose(samples.y[:, 0], 0.4 + omega * samples.t, rtol=1e-13)


@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("method", ["dop853", "radau", "gauss"])
def test_kick_at_rest_acts_at_once(method: str, target: str) -> None:
    """Steps of a bar at rest reach to the end of the span, 50 s: the kick acts at the sample that
    was given out last. Then it moves by J/M, as if there had been none of those steps."""
    table = {
        "name": "bar",
        "rod": {"links": 1, "length": 2.0, "bending_stiffness": 1.0, "mass": 3.0},
        "loads": {"external_damping": {"coefficient": 0.0}},
        "integrate": {"span": [0.0, 50.0], "method": method},
    }
    live = live_of(Scene.from_dict(table), target)
    for frame in range(1, 90):
        live.advance(frame / 60, 60.0)
    assert live.t > 10.0
    assert live.here().t[0] == 1.48
    live.kick(0, 0.5, (6.0, 0.0))
    samples = live.advance(2.0, 60.0)
    np.testing.assert_allclose(samples.t, 0.01 * np.arange(149, 201))
    np.testing.assert_allclose(samples.y[:, 0], 2.0 * (samples.t - 1.48), rtol=1e-9)
