"""What every method gives to the run: stretches of steps, with samples and events between them."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.events import Watch
from rodgen.integrate.samples import Recorder
from rodgen.integrate.stepper import Counts

State = dict[str, NDArray[Any]]


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
