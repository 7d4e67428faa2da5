"""What can be kept of a run, each with the variables that it fills and what it makes of a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.errors import AnalysisError
from rodgen.integrate.catalogue import Piece
from rodgen.integrate.crossings import Crossed, Crossing
from rodgen.integrate.endings import FINISHED
from rodgen.integrate.reductions import Numbers, Reduction
from rodgen.studies.variable import Variable

if TYPE_CHECKING:
    from rodgen.arrays import Array
    from rodgen.integrate import Solution
    from rodgen.integrate.ensemble import Ensemble
    from rodgen.integrate.equations import Equations
    from rodgen.scene.event import Event

MOST_POINTS = 1000  # of a section, where no other number is given
EVERY = -math.inf, math.inf


def crossing_of(event: Event) -> Crossing:
    """What runs side by side look out for as an event of their scene."""
    return Crossing(event.quantity, event.value, event.direction)


@dataclass(frozen=True)
class Sampled:
    """A reduction of the samples of a run."""

    reduction: Reduction
    units: str

    @property
    def text(self) -> str:
        """As it was asked for."""
        return self.reduction.text

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers that it is made of."""
        return (self.reduction.number,)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The number that it is."""
        return (Variable(self.text, units=self.units),)

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run."""
        values = places.values(solution, self.reduction.number)
        return {self.text: self.reduction.of(solution.t, values)}


@dataclass(frozen=True)
class Count:
    """How often an event of the scene happens between two times [s]."""

    text: str
    event: str
    start: float = EVERY[0]
    end: float = EVERY[1]
    numbers: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The number of times, -1 where there was no run."""
        return (Variable(self.text, dtype="i8", fill=-1),)

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run."""
        found = [one for one in solution.events if one.name == self.event]
        return {self.text: sum(self.start <= one.t <= self.end for one in found)}

    def crossing(self, event: Event, equations: Equations) -> Crossing:
        """What runs side by side look out for."""
        return replace(crossing_of(event), start=self.start, end=self.end)

    def of_many(self, crossed: Crossed, equations: Equations, p: Array) -> dict[str, Any]:
        """What it is of many runs, with parameters p (runs, parameters)."""
        return {self.text: crossed.counts}


@dataclass(frozen=True)
class Section:
    """A number at the times at which another passes a level between two times [s], at most so many
    of them, and these times."""

    text: str
    number: str
    where: str
    level: float
    direction: str
    units: str
    event: str = ""
    most: int = MOST_POINTS
    start: float = EVERY[0]
    end: float = EVERY[1]
    dim: str = "crossing"

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers that it is made of."""
        return (self.number,)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The values and the times, one after the other."""
        beyond = (self.dim,), (self.most,)
        return (
            Variable(self.text, *beyond, units=self.units),
            Variable(f"{self.text}.t", *beyond, units="s"),
        )

    @property
    def table(self) -> dict[str, Any]:
        """The event that a run looks out for."""
        crossing = {"quantity": self.where, "value": self.level, "direction": self.direction}
        return crossing | {"name": self.event}

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run."""
        met = [e for e in solution.events if e.name == self.event and self.start <= e.t <= self.end]
        met = met[: self.most]
        made = {name: np.full(self.most, math.nan) for name in (self.text, f"{self.text}.t")}
        if met:
            t, y = np.array([one.t for one in met]), np.array([one.y for one in met])
            system = solution.system
            there = Piece(solution.model, system.p, y, t, timed=system.timed)
            made[self.text][: len(met)] = places.values(there, self.number)
            made[f"{self.text}.t"][: len(met)] = t
        return made

    def crossing(self, event: Event, equations: Equations) -> Crossing:
        """What runs side by side look out for: where C does not have the number, the states."""
        alone = equations.observes(self.number)
        numbers = (self.number,) if alone else tuple(equations.model.STATE)
        counted = replace(crossing_of(event), start=self.start, end=self.end)
        return replace(counted, kept=numbers, most=self.most)

    def of_many(self, crossed: Crossed, equations: Equations, p: Array) -> dict[str, Any]:
        """What it is of many runs, with parameters p (runs, parameters)."""
        if equations.observes(self.number):
            return {self.text: crossed.values[..., 0], f"{self.text}.t": crossed.t}
        made = np.full(crossed.t.shape, math.nan)
        for run in np.flatnonzero(crossed.counts):
            met = slice(min(int(crossed.counts[run]), self.most))
            states, t, timed = (
                crossed.values[run, met],
                crossed.t[run, met],
                equations.timed(p[run]),
            )
            there = Piece(equations.model, p[run], states, t, timed=timed)
            made[run, met] = equations.numbers.values(there, self.number)
        return {self.text: made, f"{self.text}.t": crossed.t}


@dataclass(frozen=True)
class Peak:
    """The highest peak in the spectrum of a number between two times [s]."""

    text: str
    number: str
    units: str
    start: float = EVERY[0]
    end: float = EVERY[1]

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers that it is made of."""
        return (self.number,)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Its frequency and its amplitude."""
        return (
            Variable(f"{self.text}.frequency", units="Hz"),
            Variable(f"{self.text}.amplitude", units=self.units),
        )

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run; not-a-number where there is no peak. Raises InputError for samples
        that are not uniform."""
        return self._of(solution.t, places.values(solution, self.number))

    def of_many(self, ensemble: Ensemble, number: int) -> dict[str, Any]:
        """What it is of many runs, of which a number was traced. Raises what `of` raises."""
        runs = [
            self._of(*ensemble.trace(rod, number)) if status == FINISHED else {}
            for rod, status in enumerate(ensemble.status.tolist())
        ]
        names = [variable.name for variable in self.variables]
        return {name: np.array([run.get(name, math.nan) for run in runs]) for name in names}

    def _of(self, t: Array, values: Array) -> dict[str, float]:
        # It brings a third of all that a worker would import.
        from rodgen.analyse.fourier import peaks_of

        inside = (t >= self.start) & (t <= self.end)
        last = int(np.flatnonzero(inside)[-1]) if inside.any() else 0
        if last > 1 and t[last] - t[last - 1] < 0.999 * (t[1] - t[0]):
            inside[last] = False  # the end of the run, between two samples
        try:
            found = peaks_of(t[inside], values[inside], peaks=1)
        except AnalysisError:
            return {f"{self.text}.{part}": math.nan for part in ("frequency", "amplitude")}
        return {
            f"{self.text}.frequency": float(found.frequencies[0]),
            f"{self.text}.amplitude": float(found.amplitudes[0]),
        }


@dataclass(frozen=True)
class Own:
    """A function of a Solution that gives a number."""

    text: str
    function: Callable[[Solution], float] = field(compare=False)
    numbers: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """That number."""
        return (Variable(self.text),)

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it makes of a run. Raises what it raises; TypeError for what is no number."""
        return {self.text: float(self.function(solution))}


Kept = Sampled | Count | Section | Peak | Own
