"""A number of a scene that is varied, and the system of equations at each of its values."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace

from rodgen.analyse.steady_rod import SteadyRod
from rodgen.arrays import Array
from rodgen.model.terms import TERMS
from rodgen.system import ParameterLine, ParameterRange

LOADS = "loads.", "foundation.", "supports.", "rod.bending_stiffness"
STEP = 1e-3  # of the range, of differences of fourth order: their error is its fourth power
FOURTH = ((1, 8 / 12), (-1, -8 / 12), (2, -1 / 12), (-2, 1 / 12))


class Variable(ABC):
    """A number between two ends that a system of equations depends on."""

    ends: tuple[float, float]
    base: SteadyRod

    @property
    def unit(self) -> float:
        """How far the ends are apart."""
        return abs(self.ends[1] - self.ends[0])

    @abstractmethod
    def parameters(self, value: float) -> Array:
        """p of the module at a value."""

    def rod(self, value: float) -> SteadyRod:
        """The system at a value. AnalysisError where there is none."""
        return self.base

    def near(self, value: float) -> list[tuple[Array, float]]:
        """Parameters beside a value, and how much each counts in a derivative by the value over the
        range."""
        step = STEP * self.unit
        return [(self.parameters(value + k * step), share / STEP) for k, share in FOURTH]


class LoadFactor(Variable):
    """How much of its loads a rod bears, from none to all."""

    ends = (0.0, 1.0)

    def __init__(self, rod: SteadyRod):
        self.base = rod
        system = rod.system
        terms = [TERMS[name] for name in system.structure.loads]
        names = {one.name for term in terms for one in term.proportions}
        parts = {name: system.values(name) for name in names & system.structure.places.keys()}
        self._line = ParameterLine.of(system, parts)

    def parameters(self, value: float) -> Array:
        return self._line.parameters(value)

    def near(self, value: float) -> list[tuple[Array, float]]:
        """All of them less none: forces are in proportion to the factor."""
        return [(self.parameters(1.0), 1.0), (self.parameters(0.0), -1.0)]


class Key(Variable):
    """A key of a scene between two values; rod: at the first value that is asked for."""

    def __init__(self, rod: SteadyRod, values: ParameterRange):
        self.base, self.ends, self._range = rod, values.bounds, values
        key = values.key
        slot = rod.system.parameter_map.slot(key)
        # What else a rod is, its straight shape among it, does not follow from these.
        self._shared = slot is not None and not len(slot.y) and key.startswith(LOADS)

    def rod(self, value: float) -> SteadyRod:
        return self.base if self._shared else replace(self.base, system=self._range.at(value))

    def parameters(self, value: float) -> Array:
        low, high = sorted(self.ends)
        if self._shared and not low <= value <= high:
            return self._on_line(value)
        return self._range.parameters(value)

    def near(self, value: float) -> list[tuple[Array, float]]:
        if not self._shared:
            return super().near(value)
        return [(self._on_line(value + k * STEP * self.unit), s / STEP) for k, s in FOURTH]

    def _on_line(self, value: float) -> Array:
        """p on the line through both ends, also where the scene refuses a value beyond them."""
        low, high = ((end, self._range.parameters(end)) for end in self.ends)
        return ParameterLine.through(low, high).parameters(value)
