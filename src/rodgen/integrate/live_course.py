"""A method on its way through a run without an end, as long as nothing is changed."""

from __future__ import annotations

import contextlib
import time
from types import ModuleType

from rodgen.integrate.events import Watch
from rodgen.integrate.live_samples import Tape
from rodgen.integrate.methods.choose import machine
from rodgen.integrate.methods.compiled import Compiled
from rodgen.integrate.outcome import CREEP, STRIDE, advice, cause, turned
from rodgen.integrate.stepper import Array, StepError
from rodgen.integrate.stretches import Windows, inside
from rodgen.scene import Scene

STOPS = (StepError, OverflowError)  # what a method ends with that cannot go on


class Course:
    """Steps from (t, y) under the values of a scene, whose method is chosen.

    origin: start of the run [s]. Raises SceneError for a method that cannot be had, ValueError for
    parameters that the module refuses; what stops the first step is raised with that step.
    """

    def __init__(self, scene: Scene, model: ModuleType, t: float, y: Array, origin: float):
        self.scene = scene
        self.p: Array = model.parameters(**scene.parameters)
        self.machine = machine(model, self.p, scene.integrate, t, y.copy())
        self.compiled = isinstance(self.machine, Compiled)
        self._watch = Watch([], model, self.p)
        self._windows = Windows(scene, origin)
        self._ended, self._pace = True, 0.0
        self._seen, self._look = t, STRIDE
        with contextlib.suppress(*STOPS):
            self._begin()

    def _begin(self) -> None:
        """The next stretch. Raises StepError."""
        end = self._windows.after(self.machine.t)
        self.machine.begin(end, *inside(self.machine.t, end), self._windows.swing)
        self._ended = False

    def to(self, tape: Tape, goal: int, until: float) -> None:
        """Steps until the samples before number ``goal`` are there, or the clock
        (time.perf_counter) is at ``until``. Raises StepError."""
        # Compiled steps end with the last sample that is asked for, and can give more of the last
        # step later; those in Python give all samples of a step at once, or never.
        tape.until = goal if self.compiled else None
        while tape.count < goal:
            left = until - time.perf_counter()
            self._some(tape, self._most(left))
            if time.perf_counter() >= until:
                return

    def one_step(self, tape: Tape) -> None:
        """Exactly one step, without samples. Raises StepError."""
        tape.until = tape.count
        before = self.machine.counts.steps
        while self.machine.counts.steps == before:
            self._some(tape, 1)

    def _most(self, left: float) -> int:
        """Steps that fit into the seconds that are left, by the time that the last ones took."""
        if not self.compiled or not self._pace:
            return 1
        return max(1, int(min(STRIDE, left / self._pace)))

    def _some(self, tape: Tape, most: int) -> None:
        """At most so many steps. Raises StepError."""
        if self._ended:
            self._begin()
        before, start = self.machine.counts.steps, time.perf_counter()
        self._ended = self.machine.advance(tape, self._watch, most)
        steps = self.machine.counts.steps
        if steps > before:
            self._pace = (time.perf_counter() - start) / (steps - before)
        if steps >= self._look:
            self._check_progress(steps)

    def _check_progress(self, steps: int) -> None:
        """Raise StepError where thousands of steps lead nowhere."""
        if not self._ended and self.machine.t - self._seen < CREEP * self._windows.length:
            raise StepError(f"{STRIDE} steps brought it no further than from {self._seen!r} s")
        self._seen, self._look = self.machine.t, steps + STRIDE

    def told(self, error: ArithmeticError) -> str:
        """What stopped it, why, and what to try, in the words of a run with an end."""
        scene = self._windows.scene
        why = cause(scene, self.machine, self._windows.pole)
        tip = advice(str(error), scene.integrate, bool(why))
        why = why or turned(scene, self.machine)
        return f"stopped at t = {self.machine.t:.9g} s: {error}{why}; {tip}"
