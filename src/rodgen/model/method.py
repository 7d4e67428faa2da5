"""Methods of integration as data: order, who takes the steps, and coefficients."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal


@dataclass(frozen=True)
class Tableau:
    """An explicit Runge-Kutta method of s stages, in exact numbers (J. C. Butcher 1964).

    A: of each stage the weights of the rates of those before it, row by row; b: weights of the
    step, (s,); c: times of the stages as shares of the step, if not given the sums of the rows.
    follow: positions do not move by rates of their own, but over the whole step by the velocities
    that a stage or the step arrives at, as those of symplectic Euler do.
    """

    A: tuple[tuple[Fraction | int, ...], ...]
    b: tuple[Fraction | int, ...]
    c: tuple[Fraction | int, ...] = ()
    follow: bool = False

    def __post_init__(self) -> None:
        s = len(self.b)
        if [len(row) for row in self.A] != list(range(s)):
            raise ValueError(f"A has rows of 0 to {s - 1} weights for {s} stages")
        object.__setattr__(self, "c", self.c or tuple(sum(row) for row in self.A))
        if len(self.c) != s:
            raise ValueError(f"c has {len(self.c)} times for {s} stages")

    @property
    def rows(self) -> tuple[tuple[Fraction | int, ...], ...]:
        """The weights of all sums: of the stages after the first, then of the step."""
        return (*self.A[1:], self.b)


@dataclass(frozen=True)
class CollocationRule:
    """Collocation at three points, the zeros of the derivative of order a of x^a (x - 1)^b on
    [0, 1] (E. Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.5).

    powers: a and b; power, weight: the error that two steps in a row tell of grows with this power
    of the step, and is weighed by that, so that the error of a run is a tenth of its tolerance.
    """

    powers: tuple[int, int]
    power: int
    weight: float


@dataclass(frozen=True, kw_only=True)
class Method:
    """A method of integration, as scenes, both targets, documentation and tests know it.

    place: where it stands in lists; order: that of the error, or the highest where it varies;
    steps: all equal, chosen by error control, or whichever the scene asks for; about: what it is,
    in a few words; citation: where it is from. Its steps follow from the tableau or the
    collocation, or are those of a class of scipy.integrate; other libraries have a file of their
    own in integrate/. compiled: whether the C target has a loop of its own for it, beside the one
    for every tableau. per_step: share of the tolerance that the estimated error of one step may
    be, so that what steps add up to, and what the estimate does not see, is some tolerances.
    """

    name: str = ""
    place: int = 100
    order: int
    varies: bool = False
    steps: Literal["fixed", "adaptive", "either"]
    implicit: bool = False
    about: str
    citation: str
    tableau: Tableau | None = None
    collocation: CollocationRule | None = None
    scipy: str = ""
    compiled: bool = False
    per_step: float = 1.0

    @property
    def in_c(self) -> bool:
        """Whether its steps are taken in C."""
        return self.compiled or self.tableau is not None


def stability_polynomial(A: Collection[Collection[Any]], b: Collection[Any]) -> list[float]:
    """Coefficients of 1, z, z^2, ... of the stability polynomial 1 + sum z^(k+1) b A^k 1 of an
    explicit Runge-Kutta method, z = h lambda: its step multiplies the solution of y' = lambda y by
    that (E. Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.2)."""

    def dot(row: Collection[Any], column: Collection[Any]) -> Any:
        return sum(x * y for x, y in zip(row, column, strict=False))  # rows may lack their zeros

    found, power = [1.0], [1] * len(b)
    for _ in b:
        found.append(float(dot(b, power)))
        power = [dot(row, power) for row in A]
    return found
