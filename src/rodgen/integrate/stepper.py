"""Interface of steppers, the methods in Python: their initial value problem, costs, and how runs
end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from rodgen.arrays import Array
from rodgen.scene.integration import IntegrationTable

BOUNCES, MOMENT = 1000, 1e-3  # touches, and the share of the span within which they are too many
Rhs = Callable[[float, Array], Array]
Interpolant = Callable[[Array], Array]


@dataclass
class Counts:
    """Steps and evaluations so far, by SciPy's names.

    nsteps: steps that were taken; rejected: steps that were not, None where the method does not
    tell; nfev, njev: evaluations of the rates and of their Jacobian; nlu: factorisations of
    matrices.
    """

    nsteps: int = 0
    rejected: int | None = None
    nfev: int = 0
    njev: int = 0
    nlu: int = 0

    def __add__(self, other: Counts) -> Counts:
        told = [one.rejected for one in (self, other) if one.rejected is not None]
        steps, rejected = self.nsteps + other.nsteps, sum(told) if told else None
        calls = self.nfev + other.nfev, self.njev + other.njev, self.nlu + other.nlu
        return Counts(steps, rejected, *calls)


@dataclass(frozen=True)
class Stats:
    """Cost of a run, by SciPy's names.

    nsteps, rejected, nfev, njev, nlu: as of Counts; wall_seconds: time by the clock [s]; target: of
    the module that ran, "c" or "numpy", empty where it is not known.
    """

    nsteps: int
    rejected: int | None
    nfev: int
    njev: int
    nlu: int
    wall_seconds: float
    target: str = ""

    @classmethod
    def of(cls, counts: Counts, seconds: float, target: str = "") -> Stats:
        """Stats from the counts of a run and its time by the clock [s]."""
        return cls(**asdict(counts), wall_seconds=seconds, target=target)


@dataclass(frozen=True)
class InitialValueProblem:
    """Initial value problem of a method in Python: y' = rhs(t, y) from (t, y) to the end.

    settings: method and tolerances; jac: Jacobian of rhs by y, (states, states); longest: the
    longest step [s] at (t, y); added: how many of the states are neither positions nor velocities.
    """

    rhs: Rhs
    jac: Rhs
    t: float
    y: Array
    end: float
    settings: IntegrationTable
    longest: Callable[[float, Array], float] = lambda t, y: np.inf
    added: int = 0


class StepError(ArithmeticError):
    """A method cannot go on; the message says why.

    status: of the run that it ends.
    """

    status: ClassVar[str] = "failed"


class ChatterError(StepError):
    """A law of the motion switches to and fro so often that the run gets nowhere.

    cause: the law, and where it switches.
    """

    status = "chatters"

    def __init__(self, cause: str):
        super().__init__(f"it chatters by {cause}")
        self.cause = cause

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.cause,)


class BounceError(StepError):
    """The rod bounces on something ever more often, without end.

    event: name of the touching that happens so often.
    """

    status = "bounces"

    def __init__(self, event: str):
        super().__init__(f"it bounces without end, {event!r} {BOUNCES} times in a moment")
        self.event = event

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.event,)


FINISHED, FAILED, INTERRUPTED = "finished", StepError.status, "interrupted"
CHATTERS, BOUNCING = ChatterError.status, BounceError.status
TOO_LONG = "too long"  # of a point of a study
ENDED = (FINISHED, FAILED, CHATTERS, BOUNCING)  # and cannot be gone on with
NO_RESULT = (FAILED, CHATTERS, BOUNCING, TOO_LONG)


class Stepper(Protocol):
    """Interface of steppers: a method in Python between two break points."""

    t: float
    y: Array

    @property
    def counts(self) -> Counts:
        """Steps and evaluations so far."""
        ...

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        ...

    def interpolant(self) -> Interpolant:
        """Dense output of the last step: a function from times inside it to states (T, states)."""
        ...


def hermite(t0: float, y0: Array, f0: Array, t1: float, y1: Array, f1: Array) -> Interpolant:
    """Cubic Hermite interpolant of two states and their rates; its error is of order 4 in h."""
    h = t1 - t0

    def at(times: Array) -> Array:
        x = ((times - t0) / h)[:, None]
        rest = 1 - x
        ends = rest * y0 + x * y1
        bend = (1 - 2 * x) * (y1 - y0) + h * ((x - 1) * f0 + x * f1)
        return ends - x * rest * bend

    return at


def event_message(t: float, name: str) -> str:
    """Message of a run that an event has ended at a time [s]."""
    return f"ended at t = {t:.12g} s by the event {name!r}"
