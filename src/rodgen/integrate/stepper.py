"""What every method gives to the run: steps, each with an interpolant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rhs = Callable[[float, Array], Array]
Interpolant = Callable[[Array], Array]


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


class StepError(ArithmeticError):
    """A method cannot go on; the message says why."""


class Stepper(Protocol):
    """A method on its way from one break point to the next."""

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
