"""What every method gives to the run: stretches of steps, with samples and events between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rodgen.integrate.events import Watch
    from rodgen.integrate.samples import Recorder
    from rodgen.scene.integration import Integrate

Array = NDArray[np.float64]
Rhs = Callable[[float, Array], Array]
Interpolant = Callable[[Array], Array]
State = dict[str, NDArray[Any]]


@dataclass
class Counts:
    """Cost of a run so far; None where a method does not tell."""

    steps: int = 0
    rejected: int | None = None
    rhs: int = 0
    jacobian: int = 0
    factorisations: int = 0

    def __iadd__(self, other: Counts) -> Counts:
        self.steps += other.steps
        if other.rejected is not None:
            self.rejected = (self.rejected or 0) + other.rejected
        self.rhs += other.rhs
        self.jacobian += other.jacobian
        self.factorisations += other.factorisations
        return self


def _unbounded(t: float, y: Array) -> float:
    return np.inf


@dataclass(frozen=True)
class Problem:
    """What a method in Python solves: y' = rhs(t, y) from (t, y) to the end, as `settings` have it.

    jac: Jacobian of rhs by y, (states, states); longest: the longest step [s] at (t, y); added: how
    many of the states are neither positions nor velocities.
    """

    rhs: Rhs
    jac: Rhs
    t: float
    y: Array
    end: float
    settings: Integrate
    longest: Callable[[float, Array], float] = _unbounded
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


class Happened(Exception):  # noqa: N818, an event is no error
    """An event, by its number in the scene, ends the run at a time [s]."""

    def __init__(self, number: int, t: float):
        super().__init__(number, t)
        self.number, self.t = number, t


class Machine(Protocol):
    """A method on its way through a run, wherever its steps are taken."""

    @property
    def t(self) -> float:
        """How far it is [s]."""
        ...

    @property
    def y(self) -> Array:
        """The state there."""
        ...

    @property
    def end(self) -> float:
        """End of the stretch that it is in [s]."""
        ...

    @property
    def asked(self) -> list[float]:
        """Times [s] at which loads were asked for their values of late."""
        ...

    @property
    def counts(self) -> Counts:
        """Cost so far."""
        ...

    def begin(self, end: float, low: float, high: float, longest: float) -> None:
        """A stretch up to end [s]; loads are asked for their values between low and high; longest:
        step [s] of methods that choose theirs. Raises StepError."""
        ...

    def advance(self, recorder: Recorder, watch: Watch, most: int) -> bool:
        """Some steps, at most so many, for a few hundredths of a second; True at the end of the
        stretch. Raises StepError, and Happened where an event ends the run."""
        ...

    def works(self, recorder: Recorder) -> Array:
        """Work of every load since the start [J], (works,); in all samples there are as well."""
        ...

    def state(self) -> State:
        """All that is needed to go on to the same bits; ValueError where that cannot be told."""
        ...

    def restore(self, state: State) -> None:
        """Take up such a state, before `begin` or in the stretch that it was of."""
        ...


class Stepper(Protocol):
    """A method in Python on its way from one break point to the next."""

    t: float
    y: Array

    @property
    def counts(self) -> Counts:
        """Cost so far."""
        ...

    def step(self) -> bool:
        """Take a step; True when the end is reached. Raises StepError."""
        ...

    def interpolant(self) -> Interpolant:
        """States (T, states) at times inside the last step."""
        ...


def hermite(t0: float, y0: Array, f0: Array, t1: float, y1: Array, f1: Array) -> Interpolant:
    """Cubic through two states with their rates; exact to the fourth power of the step."""
    h = t1 - t0

    def at(times: Array) -> Array:
        x = ((times - t0) / h)[:, None]
        rest = 1 - x
        ends = rest * y0 + x * y1
        bend = (1 - 2 * x) * (y1 - y0) + h * ((x - 1) * f0 + x * f1)
        return ends - x * rest * bend

    return at
