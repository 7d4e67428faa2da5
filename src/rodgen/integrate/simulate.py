"""A scene to a Solution: the run from break point to break point."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.integrate import fixed_step, scipy_methods
from rodgen.integrate.collect import Collector
from rodgen.integrate.solution import Solution, Stats
from rodgen.integrate.stepper import Array, Counts, Rhs, StepError, Stepper
from rodgen.loading import build, build_fastest
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.tables import Integrate

FINISHED, FAILED, INTERRUPTED = "finished", "failed", "interrupted"
STRIDE, CREEP = 10_000, 1e-9  # so many steps go at least this share of the way
TICK = 0.1  # seconds between two calls of the progress callback
RECENT = 100  # evaluations that are looked at when a run stops, more than a step tries at once
NEAR = 1e-3  # share of the way to a pole within which it is what stops a run


class RunError(ArithmeticError):
    """A run that could not be finished. solution: all samples up to there."""

    def __init__(self, message: str, solution: Solution):
        super().__init__(message)
        self.solution = solution


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run. solution: all samples up to there."""

    def __init__(self, solution: Solution):
        super().__init__(solution.message)
        self.solution = solution


def simulate(
    scene: Scene,
    *,
    target: str | None = None,
    model: ModuleType | None = None,
    progress: Callable[[float], None] | None = None,
    **overrides: Any,
) -> Solution:
    """Integrate a scene.

    target: "c" or "numpy"; if not given, C where it can be built. overrides: values for the
    scene's [integrate] (method, span, step, rtol, atol, output_every); model: a module built
    before; progress: called with the time [s] some ten times a second.

    Raises SceneError for values that cannot be used, RunError where the state stops being finite
    or the method gives up, Interrupted on Ctrl-C; the last two carry the samples so far.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene must be a Scene (see Scene.from_toml), not {type(scene).__name__}")
    scene = scene.with_integrate(**overrides)
    if model is None:
        model = build(scene, target) if target else build_fastest(scene)
    return _Run(scene, model, progress).go()


class _Run:
    def __init__(self, scene: Scene, model: ModuleType, progress: Callable[[float], None] | None):
        self.scene, self.model, self.settings = scene, model, scene.integrate
        self.progress = progress or (lambda _: None)
        self.p = model.parameters(**scene.parameters)
        y0 = scene.initial_state()
        self.collector = Collector(self.settings.samples, y0, model, self.p)
        self.t, self.y = self.settings.span[0], y0
        self.window = (-np.inf, np.inf)
        self.asked: deque[float] = deque(maxlen=RECENT)
        self.pole: tuple[float, Expression] | None = None
        self.counts = Counts()
        self.start = time.perf_counter()

    def go(self) -> Solution:
        stepper: Stepper | None = None
        try:
            with np.errstate(all="ignore"):
                breaks, self.pole = self.scene.breaks(), self.scene.pole()
                for end in self._ends(breaks):
                    self.window = _inside(self.t, end, breaks)
                    stepper = _stepper(self.settings, self.rhs, self.jac, self.t, self.y, end)
                    self._to(end, stepper)
                    self.counts += stepper.counts
                    stepper = None
                if self.pole:  # a step across it would be finite, and wrong
                    raise StepError("a load grows beyond all bounds")
        except (StepError, OverflowError) as error:
            self._count(stepper)
            message = f"stopped at t = {self.t:.9g} s: {error}{self._cause()}"
            raise RunError(message, self.solution(FAILED, message)) from None
        except KeyboardInterrupt:
            self._count(stepper)
            message = f"interrupted at t = {self.t:.9g} s"
            raise Interrupted(self.solution(INTERRUPTED, message)) from None
        return self.solution(FINISHED, "")

    def rhs(self, t: float, y: Array) -> Array:
        """Rates at a time that is held inside the stretch between two break points."""
        low, high = self.window
        at = min(max(t, low), high)
        self.asked.append(at)
        rates: Array = self.model.rhs(at, y, self.p)
        return rates

    def jac(self, t: float, y: Array) -> Array:
        """The Jacobian of the rates, at a time held likewise."""
        low, high = self.window
        jacobian: Array = self.model.jac(min(max(t, low), high), y, self.p)
        return jacobian

    def _ends(self, breaks: list[float]) -> list[float]:
        """Times to step to, one after the other: break points, and the end or the first pole."""
        start, end = self.settings.span
        last = self.pole[0] if self.pole else end
        return [*(at for at in breaks if at < last), *([last] if last > start else [])]

    def _cause(self) -> str:
        """The load, if any, that is not finite where the run stopped, and when."""
        for force in self.scene.timed.values():
            broken = [at for at in self.asked if not np.isfinite(force(at))]
            if broken:
                return f"; {force.not_finite(min(broken))} s"
        if self.pole:
            at, force = self.pole
            near = at - self.t <= NEAR * (at - self.settings.span[0])
            if near or max(self.asked, default=at) >= at:
                return f"; {force.not_finite(at)} s"
        return ""

    def _count(self, stepper: Stepper | None) -> None:
        if stepper is not None:
            self.counts += stepper.counts

    def _to(self, end: float, stepper: Stepper) -> None:
        """Step to a break point or to the end of the span."""
        tick = time.perf_counter()
        done, seen, least = False, self.t, CREEP * (end - self.t)
        while not done:
            done = stepper.step()
            if stepper.counts.steps % STRIDE == 0:
                if stepper.t - seen < least:
                    raise StepError(f"{STRIDE} steps brought it no further than from {seen!r} s")
                seen = stepper.t
            if not np.isfinite(stepper.y).all():
                raise StepError("the state stops being finite in the step after this time")
            self.collector.add(self.t, stepper.t, stepper.y, stepper.interpolant)
            self.t, self.y = stepper.t, stepper.y
            now = time.perf_counter()
            if now - tick > TICK:
                tick = now
                self.progress(self.t)

    def solution(self, status: str, message: str) -> Solution:
        collector = self.collector
        with np.errstate(all="ignore"):
            collector.flush()
        count = collector.count
        seconds = time.perf_counter() - self.start
        return Solution(
            scene=self.scene,
            t=collector.times[:count],
            y=collector.states[:count],
            work={term: values[:count] for term, values in collector.work.items()},
            stats=Stats.of(self.counts, seconds),
            status=status,
            message=message,
            model=self.model,
        )


def _inside(start: float, end: float, breaks: list[float]) -> tuple[float, float]:
    """Times at which loads may be asked for their values between start and end.

    At a break point a load may jump: each side of it sees its own value.
    """
    low = start + 8 * np.spacing(abs(start)) if start in breaks else -np.inf
    high = end - 8 * np.spacing(abs(end)) if end in breaks else np.inf
    return float(low), float(high)


def _stepper(settings: Integrate, rhs: Rhs, jac: Rhs, t: float, y: Array, end: float) -> Stepper:
    if settings.method in fixed_step.METHODS:
        assert settings.step is not None
        return fixed_step.FixedStep(settings.method, rhs, t, y, end, settings.step)
    tolerances = (settings.rtol, settings.atol)
    return scipy_methods.ScipyStep(settings.method, rhs, jac, t, y, end, *tolerances)
