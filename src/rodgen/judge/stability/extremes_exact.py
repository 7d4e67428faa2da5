"""Motions in closed form: straight rods in free flight, against even drag, on a pin."""

from __future__ import annotations

import numpy as np
from scipy.special import ellipj, ellipk

import rodgen
from rodgen.judge.stability.extremes_case import Array, Truth


def _expand(scene: rodgen.Scene, phi: Array, omega: Array, base: Array | None = None) -> Array:
    """States from angles and rates alike for all links, and (samples, 4) of joint 0."""
    moving = scene.rod.links - scene.held
    q, u = (np.repeat(np.asarray(x, dtype=float)[:, None], moving, 1) for x in (phi, omega))
    if base is None:
        return np.concatenate((q, u), axis=1)
    return np.concatenate((base[:, :2], q, base[:, 2:], u), axis=1)


def rigid(scene: rodgen.Scene) -> Truth:
    """A straight uniform rod in free flight: its middle falls, and it turns steadily."""
    y0 = scene.initial_state()
    half, L = len(y0) // 2, scene.rod.length / 2
    t = scene.integrate.samples - scene.integrate.span[0]
    phi0, rate = y0[2], y0[half + 2]
    assert np.ptp(y0[2:half]) == 0 == np.ptp(y0[half + 2 :])
    g = scene.loads.gravity.g if scene.loads.gravity else 0.0
    phi, half_turn = phi0 + rate * t, rate * t / 2
    # Differences of sines as products: x0 + L (cos a - cos b) to the last place.
    middle_v = y0[half : half + 2] + L * rate * np.array([-np.sin(phi0), np.cos(phi0)])
    fallen = np.stack((0 * t, -g * t**2 / 2), 1)
    turned = 2 * L * np.sin(half_turn)[:, None]
    mean = phi0 + half_turn
    swing = turned * np.stack((np.sin(mean), -np.cos(mean)), 1)
    place = y0[:2] + (middle_v * t[:, None] + fallen + swing)
    speed = middle_v + np.stack((0 * t, -g * t), 1)
    speed = speed - L * rate * np.stack((-np.sin(phi), np.cos(phi)), 1)
    base = np.concatenate((place, speed), 1)
    return Truth(_expand(scene, phi, np.full_like(t, rate), base), "free flight of a straight rod")


def drifting(scene: rodgen.Scene) -> Truth:
    """All links along one line and moving alike against drag: v = v0 exp(-c |sin a| t)."""
    y0 = scene.initial_state()
    half = len(y0) // 2
    t = scene.integrate.samples - scene.integrate.span[0]
    v = y0[half : half + 2]
    external = scene.loads.external_damping
    assert external is not None
    angle = np.arctan2(v[1], v[0]) - y0[2]
    along = 0.0 if abs(np.sin(angle)) < 1e-15 else abs(np.sin(angle))
    rate = external.coefficient * along
    left = np.exp(-rate * t)[:, None]
    gone = (-np.expm1(-rate * t) / rate if rate else t)[:, None]
    base = np.concatenate((y0[:2] + v * gone, v * left), 1)
    return Truth(_expand(scene, np.full_like(t, y0[2]), 0 * t, base), "decay against even drag")


def pendulum(scene: rodgen.Scene) -> Truth:
    """A rod that stays straight on its pin, let go from rest: Jacobi's elliptic functions.

    Its springs give by about M g L^2/EI, of which the truth knows nothing.
    """
    rod, y0 = scene.rod, scene.initial_state()
    assert scene.loads.gravity is not None
    g = scene.loads.gravity.g
    n = rod.links
    inertia = 1 / 3 if rod.inertia == "uniform" else 1 / 3 + 1 / (6 * n**2)
    own = np.sqrt(g / (2 * inertia * rod.length))
    start = y0[0] + np.pi / 2
    k = np.sin(start / 2)
    t = scene.integrate.samples - scene.integrate.span[0]
    sn, cn, _, _ = ellipj(ellipk(k**2) - own * t, k**2)
    phi = 2 * np.arcsin(k * sn) - np.pi / 2
    omega = -2 * own * k * cn
    bend = rod.mass * g * rod.length**2 / rod.bending_stiffness if n > 1 else 0.0
    y = _expand(scene, phi, omega)
    return Truth(y, "a rigid pendulum, by elliptic functions", error=bend, positions=n > 1)


def resting(scene: rodgen.Scene) -> Truth:
    """Nothing moves."""
    y0 = scene.initial_state()
    return Truth(np.tile(y0, (len(scene.integrate.samples), 1)), "equilibrium")
