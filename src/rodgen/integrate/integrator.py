"""Interface of integrators: stretches of steps, with samples and events between them."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.events import EventDetector
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.stepper import Counts

State = dict[str, NDArray[Any]]


class EventStop(Exception):  # noqa: N818, an event is no error
    """An event, by its number in the scene, ends the run at a time [s]."""

    def __init__(self, number: int, t: float):
        super().__init__(number, t)
        self.number, self.t = number, t


class Integrator(Protocol):
    """Interface of integrators: a method on its way through a run, in C or in Python."""

    @property
    def t(self) -> float:
        """Time that it has reached [s]."""
        ...

    @property
    def y(self) -> Array:
        """State at this time."""
        ...

    @property
    def end(self) -> float:
        """End of the present stretch [s]."""
        ...

    @property
    def load_times(self) -> list[float]:
        """Times [s] at which loads were evaluated of late."""
        ...

    @property
    def counts(self) -> Counts:
        """Steps and evaluations so far."""
        ...

    def begin(self, end: float, low: float, high: float, longest: float) -> None:
        """Begin a stretch up to end [s]. Loads are evaluated between low and high; longest: largest
        step [s] of methods that choose theirs. Raises StepError."""
        ...

    def advance(self, recorder: Recorder, watch: EventDetector, most: int) -> bool:
        """Take at most so many steps, for a few hundredths of a second; True at the end of the
        stretch. Raises StepError, and EventStop where an event ends the run."""
        ...

    def works(self, recorder: Recorder) -> Array:
        """Work of every load since the start [J], (works,); put into the samples so far too."""
        ...

    def state(self) -> State:
        """Arrays from which it goes on to the same bits; ValueError where there can be none."""
        ...

    def restore(self, state: State) -> None:
        """Restore arrays of `state`, before `begin` or in the stretch that they were taken in."""
        ...
