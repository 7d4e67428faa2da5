"""A rod at every value of a number: one of its scene, or the share of its loads that it bears."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rodgen.analyse.steady_rod import SteadyRod
from rodgen.arrays import Array
from rodgen.model.terms import TERMS
from rodgen.system import ParameterLine, ParameterRange

LOADS = "loads.", "foundation.", "supports.", "rod.bending_stiffness"


@dataclass(frozen=True)
class RodRange:
    """base: the rod at one of the values, or under all of its loads."""

    base: SteadyRod
    numbers: ParameterRange | ParameterLine

    @classmethod
    def of_load(cls, rod: SteadyRod) -> RodRange:
        """How much of its loads a rod bears, from none to all."""
        system = rod.system
        terms = [TERMS[name] for name in system.structure.loads]
        names = {one.name for term in terms for one in term.proportions}
        parts = {name: system.values(name) for name in names & system.structure.places.keys()}
        return cls(rod, ParameterLine.of(system, parts))

    @property
    def bounds(self) -> tuple[float, float]:
        """Both ends."""
        return self.numbers.bounds

    @property
    def unit(self) -> float:
        """How far they are apart."""
        return self.numbers.unit

    def rod(self, value: float) -> SteadyRod:
        """The rod at a value. AnalysisError where there is none."""
        numbers = self.numbers
        if isinstance(numbers, ParameterLine):
            return self.base
        if numbers.of_parameters and numbers.key.startswith(LOADS):
            return self.base  # its straight shape, too, and what else does not follow from p alone
        return replace(self.base, system=numbers.at(value))

    def parameters(self, value: float) -> Array:
        """p of the module at a value."""
        return self.numbers.parameters(value)

    def near(self, value: float) -> list[tuple[Array, float]]:
        """p beside a value, and how much each counts in a derivative by the value over the
        range."""
        return self.numbers.near(value)
