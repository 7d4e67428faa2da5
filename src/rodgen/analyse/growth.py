"""The critical follower force as the thesis found it: by simulations, and whether they grow."""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from rodgen.analyse.critical import HIGHEST, family_of
from rodgen.analyse.errors import AnalysisError
from rodgen.integrate.outcome import RunError
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import Solution
from rodgen.scene import Scene, SceneError
from rodgen.scene.tables import FIXED_STEP

FIRST = 4.0  # EI/L^2, doubled until a motion grows
PIECES = 20  # of a run
TOLERANCES = {"rtol": 1e-6, "atol": 1e-8}  # what grows by itself is far larger than errors
SAMPLES = 4000  # of a run, among which the largest bending is looked for
# Small angles [rad] of a rod that starts straight, without a moment at its free ends.
DISTURBED = "1e-4*(cos(pi*s) + cos(2*pi*s) + cos(3*pi*s))"
DISTURBED_CLAMPED = "1e-4*(sin(pi*s/2) + sin(3*pi*s/2))"


@dataclass(frozen=True)
class SimulatedCritical:
    """low, high: the largest force whose motion did not grow and the smallest whose motion did
    [N]; force: between them; span: simulated time of a run [s]; growth: by how much the bending of
    the start has to be exceeded; runs: how many; seconds: what they took together."""

    force: float
    low: float
    high: float
    span: float
    growth: float
    runs: int
    seconds: float


def simulated_critical_force(
    scene: Scene,
    *,
    span: float = 200.0,
    growth: float = 100.0,
    tolerance: float = 1e-4,
    low: float | None = None,
    high: float | None = None,
    **settings: Any,
) -> SimulatedCritical:
    """Bisection by simulations of so many seconds, from the scene's initial state, or from one bent
    by 1e-4 rad where it starts straight.

    A motion has grown when the largest angle between two links exceeds ``growth`` times that of
    the start (the largest that the clamp sees included). A finite time finds too large a force:
    next to the onset growth is slow; a small growth too small a one, since frequencies that nearly
    meet beat. tolerance: of the force, relative; low, high: forces between which it lies [N], by
    default found by doubling from 4 EI/L^2; settings: those of `simulate` (method, step, target;
    rtol 1e-6 and atol 1e-8, if not given). Raises SceneError, AnalysisError where nothing grows up
    to 1000 EI/L^2.
    """
    family = family_of(scene)  # a scene without a follower force, or without a stiffness
    for name, value in (("span", span), ("growth - 1", growth - 1), ("tolerance", tolerance)):
        if not (np.isfinite(value) and value > 0):
            raise SceneError(name, value, "positive")
    begun = time.perf_counter()
    run = _Run(_ready(scene, span), growth, TOLERANCES | settings)
    lower, upper = _bracket(run, low, high, family.unit)
    while upper - lower > tolerance * upper:
        middle = (lower + upper) / 2
        lower, upper = (lower, middle) if run.grows(middle) else (middle, upper)
    return SimulatedCritical(
        force=(lower + upper) / 2,
        low=lower,
        high=upper,
        span=span,
        growth=growth,
        runs=run.count,
        seconds=time.perf_counter() - begun,
    )


def _bracket(run: _Run, low: float | None, high: float | None, unit: float) -> tuple[float, float]:
    """Forces without and with growth."""
    lower = 0.0 if low is None else low
    if run.grows(lower):
        raise AnalysisError(f"the motion grows already at {lower:g} N within {run.span:g} s")
    upper = max(FIRST * unit, 2 * lower) if high is None else high
    while not run.grows(upper):
        if high is not None or upper > HIGHEST * unit:
            raise AnalysisError(
                f"no motion grows {run.growth:g} times within {run.span:g} s up to {upper:g} N "
                f"({run.count} simulations)"
            )
        lower, upper = upper, 2 * upper
    return lower, upper


class _Run:
    """Simulations of a scene under one follower force after the other."""

    def __init__(self, scene: Scene, growth: float, settings: dict[str, Any]):
        self.scene, self.growth, self.settings, self.count = scene, growth, settings, 0
        self.span = scene.integrate.span[1]
        self.ends = np.linspace(0.0, self.span, PIECES + 1)
        step = settings.get("step", scene.integrate.step)
        if settings.get("method", scene.integrate.method) in FIXED_STEP and step:
            # A piece of whole steps: every shortened one would disturb the fastest motions.
            piece = max(1, round(self.span / PIECES / step)) * step
            self.ends = np.append(np.arange(0.0, self.span - piece / 2, piece), self.span)

    def grows(self, force: float) -> bool:
        """Whether the bending of the start is exceeded by so much; a run that blows up has. The
        span is gone through in pieces, since a motion that has grown costs the most."""
        self.count += 1
        table = self.scene.model_dump(exclude_none=True)
        table["loads"]["follower"]["force"] = force
        most = np.inf
        for start, end in pairwise(self.ends.tolist()):
            table["integrate"]["span"] = [start, end]
            try:
                solution = simulate(Scene.from_dict(table), **self.settings)
            except RunError:
                return True
            bend = _bending(solution)
            if start == 0:
                most = self.growth * bend[0]
            if bend.max() > most:
                return True
            table["initial"] = _state(self.scene, solution.y[-1])
        return False


def _state(scene: Scene, y: np.ndarray) -> dict[str, list[float]]:
    """The table [initial] of a state."""
    q, v = np.split(y, 2)
    base = 2 * scene.hold.translates
    table = {"phi": q[base:].tolist(), "omega": v[base:].tolist()}
    return table | ({"position": q[:2].tolist(), "velocity": v[:2].tolist()} if base else {})


def _bending(solution: Solution) -> np.ndarray:
    """The largest angle between two links at every sample [rad]; at a root spring, to the clamp."""
    angles = solution.phi
    if solution.scene.hold.root_spring:
        clamp = np.full((len(angles), 1), solution.scene.rod.clamp_angle or 0.0)
        angles = np.concatenate((clamp, angles), axis=1)
    bend: np.ndarray = np.abs(np.diff(angles, axis=1)).max(axis=1)
    return bend


def _ready(scene: Scene, span: float) -> Scene:
    """The scene over the span, bent a little where it starts straight."""
    table = scene.model_dump(exclude_none=True)
    table["integrate"] |= {"span": [0.0, span], "output_every": span / SAMPLES}
    moving = scene.initial_state()
    angles = moving[2 * scene.hold.translates : len(moving) // 2]
    if np.ptp(angles) == 0 and not moving[len(moving) // 2 :].any():
        clamped = scene.held or scene.hold.root_spring
        start = f"{float(angles[0])!r} + {DISTURBED_CLAMPED if clamped else DISTURBED}"
        table["initial"] = table.get("initial", {}) | {"phi": start}
    return Scene.from_dict(table)
