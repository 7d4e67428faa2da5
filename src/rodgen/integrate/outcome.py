"""How a run ends, and what is said of it: what stopped it, and what to try."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import Machine
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.structure import COLLOCATION
from rodgen.scene.tables import Integrate

FINISHED, FAILED, INTERRUPTED = "finished", "failed", "interrupted"
STRIDE, CREEP = 10_000, 1e-9  # so many steps go at least this share of the way
MOST_TURNED = 1e15  # rad, where neighbouring doubles are an eighth of a radian apart
NEAR = 1e-3  # share of the way to a pole within which it is what stops a run


class RunError(ArithmeticError):
    """A run that could not be finished. solution: all samples up to there."""

    def __init__(self, message: str, solution: Solution):
        super().__init__(message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.solution)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run. solution: all samples up to there."""

    def __init__(self, solution: Solution):
        super().__init__(solution.message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.solution,)


class StepWarning(UserWarning):
    """A fixed step is beyond the stability limit of its method."""


def cause(scene: Scene, machine: Machine, pole: tuple[float, Expression] | None) -> str:
    """The load, if any, that is not finite where a run stopped, and when."""
    asked = machine.asked
    for force in scene.timed.values():
        broken = [at for at in asked if not np.isfinite(force(at))]
        if broken:
            return f"; {force.not_finite(min(broken))} s"
    if pole:
        at, force = pole
        near = at - machine.t <= NEAR * (at - scene.integrate.span[0])
        if near or max(asked, default=at) >= at:
            return f"; {force.not_finite(at)} s"
    return ""


def turned(scene: Scene, machine: Machine) -> str:
    """Whether it is an angle of so many turns that it has no sine."""
    angles = machine.y[2 * scene.hold.translates : len(machine.y) // 2]
    beyond = np.abs(angles).max(initial=0.0) > MOST_TURNED
    return f"; an angle is beyond {MOST_TURNED:g} rad, where it has no sine" if beyond else ""


def advice(reason: str, settings: Integrate, load: bool) -> str:
    """What to try, for a reason why a run stopped; load: a load was the cause."""
    if load:
        return "end the span before that time, or give the load another expression"
    if "budget" in reason:
        other = "dop853" if settings.method in COLLOCATION else "radau or gauss"
        return f"raise max_steps, loosen the tolerance, or try {other}; the motion may be growing"
    if settings.fixed:
        return (
            "try a smaller step, or a method with error control (auto); if it stops there too, the "
            "motion itself grows without bound"
        )
    if "Newton" in reason:
        return "try a looser tolerance, or the explicit dop853"
    if "too small" in reason or "no further" in reason or "gave up" in reason:
        return "try a looser tolerance, another method (auto, radau, dop853), or a shorter span"
    return "look at the last samples: the motion itself may grow without bound; check the loads"
