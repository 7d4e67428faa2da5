"""An extreme case: its scene, how far states are apart, and motions in closed form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipj, ellipk

import rodgen

Array = NDArray[np.float64]
Tables = dict[str, Any]

SAMPLES = 32  # intervals between the states that are compared: exact shares of a span, inside steps
TURN = 2 * np.pi
EPS = float(np.finfo(float).eps)
KINDS = ("angles", "rates", "places", "speeds")
ANGLES, RATES, PLACES, SPEEDS = KINDS


@dataclass(frozen=True)
class TrueMotion:
    """States (samples, states) by a second route.

    error: its own estimate of its error, and condition: by how much errors of the start grow, both
    relative to the motion; by: the route; positions: of the rates it knows nothing.
    """

    y: Array
    by: str
    error: float = 0.0
    condition: float = 1.0
    positions: bool = False


@dataclass(frozen=True)
class ExtremeCase:
    """A case of the matrix.

    truth: from the scene to its states; who: the contestants, all if not given; quick: it is in the
    short report, there with few of them if those are given.
    """

    name: str
    tables: Tables
    truth: Callable[[rodgen.Scene], TrueMotion]
    who: Sequence[str] = ()
    quick: bool = False
    few: Sequence[str] = ()

    @cached_property
    def scene(self) -> rodgen.Scene:
        """Checked, with its samples."""
        first, last = self.tables["integrate"]["span"]
        every = {"output_every": (last - first) / SAMPLES}
        tables = {**self.tables, "integrate": {**self.tables["integrate"], **every}}
        return rodgen.Scene.from_dict(tables)


@dataclass(frozen=True)
class Measure:
    """Distance of states, kind by kind, relative to the motion's size."""

    scene: rodgen.Scene
    truth: Array
    sizes: dict[str, float] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sizes", self._sizes())

    def parts(self, y: Array) -> dict[str, Array]:
        """States of each kind, (samples, entries), entries none where a rod is held."""
        q, u = np.split(y, 2, axis=-1)
        base = 2 * self.scene.boundary_condition.translates
        return dict(
            zip(KINDS, (q[..., base:], u[..., base:], q[..., :base], u[..., :base]), strict=True)
        )

    def _sizes(self) -> dict[str, float]:
        parts = self.parts(self.truth)
        first, last = self.scene.integrate.span
        length = self.scene.rod.length
        angles = _largest(parts[ANGLES] - parts[ANGLES][:1]) or 1.0
        rates = max(_largest(parts[RATES]), angles / (last - first))
        places = max(_largest(parts[PLACES] - parts[PLACES][:1]), length * min(1.0, angles))
        speeds = max(_largest(parts[SPEEDS]), length * rates)
        return dict(zip(KINDS, (angles, rates, places, speeds), strict=True))

    def errors(self, y: Array) -> dict[str, float]:
        """Largest error of each kind over its size."""
        theirs, ours = self.parts(self.truth), self.parts(y)
        return {kind: _largest(ours[kind] - theirs[kind]) / self.sizes[kind] for kind in KINDS}

    def allowances(self) -> dict[str, float]:
        """Errors that the tolerances allow in each kind in a step, over its size; of turned and
        shifted rods the turns and the shift do not count."""
        settings, parts = self.scene.integrate, self.parts(self.truth)
        most = {ANGLES: TURN, PLACES: self.sizes[PLACES], RATES: np.inf, SPEEDS: np.inf}
        return self._accumulate(
            {
                kind: settings.rtol * min(_largest(parts[kind]), most[kind]) + settings.atol
                for kind in KINDS
            }
        )

    def rounding(self) -> dict[str, float]:
        """Errors by rounding of the states in each kind in a step, over its size."""
        parts = self.parts(self.truth)
        step = {kind: 4 * EPS * _largest(parts[kind]) for kind in KINDS}
        step[RATES] += step[SPEEDS] / self.scene.rod.length  # as the drag rounds with the speed
        return self._accumulate(step)

    def _accumulate(self, step: dict[str, float]) -> dict[str, float]:
        """Add what errors of rates and speeds make of angles and places in time."""
        first, last = self.scene.integrate.span
        step[ANGLES] += (last - first) * step[RATES]
        step[PLACES] += (last - first) * step[SPEEDS]
        return {kind: step[kind] / self.sizes[kind] for kind in KINDS}


def _largest(x: Array) -> float:
    return float(np.abs(x).max(initial=0.0))


def _expand(scene: rodgen.Scene, phi: Array, omega: Array, base: Array | None = None) -> Array:
    """States from angles and rates alike for all links, and (samples, 4) of joint 0."""
    moving = scene.rod.links - scene.n_fixed_links
    q, u = (np.repeat(np.asarray(x, dtype=float)[:, None], moving, 1) for x in (phi, omega))
    if base is None:
        return np.concatenate((q, u), axis=1)
    return np.concatenate((base[:, :2], q, base[:, 2:], u), axis=1)


def rigid(scene: rodgen.Scene) -> TrueMotion:
    """A straight uniform rod in free flight: its middle falls, and it turns steadily."""
    y0 = scene.initial_state()
    half, L = len(y0) // 2, scene.rod.length / 2
    t = scene.integrate.sample_times - scene.integrate.span[0]
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
    return TrueMotion(
        _expand(scene, phi, np.full_like(t, rate), base), "free flight of a straight rod"
    )


def drifting(scene: rodgen.Scene) -> TrueMotion:
    """All links along one line and moving alike against drag: v = v0 exp(-c |sin a| t)."""
    y0 = scene.initial_state()
    half = len(y0) // 2
    t = scene.integrate.sample_times - scene.integrate.span[0]
    v = y0[half : half + 2]
    external = scene.loads.external_damping
    assert external is not None
    angle = np.arctan2(v[1], v[0]) - y0[2]
    along = 0.0 if abs(np.sin(angle)) < 1e-15 else abs(np.sin(angle))
    rate = external.coefficient * along
    left = np.exp(-rate * t)[:, None]
    gone = (-np.expm1(-rate * t) / rate if rate else t)[:, None]
    base = np.concatenate((y0[:2] + v * gone, v * left), 1)
    return TrueMotion(
        _expand(scene, np.full_like(t, y0[2]), 0 * t, base), "decay against even drag"
    )


def pendulum(scene: rodgen.Scene) -> TrueMotion:
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
    t = scene.integrate.sample_times - scene.integrate.span[0]
    sn, cn, _, _ = ellipj(ellipk(k**2) - own * t, k**2)
    phi = 2 * np.arcsin(k * sn) - np.pi / 2
    omega = -2 * own * k * cn
    along = scene.distribution
    bend = along.mass * g * rod.length**2 / along.mean_stiffness if n > 1 else 0.0
    y = _expand(scene, phi, omega)
    return TrueMotion(y, "a rigid pendulum, by elliptic functions", error=bend, positions=n > 1)


def resting(scene: rodgen.Scene) -> TrueMotion:
    """Nothing moves."""
    y0 = scene.initial_state()
    return TrueMotion(np.tile(y0, (len(scene.integrate.sample_times), 1)), "equilibrium")
