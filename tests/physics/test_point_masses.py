"""Quantities of a rod with bodies beside those of point masses: three to a link, four to a body.

Three at Gauss's points of a link have its mass, centre and moments to the second; four at the
radius of gyration of a body have its mass and moment, alike in all directions.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.loading import build
from rodgen.scene import Scene

L, LINKS = 2.0, 4
PER_LENGTH = [3.0, 1.0, 0.5, 2.0]
NOSE: dict[str, Any] = {
    "name": "nose",
    "at": 0.0,
    "mass": 1.5,
    "inertia": 0.3,
    "offset": [0.1, 0.4],
}
FIN: dict[str, Any] = {"name": "fin", "at": 0.8, "mass": 0.7, "offset": [0.0, -0.6]}
HOLDS = ("free", "cantilever", "clamped", "pinned")


def _scene(boundary: str) -> Scene:
    rod = {"links": LINKS, "length": L, "bending_stiffness": 10.0, "mass_per_length": PER_LENGTH}
    clamped = {"clamp_angle": 0.3} if boundary in ("cantilever", "clamped") else {}
    bodies = [NOSE, FIN]
    return Scene.from_dict(
        {"name": "m", "rod": rod | {"boundary": boundary} | clamped, "bodies": bodies}
    )


def _points(scene: Scene, y: Array) -> tuple[Array, Array, Array]:
    """Masses, places and velocities of the points, relative to joint 0 at rest there."""
    l, half, boundary_condition = L / LINKS, len(y) // 2, scene.boundary_condition
    base = 2 * boundary_condition.translates
    phi, omega = y[base:half], y[half + base :]
    if boundary_condition.first:
        phi, omega = np.append(0.3, phi), np.append(0.0, omega)
    e = np.stack((np.cos(phi), np.sin(phi)), -1)
    n = np.stack((-e[:, 1], e[:, 0]), -1)
    starts = np.concatenate((np.zeros((1, 2)), l * e.cumsum(axis=0)))[:LINKS]
    slow = np.concatenate((np.zeros((1, 2)), l * (omega[:, None] * n).cumsum(axis=0)))[:LINKS]
    rows = []
    nodes, weights = np.polynomial.legendre.leggauss(3)
    for at in range(LINKS):
        rows += [
            (at, PER_LENGTH[at] * l * w / 2, l * (1 + x) / 2, 0.0)
            for x, w in zip(nodes, weights, strict=True)
        ]
    for body, link, along in ((NOSE, 0, 0.0), (FIN, 3, 0.1)):
        a, b = np.array(body.get("offset")) + np.array([along, 0.0])
        r = np.sqrt(body.get("inertia", 0.0) / body["mass"])
        ways = ((r, 0.0), (-r, 0.0), (0.0, r), (0.0, -r))
        rows += [(link, body["mass"] / 4, a + da, b + db) for da, db in ways]
    masses = np.array([mass for _, mass, *_ in rows])
    places = np.array([starts[at] + a * e[at] + b * n[at] for at, _, a, b in rows])
    speeds = np.array([slow[at] + omega[at] * (a * n[at] - b * e[at]) for at, _, a, b in rows])
    return masses, places, speeds


@pytest.mark.parametrize("boundary", HOLDS)
def test_inertia_and_its_axes(boundary: str) -> None:
    scene = _scene(boundary)
    model = build(scene, "numpy")
    p = model.parameters(**scene.parameters)
    for seed in range(3):
        y = np.random.default_rng(seed).normal(size=len(model.STATE))
        masses, places, _ = _points(scene, y)
        arms = places - masses @ places / masses.sum()
        x, y_, xy = (masses @ v for v in (arms[:, 1] ** 2, arms[:, 0] ** 2, arms.prod(axis=1)))
        near = model.inertia(y, p)
        y[: 2 * scene.boundary_condition.translates] += 1e9  # far away no digits are lost
        np.testing.assert_array_equal(model.inertia(y, p), near)
        motion = MotionSlice(model, p, y)
        for name, due in (("inertia_x", x), ("inertia_y", y_), ("product_xy", xy)):
            assert motion.values(name) == pytest.approx(due, rel=1e-12, abs=1e-12), name
        angle = float(motion.values("principal_angle"))
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        along, across = (arms @ axes.T).T
        assert masses @ (along * across) == pytest.approx(0.0, abs=1e-12)
        found = [masses @ across**2, masses @ along**2]
        np.testing.assert_allclose(motion.values("principal_moments"), found, rtol=1e-12)


@pytest.mark.parametrize("away", [0.0, 1e9])
@pytest.mark.parametrize("boundary", HOLDS)
def test_velocities_of_the_tail_and_of_the_centre(boundary: str, away: float) -> None:
    """Joint 0 moves with all of it; far away no digits are lost."""
    scene = _scene(boundary)
    model = build(scene, "numpy")
    y = np.random.default_rng(5).normal(size=len(model.STATE))
    base, half = 2 * scene.boundary_condition.translates, len(y) // 2
    y[:base] += away
    moved = y[half : half + base] if base else np.zeros(2)
    masses, _, speeds = _points(scene, y)
    omega = np.append(np.zeros(scene.boundary_condition.first), y[half + base :])
    phi = np.append(np.full(scene.boundary_condition.first, 0.3), y[base:half])
    tail = L / LINKS * np.array([-omega @ np.sin(phi), omega @ np.cos(phi)])
    motion = MotionSlice(model, model.parameters(**scene.parameters), y)
    # A difference over 1e-5 rad misses 1e-10/6 of the rates.
    np.testing.assert_allclose(motion.values("tip_velocity"), moved + tail, atol=1e-8)
    centre = moved + masses @ speeds / masses.sum()
    np.testing.assert_allclose(motion.values("centre_velocity"), centre, atol=1e-8)


@pytest.mark.parametrize("boundary", HOLDS)
def test_deflection_of_the_tail_is_seen_from_the_start(boundary: str) -> None:
    """In a frame that turns with the clamp or the first link, all angles and rates are relative."""
    scene = _scene(boundary)
    model = build(scene, "numpy")
    y = np.random.default_rng(6).normal(size=len(model.STATE))
    base, half = 2 * scene.boundary_condition.translates, len(y) // 2
    first = scene.boundary_condition.first
    phi = np.append(np.full(first, 0.3), y[base:half])
    omega = np.append(np.zeros(first), y[half + base :])
    held = scene.boundary_condition.is_clamped
    seen = np.exp(1j * (phi - (0.3 if held else phi[0])))
    turning = omega - (0.0 if held else omega[0])
    motion = MotionSlice(model, model.parameters(**scene.parameters), y)
    due = L / LINKS * seen.sum().imag
    assert motion.values("tail_deflection") == pytest.approx(due, abs=1e-12)
    due = L / LINKS * (1j * turning * seen).sum().imag
    # As that of the tail's velocity.
    assert motion.values("tail_deflection_rate") == pytest.approx(due, abs=1e-8)
