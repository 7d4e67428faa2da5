"""One setting of a method on a job, ours or another's."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class TooSlowError(RuntimeError):
    """A run that was stopped at the deadline."""


class NotModelledError(ValueError):
    """What a peer cannot model, or not in any sensible time: a refusal, not a failure."""

    def __init__(self, why: str):
        super().__init__(f"not modelled: {why}")


class Deadline:
    """When the run that is on its way is stopped: what can look at it now and then, does."""

    at = np.inf  # on time.perf_counter()

    @classmethod
    def look(cls) -> None:
        """Raise TooSlowError where it is over."""
        if time.perf_counter() > cls.at:
            raise TooSlowError("stopped, as it took too long")


@dataclass(frozen=True)
class Finish:
    """What a run came to: y (samples, states) in rodgen's order at the job's sample times, and
    its counts, as far as they are known: steps, rejected, rhs, jacobian, factorisations.

    balance: gives the largest error of the run's own energy balance [J]; called after the clock
    has been read.
    """

    y: Array
    counts: dict[str, int] = field(default_factory=dict)
    inside: float | None = None  # seconds that it counted itself, without the calls around it
    balance: Callable[[], float] | None = None


@dataclass(frozen=True)
class Contestant:
    """A whole integration.

    setting: the step [s] or relative tolerance; kind: "step" or "rtol"; setup: seconds of
    generation or compilation before it, by what it consists of ("generate", "compile"); agreed:
    how far another's formulation is from ours in the rates, relative.
    """

    who: str  # "rodgen", "SciPy", "CVODE", "heyoka", ...
    method: str
    target: str  # what evaluates the equations: "c", "numpy", or the peer's own formulation
    kind: str
    setting: float
    integrate: Callable[[], Finish]
    order: float | None = None  # nominal, where it has one
    setup: dict[str, float] = field(default_factory=dict)
    agreed: float | None = None


Family = Iterator[Contestant]  # one method's settings from loose to tight, each made when asked for
