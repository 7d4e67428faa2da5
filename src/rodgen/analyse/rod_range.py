"""A rod as a function of one parameter: a number of its scene, or the share of its loads."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rodgen.analyse.steady_rod import SteadyRod
from rodgen.model.terms import TERMS
from rodgen.system import ParameterLine, ParameterRange

LOADS = "loads.", "foundation.", "supports.", "rod.bending_stiffness"


@dataclass(frozen=True)
class RodRange:
    """Rod along a range of numbers; base: at one of the values, or under all of its loads."""

    base: SteadyRod
    numbers: ParameterRange | ParameterLine

    @classmethod
    def of_load(cls, rod: SteadyRod) -> RodRange:
        """Range of the share of its loads that a rod bears, from none to all."""
        system = rod.system
        terms = [TERMS[name] for name in system.structure.loads]
        names = {one.name for term in terms for one in term.scaling_parameters}
        parts = {name: system.value(name) for name in names & system.structure.slices.keys()}
        return cls(rod, ParameterLine.of(system, parts))

    def rod(self, value: float) -> SteadyRod:
        """Rod at a value. Raises AnalysisError where there is none."""
        numbers = self.numbers
        if isinstance(numbers, ParameterLine):
            return self.base
        if numbers.is_only_in_parameters and numbers.key.startswith(LOADS):
            return self.base  # its straight shape, and all else that is not in p, stays
        return replace(self.base, system=numbers.at(value))
