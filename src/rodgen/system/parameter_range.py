"""Parameters of continuation: a number of the scene, or a factor of parameters of the module."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.system.system import System

SAME = "a number that leaves the structure of the equations as it is"
WHOLE = ("rod.links", "integrate.max_steps")  # keys that no branch can follow
KEPT = 64  # systems remembered
ROUNDING = 1e-12  # of a parameter
STEP = 1e-3  # of a range, of differences of fourth order: their error is its fourth power
FOURTH = ((1, 8 / 12), (-1, -8 / 12), (2, -1 / 12), (-2, 1 / 12))
PLACES = (-2, -1, 0, 1, 2)
Beside = list[tuple[Array, float]]  # p, and how much each counts in a derivative


class ParameterRange:
    """A number of a system between two values, which leaves the structure of the equations.

    system: whose number it is; key: of its scene; bounds: both values, in SI units; unit: the width
    of the range.
    """

    def __init__(self, system: System, key: str, bounds: tuple[float, float]):
        """Raise InputError for a key that the scene does not have, that is no number, that changes
        the structure, such as the number of links, or on which the equations do not depend; and for
        values that the scene refuses."""
        self.system, self.key, self.bounds = system, key, bounds
        self.unit = abs(bounds[1] - bounds[0])
        self._systems: dict[float, System] = {}
        check_key(system, key)
        low, high = bounds
        if not all(is_number(to_plain(value, key)) and np.isfinite(value) for value in bounds):
            raise InputError("bounds", bounds, "(a, b), two finite numbers")
        if low == high:
            raise InputError("bounds", bounds, f"a range of {key}: its ends are both {low:g}")
        made = [system.at({key: float(value)}) for value in bounds]
        if any(one.structure != system.structure for one in made):
            raise InputError("vary", key, SAME)
        if np.array_equal(made[0].p, made[1].p):
            raise InputError("vary", key, "a number that the equations depend on")

    def at(self, value: float) -> System:
        """The system at a value. Raises AnalysisError where the scene refuses it."""
        if value not in self._systems:
            while len(self._systems) > KEPT:
                self._systems.pop(next(iter(self._systems)))
            try:
                self._systems[value] = self.system.at({self.key: float(value)})
            except InputError as error:
                raise AnalysisError(str(error)) from None
        return self._systems[value]

    def parameters(self, value: float) -> Array:
        """Parameters p of the module at a value; beyond the ends, where the scene may refuse it, on
        the line through both, if the number affects p alone. Raises AnalysisError."""
        low, high = sorted(self.bounds)
        if self._line is not None and not low <= value <= high:
            return self._line.parameters(value)
        return self.at(value).p

    def difference_points(self, value: float) -> Beside:
        """Vectors p beside a value, and their weights in a finite difference by the value over the
        range: on the line through both ends where p lies on it, else at values within the range.
        Raises AnalysisError."""
        step = STEP * self.unit
        if self._line is not None and self._is_linear:
            return [(self._line.parameters(value + k * step), w / STEP) for k, w in FOURTH]
        low, high = sorted(self.bounds)
        middle = min(max(value, low + 2 * step), high - 2 * step)
        weights = _derivative_weights((value - middle) / step) / STEP
        return [(self.at(middle + k * step).p, w) for k, w in zip(PLACES, weights, strict=True)]

    @property
    def affects_only_p(self) -> bool:
        """Whether the number affects p alone."""
        slot = self.system.parameter_map.slot(self.key)
        return slot is not None and not len(slot.y)

    @cached_property
    def _line(self) -> ParameterLine | None:
        if not self.affects_only_p:
            return None
        low, high = ((end, self.at(end).p) for end in self.bounds)
        return ParameterLine.through(low, high)

    @cached_property
    def _is_linear(self) -> bool:
        """Whether p lies on that line all along; that of several supports at a point does not."""
        middle = sum(self.bounds) / 2
        here, p = self.at(middle).p, self._line.parameters(middle) if self._line else 0.0
        return bool((np.abs(here - p) <= ROUNDING * np.abs(here)).all())


@dataclass(frozen=True, eq=False)
class ParameterLine:
    """Parameters p of a module as a linear function of a number.

    start: p (width,) at the number 0; slope: by how much p changes with the number, (width,);
    bounds: of the number where it is a share; unit: the width of that range.
    """

    start: Array
    slope: Array
    bounds: ClassVar[tuple[float, float]] = (0.0, 1.0)
    unit: ClassVar[float] = 1.0

    @classmethod
    def of(cls, system: System, parts: Mapping[str, ArrayLike]) -> ParameterLine:
        """Line on which some parameters of a system are in proportion to the number.

        parts: those at the number 1, by their names in the module.
        """
        start, slope = system.p.copy(), np.zeros(len(system.p))
        for name, part in parts.items():
            place = system.structure.slices[name]
            start[place], slope[place] = 0.0, part
        return cls(start, slope)

    @classmethod
    def through(cls, low: tuple[float, Array], high: tuple[float, Array]) -> ParameterLine:
        """Line through p at two numbers."""
        (a, p), (b, q) = low, high
        slope = (q - p) / (b - a)
        return cls(p - a * slope, slope)

    def parameters(self, value: float) -> Array:
        """p of the module (width,) at a value of the number."""
        return self.start + value * self.slope

    def difference_points(self, value: float) -> Beside:
        """Parameters p at 1 and at 0, with weights 1 and -1: their difference is the slope."""
        return [(self.parameters(1.0), 1.0), (self.parameters(0.0), -1.0)]


def _derivative_weights(x: float) -> Array:
    """Weights of values at PLACES in a derivative at x, exact up to the fourth degree."""
    powers = np.arange(5)
    due = powers * x ** np.maximum(powers - 1, 0)
    return np.asarray(np.linalg.solve(np.vander(PLACES, increasing=True).T, due))


def check_key(system: System, key: str) -> None:
    """Raise InputError for a key that has no value in the scene, or that no branch can follow."""
    if key in WHOLE:
        raise InputError("vary", key, SAME)
    system.value_of(key)


def system_at_start(system: System, key: str, value: float) -> System:
    """System at the first value of a key, which may replace a law in time. Raises InputError."""
    check_key(system, key)
    return system.at({key: float(value)})
