"""Variational equations: a motion with tangents, the small changes of a state to first order.

The tangents V obey dV/dt = J(t, y) V along the motion y, by the exact derivatives of the equations.
They are integrated by the very stages that the motion is, outside of the error control: the motion
is that of a run without them, step by step, and V is the derivative of the steps themselves. Where
stages are solved for, those of V are too, by the factors of the step's Newton matrix, in O(n).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DOP853

from rodgen.arrays import Array
from rodgen.integrate.events import OFTEN, SHORT, EventDetector
from rodgen.integrate.methods.compiled_integrator import (
    FAILURES,
    FIRST,
    MOST,
    compiled_name,
    next_quota,
)
from rodgen.integrate.stepper import ChatterError, StepError
from rodgen.integrate.stretches import Stretches, evaluation_bounds
from rodgen.loading import build_fastest
from rodgen.model.methods import COLLOCATION, TABLEAUX
from rodgen.native import native_run
from rodgen.scene import Scene
from rodgen.scene.integration import IntegrationTable
from rodgen.scene.time_laws import Switch

PARTS = ("rhs", "tangents")  # of a module
# Whose steps take tangents along: those in which every state moves alike.
METHODS = (
    *("dop853", *COLLOCATION),
    *(name for name, tableau in TABLEAUX.items() if not tableau.follow),
)


@dataclass(frozen=True)
class StepSettings:
    """Settings of steps: a method of METHODS, with a fixed step [s] or tolerances; breaks: times
    [s], ascending, that steps meet; longest: step [s] of a method that chooses its own; switches:
    where laws of the motion switch."""

    method: str = "dop853"
    step: float = 0.0
    rtol: float = 1e-8
    atol: float = 1e-10
    breaks: Sequence[float] = ()
    longest: float = np.inf
    switches: Sequence[Switch] = ()

    @classmethod
    def of(cls, scene: Scene) -> StepSettings:
        """Settings of a scene in its span; dop853 where its method takes no tangents along. Raises
        InputError for a base whose velocity jumps."""
        scene.time_laws.check_base_is_smooth()
        settings: IntegrationTable = scene.integrate
        method = settings.method if settings.method in METHODS else "dop853"
        stretches = Stretches.of(scene.time_laws, settings.has_fixed_step)
        step = settings.step if settings.step is not None and method == settings.method else 0.0
        tolerances = settings.model_copy(update={"method": method}).step_tolerances
        switches = () if settings.has_fixed_step else scene.time_laws.switches()
        return cls(method, step, *tolerances, stretches.ends, stretches.half_period, switches)


class Variations:
    """Integrator of a motion with its tangents (count, states).

    t [s], y (states,) and tangents are where it is; counts: steps and evaluations so far. In C
    where the module is, else by SciPy's DOP853.
    """

    def __init__(
        self,
        model: ModuleType,
        p: ArrayLike,
        t: float,
        y: ArrayLike,
        tangents: ArrayLike,
        steps: StepSettings | None = None,
    ):
        """Start from the state y at time t [s]. Raises ValueError for arrays of other shapes."""
        self._model, self._steps = model, steps or StepSettings()
        self._p = np.array(p, dtype=float)
        y = np.array(y, dtype=float)
        self._shape = np.shape(tangents)
        if len(self._shape) != 2 or self._shape[1:] != y.shape:
            allowed = f"directions of the state, (count, {len(y)})"
            raise ValueError(f"tangents have shape {self._shape}: must be {allowed}")
        kind = _InC if hasattr(model, "VARIATIONS") else _InPython
        with np.errstate(all="ignore"):
            self._machine: _InC | _InPython = kind(
                model, self._p, t, y, np.array(tangents), self._steps
            )
        self._window, self._goal, self._quota = (t, t), np.nan, FIRST
        self._watch = EventDetector((), model, self._p, self._steps.switches)
        self._first = self._since = t  # start, and a time [s] with the steps up to it
        self._before = 0

    @classmethod
    def of(
        cls,
        scene: Scene,
        tangents: ArrayLike | None = None,
        *,
        model: ModuleType | None = None,
        t: float | None = None,
        y: ArrayLike | None = None,
    ) -> Variations:
        """Variations of a scene from its start, or from y at t; tangents: by default in all
        directions of the state."""
        model = model if model is not None else build_fastest(scene, PARTS)
        y = scene.initial_state() if y is None else np.asarray(y, dtype=float)
        start = scene.integrate.span[0] if t is None else t
        tangents = np.eye(len(y)) if tangents is None else tangents
        p = model.parameters(**scene.parameters)
        return cls(model, p, start, y, tangents, StepSettings.of(scene))

    @property
    def t(self) -> float:
        return self._machine.t

    @property
    def y(self) -> Array:
        return self._machine.y.copy()

    @property
    def tangents(self) -> Array:
        return self._machine.tangents.copy()

    @tangents.setter
    def tangents(self, tangents: ArrayLike) -> None:
        """Go on with other tangents, along the same motion."""
        v = np.array(tangents, dtype=float).reshape(self._shape)
        self._machine.tangents[:] = v
        low, high = self._window
        at = min(max(self.t, low), high)
        self._machine.tangent_rates[:] = self._model.tangents(at, self.y, self._p, v)

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of steps and of evaluations of the rates."""
        return self._machine.counts

    def advance_to(self, end: float, most: int | None = None) -> bool:
        """Go on to a time [s], or for at most so many steps towards it; True where it is reached.
        Raises StepError where the motion cannot go on."""
        left = MOST if most is None else most
        with np.errstate(all="ignore"):
            while self.t < end:
                if left <= 0:
                    return False
                left -= self._take_steps(end, left)
        return True

    def _take_steps(self, end: float, most: int) -> int:
        """Take steps for a few hundredths of a second, and return how many they were."""
        t, before = self.t, self.counts[0]
        goal = min((at for at in self._steps.breaks if t < at < end), default=end)
        if goal != self._goal:
            self._goal, self._window = goal, evaluation_bounds(t, goal)
            self._machine.begin(goal, *self._window, self._steps.longest)
        start = time.perf_counter()
        try:
            reached = self._machine.advance(min(self._quota, most))
        except StepError:
            self._check_chatter()
            raise
        if reached:
            self._goal = np.nan
        elif self._quota <= most:
            self._quota = next_quota(self._quota, time.perf_counter() - start)
        if self.counts[0] - self._before >= OFTEN:
            if self.t - self._since < OFTEN * SHORT * self._stretch_length:
                self._check_chatter()
            self._since, self._before = self.t, self.counts[0]
        return self.counts[0] - before

    @property
    def _stretch_length(self) -> float:
        """Length of the stretch between breaks [s]: of the whole of it, as in a part of it steps
        that get nowhere would not show."""
        ends = [*self._steps.breaks, self._window[1]]
        start = max((at for at in ends if at <= self.t), default=self._first)
        return min((at for at in ends if at > self.t), default=self._window[1]) - start

    def _check_chatter(self) -> None:
        """Raise ChatterError where steps get next to nowhere since a law switches to and fro."""
        way = self._stretch_length
        for number in range(len(self._watch.events)):
            if self._watch.time_to_sliding(number, self.t, self.y, way) <= SHORT * way:
                raise ChatterError(self._watch.cause(number))


class _InC:
    """Integrator in C, by steps of the module."""

    def __init__(
        self, model: ModuleType, p: Array, t: float, y: Array, tangents: Array, steps: StepSettings
    ):
        count, states = tangents.shape
        kind = native_run.with_tangents(model.VARIATIONS, count)
        method = compiled_name(steps.method, steps.step > 0)
        self._run = kind(method, t, y, p, steps.step, steps.rtol, steps.atol)
        first = len(self._run.state) - count * states
        self._states = states
        self.tangents = self._run.state[first:].reshape(count, states)
        self.tangent_rates = self._run.rates[first:].reshape(count, states)
        self.tangents[:] = tangents

    @property
    def t(self) -> float:
        return float(self._run.numbers.t)

    @property
    def y(self) -> Array:
        state: Array = self._run.state[: self._states]
        return state

    @property
    def counts(self) -> tuple[int, int]:
        return self._run.numbers.steps, self._run.numbers.rhs

    def begin(self, end: float, low: float, high: float, longest: float) -> None:
        self._check_status(self._run.begin(end, low, high, longest))

    def advance(self, most: int) -> bool:
        status, _ = self._run.advance(most, np.empty(0), np.empty((0, len(self._run.state))))
        return self._check_status(status)

    def _check_status(self, status: int) -> bool:
        if status in FAILURES:
            raise StepError(f"{FAILURES[status]} at t = {self.t:.9g} s")
        return bool(status == native_run.STATUSES["REACHED"])


class _InPython:
    """Integrator by SciPy's DOP853, where there is no compiler."""

    def __init__(
        self, model: ModuleType, p: Array, t: float, y: Array, tangents: Array, steps: StepSettings
    ):
        self._model, self._p, self._steps = model, p, steps
        self._shape, self.t, self._count = tangents.shape, t, [0, 0]
        self._row = np.concatenate((y, tangents.ravel()))
        self._rates = np.zeros_like(self._row)
        self._window = (t, t)
        self._solver: Any = None

    @property
    def y(self) -> Array:
        return self._row[: self._shape[1]]

    @property
    def tangents(self) -> Array:
        return self._row[self._shape[1] :].reshape(self._shape)

    @property
    def tangent_rates(self) -> Array:
        return self._rates[self._shape[1] :].reshape(self._shape)

    @property
    def counts(self) -> tuple[int, int]:
        return self._count[0], self._count[1]

    def _flow(self, t: float, row: Array) -> Array:
        low, high = self._window
        at, states = min(max(t, low), high), self._shape[1]
        self._count[1] += 1
        v = row[states:].reshape(self._shape)
        changes = self._model.tangents(at, row[:states], self._p, v)
        return np.concatenate((self._model.rhs(at, row[:states], self._p), changes.ravel()))

    def begin(self, end: float, low: float, high: float, longest: float) -> None:
        self._window, states = (low, high), self._shape[1]
        # Tangents have no part in the error: in its mean they only count as numbers.
        share = np.sqrt(states / len(self._row))
        atol = np.where(np.arange(len(self._row)) < states, self._steps.atol * share, np.inf)
        rtol = max(self._steps.rtol * share, 2.3e-14)
        options = {"rtol": rtol, "atol": atol, "max_step": longest}
        self._solver = DOP853(self._flow, self.t, self._row, end, **options)
        self._row, self._rates = self._solver.y, self._solver.f

    def advance(self, most: int) -> bool:
        for _ in range(most):
            message = self._solver.step()
            self._row, self._rates = self._solver.y, self._solver.f
            self.t = float(self._solver.t)
            self._count[0] += 1
            if self._solver.status == "failed" or not np.isfinite(self._rates).all():
                why = message or FAILURES[native_run.STATUSES["NOT_FINITE"]]
                raise StepError(f"{why} at t = {self.t:.9g} s")
            if self._solver.status == "finished":
                return True
        return False
