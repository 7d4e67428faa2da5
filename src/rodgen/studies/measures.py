"""Quantities that a study can keep of a run: their variables, and how they are computed."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.errors import AnalysisError
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.reductions import Crossing, CrossingResults, Numbers, Reduction
from rodgen.integrate.stepper import FINISHED
from rodgen.model.quantities import describe_number
from rodgen.scene.contact_terms import count_name
from rodgen.studies.point_arrays import StudyVariable

if TYPE_CHECKING:
    from rodgen.arrays import Array
    from rodgen.integrate import Solution
    from rodgen.integrate.ensemble import Ensemble
    from rodgen.integrate.module_facts import ModuleFacts
    from rodgen.scene.integration import EventTable

MOST_POINTS = 1000  # of a section, where no other number is given
EVERY = -math.inf, math.inf
# Of reductions, for labels.
WORDS = {
    "last": "{} at the end",
    "min": "least {}",
    "max": "largest {}",
    "mean": "mean of {}",
    "rms": "rms of {}",
    "std": "standard deviation of {}",
    "time_of_max": "time of the largest {}",
}


def event_crossing(event: EventTable) -> Crossing:
    """Return the crossing that stands for an event of the scene in runs side by side."""
    return Crossing(event.quantity, event.value, event.direction)


def _add_times(words: str, measured: RunMeasure | Reduction) -> str:
    """Add to a description from when to when it is computed."""
    times = [f"from {measured.start:g} s"] * (measured.start > EVERY[0])
    times += [f"to {measured.end:g} s"] * (measured.end < EVERY[1])
    return " ".join((words, *times))


@dataclass(frozen=True)
class RunMeasure(ABC):
    """A quantity that is kept of a run, by default a single number.

    text: as in `keep`; number: name of what it is computed from, "" for none; units: of its values;
    start, end: times [s] between which it is computed.
    """

    text: str
    number: str = ""
    units: str = ""
    start: float = EVERY[0]
    end: float = EVERY[1]

    @property
    def variables(self) -> tuple[StudyVariable, ...]:
        """The variables that it fills."""
        return (StudyVariable(self.text, units=self.units, words=self.words),)

    @property
    def words(self) -> str:
        """Description of it, "" where its text says all."""
        return ""

    @abstractmethod
    def compute(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """Compute it for one run, by the names of its variables."""


@dataclass(frozen=True)
class SampleReduction(RunMeasure):
    """A reduction of the samples of a run."""

    reduction: Reduction = field(kw_only=True)

    @property
    def words(self) -> str:
        """Description of it."""
        words = WORDS[self.reduction.kind].format(describe_number(self.number))
        return _add_times(words, self.reduction)

    def compute(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """Compute it for one run, by the names of its variables."""
        return {self.text: self.reduction.reduce(solution.t, places.values(solution, self.number))}


@dataclass(frozen=True)
class EventCount(RunMeasure):
    """Number of occurrences of an event of the scene between two times [s]."""

    event: str = field(kw_only=True)

    @property
    def variables(self) -> tuple[StudyVariable, ...]:
        """The variable of the count, -1 where there was no run."""
        words = _add_times(f"times of {self.event}", self)
        return (StudyVariable(self.text, dtype="i8", fill=-1, words=words),)

    def compute(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """Compute it for one run, by the names of its variables."""
        found = [x for x in solution.events if self.event in (x.name, count_name(x.name))]
        return {self.text: sum(self.start <= one.t <= self.end for one in found)}

    def crossing(self, event: EventTable, facts: ModuleFacts) -> Crossing:
        """Return the crossing that runs side by side watch for."""
        return replace(event_crossing(event), start=self.start, end=self.end)

    def compute_many(
        self, crossed: CrossingResults, facts: ModuleFacts, p: Array
    ) -> dict[str, Any]:
        """Compute it for many runs, with parameters p (runs, parameters)."""
        return {self.text: crossed.counts}


@dataclass(frozen=True)
class CrossingSection(RunMeasure):
    """Section of a run: a number and the times [s] at the crossings of a level by another number,
    the first `max_points` of those between two times [s]."""

    where: str = field(kw_only=True)
    level: float = field(kw_only=True)
    direction: str = field(kw_only=True)
    event: str = ""
    max_points: int = MOST_POINTS
    dim: str = "crossing"

    @property
    def words(self) -> str:
        """Description of the values."""
        where = f"where {describe_number(self.where)} crosses {self.level:g}"
        return _add_times(f"{describe_number(self.number)} {where}", self)

    @property
    def variables(self) -> tuple[StudyVariable, ...]:
        """The variables of the values and of the times."""
        beyond = (self.dim,), (self.max_points,)
        return (
            StudyVariable(self.text, *beyond, units=self.units, words=self.words),
            StudyVariable(f"{self.text}.t", *beyond, units="s", words="time of the crossing"),
        )

    @property
    def event_table(self) -> dict[str, Any]:
        """Table of the event that a run watches for."""
        crossing = {"quantity": self.where, "value": self.level, "direction": self.direction}
        return crossing | {"name": self.event}

    def compute(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """Compute it for one run, by the names of its variables."""
        met = [e for e in solution.events if e.name == self.event and self.start <= e.t <= self.end]
        met = met[: self.max_points]
        made = {name: np.full(self.max_points, math.nan) for name in (self.text, f"{self.text}.t")}
        if met:
            t, y = np.array([one.t for one in met]), np.array([one.y for one in met])
            system = solution.system
            there = MotionSlice(solution.model, system.p, y, t, timed=system.time_dependent_loads)
            made[self.text][: len(met)] = places.values(there, self.number)
            made[f"{self.text}.t"][: len(met)] = t
        return made

    def crossing(self, event: EventTable, facts: ModuleFacts) -> Crossing:
        """Return the crossing to watch for, which keeps the number, or the states if C lacks it."""
        alone = facts.can_observe(self.number)
        numbers = (self.number,) if alone else tuple(facts.model.STATE)
        counted = replace(event_crossing(event), start=self.start, end=self.end)
        return replace(counted, kept=numbers, max_points=self.max_points)

    def compute_many(
        self, crossed: CrossingResults, facts: ModuleFacts, p: Array
    ) -> dict[str, Any]:
        """Compute it for many runs, with parameters p (runs, parameters)."""
        if facts.can_observe(self.number):
            return {self.text: crossed.values[..., 0], f"{self.text}.t": crossed.t}
        made = np.full(crossed.t.shape, math.nan)
        for run in np.flatnonzero(crossed.counts):
            met = slice(min(int(crossed.counts[run]), self.max_points))
            states, t = crossed.values[run, met], crossed.t[run, met]
            timed = facts.structure.time_dependent_loads(p[run])
            there = MotionSlice(facts.model, p[run], states, t, timed=timed)
            made[run, met] = facts.numbers.values(there, self.number)
        return {self.text: made, f"{self.text}.t": crossed.t}


@dataclass(frozen=True)
class SpectralPeak(RunMeasure):
    """The highest peak in the spectrum of a number between two times [s]."""

    @property
    def words(self) -> str:
        """Description of the peak."""
        return _add_times(f"of the highest peak of {describe_number(self.number)}", self)

    @property
    def variables(self) -> tuple[StudyVariable, ...]:
        """The variables of its frequency and its amplitude."""
        return (
            StudyVariable(f"{self.text}.frequency", units="Hz", words=f"frequency {self.words}"),
            StudyVariable(
                f"{self.text}.amplitude", units=self.units, words=f"amplitude {self.words}"
            ),
        )

    def compute(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """Compute it for one run; not-a-number where there is no peak. Raises InputError for
        samples that are not uniform."""
        return self._highest_peak(solution.t, places.values(solution, self.number))

    def compute_many(self, ensemble: Ensemble, number: int) -> dict[str, Any]:
        """Compute it for many runs; number: index of its traced number. Raises as `compute`."""
        runs = [
            self._highest_peak(*ensemble.trace(rod, number)) if status == FINISHED else {}
            for rod, status in enumerate(ensemble.status.tolist())
        ]
        names = [variable.name for variable in self.variables]
        return {name: np.array([run.get(name, math.nan) for run in runs]) for name in names}

    def _highest_peak(self, t: Array, values: Array) -> dict[str, float]:
        # It brings a third of all that a worker would import.
        from rodgen.analyse.spectrum import find_peaks

        inside = (t >= self.start) & (t <= self.end)
        last = int(np.flatnonzero(inside)[-1]) if inside.any() else 0
        if last > 1 and t[last] - t[last - 1] < 0.999 * (t[1] - t[0]):
            inside[last] = False  # the end of the run, between two samples
        try:
            found = find_peaks(t[inside], values[inside], peaks=1)
        except AnalysisError:
            return {f"{self.text}.{part}": math.nan for part in ("frequency", "amplitude")}
        return {
            f"{self.text}.frequency": float(found.frequencies[0]),
            f"{self.text}.amplitude": float(found.amplitudes[0]),
        }


@dataclass(frozen=True)
class UserFunction(RunMeasure):
    """A user's function that makes a number of a Solution."""

    function: Callable[[Solution], float] = field(kw_only=True, compare=False)

    def compute(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """Call the function. Raises what it raises; TypeError for what is no number."""
        return {self.text: float(self.function(solution))}
