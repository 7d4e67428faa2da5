"""The critical follower force as the thesis found it: by simulations, and whether they grow."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from rodgen.analyse.critical import HIGHEST, family_of
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.family import Family
from rodgen.analyse.guarded import guarded
from rodgen.integrate.outcome import RunError
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import Array
from rodgen.loading import build, build_fastest
from rodgen.scene import Scene, SceneError
from rodgen.scene.expression import Expression
from rodgen.scene.overrides import check_used
from rodgen.scene.tables import FIXED_STEP

FIRST = 4.0  # EI/L^2, doubled until a motion grows
PIECES = 20  # of a run
TOLERANCES = {"rtol": 1e-6, "atol": 1e-8}  # what grows by itself is far larger than errors
SAMPLES = 4000  # of a run, among which the largest bending is looked for
# Small angles [rad], without a moment at free ends.
DISTURBED = "1e-4*(cos(pi*s) + cos(2*pi*s) + cos(3*pi*s))"
DISTURBED_CLAMPED = "1e-4*(sin(pi*s/2) + sin(3*pi*s/2))"


@dataclass(frozen=True)
class SimulatedCritical:
    """low, high: the largest force whose motion did not grow and the smallest whose motion did
    [N]; force: between them; span: simulated time of a run [s]; growth: by how much the bending of
    the start has to be exceeded; runs: how many; seconds: what they took together; target: of the
    module that ran, "c" or "numpy"."""

    force: float
    low: float
    high: float
    span: float
    growth: float
    runs: int
    seconds: float
    target: str


@guarded
def simulated_critical_force(
    scene: Scene,
    *,
    span: float = 200.0,
    growth: float = 100.0,
    tolerance: float = 1e-4,
    low: float | None = None,
    high: float | None = None,
    disturbance: str | None = None,
    progress: Callable[[float, bool], None] = lambda force, grew: None,
    target: str | None = None,
    **settings: Any,
) -> SimulatedCritical:
    """Bisection by simulations of so many seconds, each from the steady state under its force,
    disturbed a little; the initial state of the scene is not used.

    A motion has grown when the largest angle between two links, those of the steady state taken
    off, exceeds ``growth`` times that of the start. A finite time finds too large a force: next to
    the onset growth is slow; a small growth too small a one, since frequencies that nearly meet
    beat. tolerance: of the force, relative; low, high: forces between which it lies [N], by default
    found by doubling from 4 EI/L^2; disturbance: angles [rad], an expression in s as in a scene, by
    default about 1e-4; progress: called with every force and whether the motion grew; target: "c"
    or "numpy", "c" where it can be built; settings: those of `simulate` (method, step; rtol 1e-6
    and atol 1e-8, if not given). Raises SceneError, AnalysisError where there is no steady state,
    or nothing grows up to 1000 EI/L^2.
    """
    family = family_of(scene)  # refuses a scene without a follower force, or without a stiffness
    check_used(scene.with_integrate(**settings).integrate, settings)
    for name, value in (("span", span), ("growth - 1", growth - 1), ("tolerance", tolerance)):
        if not (np.isfinite(value) and value > 0):
            raise SceneError(name, value, "positive")
    begun = time.perf_counter()
    run = _Run(family, span, growth, disturbance, progress, target, TOLERANCES | settings)
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
        target=run.model.PROVENANCE["target"],
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

    def __init__(
        self,
        family: Family,
        span: float,
        growth: float,
        disturbance: str | None,
        progress: Callable[[float, bool], None],
        target: str | None,
        settings: dict[str, Any],
    ):
        self.family, self.span, self.growth, self.progress = family, span, growth, progress
        self.settings, self.count = settings, 0
        scene = family.system.scene
        self.model = build(scene, target) if target else build_fastest(scene)
        self.start = _angles(scene, disturbance)
        self.table = scene.model_dump(exclude_none=True)
        self.table["integrate"]["output_every"] = span / SAMPLES
        self.table["integrate"].pop("t_eval", None)
        self.ends = np.linspace(0.0, span, PIECES + 1)
        step = settings.get("step", scene.integrate.step)
        if settings.get("method", scene.integrate.method) in FIXED_STEP and step:
            # A piece of whole steps: every shortened one would disturb the fastest motions.
            piece = max(1, round(span / PIECES / step)) * step
            self.ends = np.append(np.arange(0.0, span - piece / 2, piece), span)

    def grows(self, force: float) -> bool:
        """Whether the bending of the start is exceeded by so much; a run that blows up has."""
        self.count += 1
        grew = self._grows(force)
        self.progress(force, grew)
        return grew

    def _grows(self, force: float) -> bool:
        """The span is gone through in pieces, since a motion that has grown costs the most."""
        steady = self.family.system.all_links(self.family.state(force).phi)
        held = self.family.system.scene.held
        table = self.table | {"initial": {"phi": (steady[held:] + self.start).tolist()}}
        table["loads"]["follower"]["force"] = force
        most = np.inf
        for start, end in pairwise(self.ends.tolist()):
            table["integrate"]["span"] = [start, end]
            try:
                scene = Scene.from_dict(table).with_integrate(**self.settings)
                solution = simulate(scene, model=self.model)
            except RunError:
                return True
            bend = _bending(solution, steady)
            if start == 0:
                most = self.growth * bend[0]
            if bend.max() > most:
                return True
            table["initial"] = _state(scene, solution.y[-1])
        return False


def _angles(scene: Scene, disturbance: str | None) -> Array:
    """Angles of the moving links [rad] by which the start is disturbed."""
    clamped = scene.held or scene.hold.root_spring
    text = disturbance or (DISTURBED_CLAMPED if clamped else DISTURBED)
    n = scene.rod.links
    links = np.arange(scene.held, n)
    values = np.broadcast_to(Expression(text, "s", "disturbance")((links + 0.5) / n), links.shape)
    if not (np.isfinite(values).all() and values.any()):
        raise SceneError("disturbance", disturbance, "finite, and not zero on every link")
    return np.asarray(values, dtype=float)


def _state(scene: Scene, y: Array) -> dict[str, list[float]]:
    """The table [initial] of a state."""
    q, v = np.split(y, 2)
    base = 2 * scene.hold.translates
    table = {"phi": q[base:].tolist(), "omega": v[base:].tolist()}
    return table | ({"position": q[:2].tolist(), "velocity": v[:2].tolist()} if base else {})


def _bending(solution: Solution, steady: Array) -> Array:
    """The largest angle between two links, or a link and its clamp, at every sample [rad], less
    those of the steady state."""
    away = solution.phi - steady
    if solution.scene.hold.root_spring:
        away = np.concatenate((np.zeros((len(away), 1)), away), axis=1)
    if away.shape[1] == 1:
        return np.asarray(np.abs(away[:, 0]))
    return np.asarray(np.abs(np.diff(away, axis=1)).max(axis=1))
