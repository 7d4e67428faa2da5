"""A number of a scene that is varied, and the system of equations at each of its values."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property

import numpy as np

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.system import System, frozen
from rodgen.integrate.stepper import Array
from rodgen.model.terms import TERMS
from rodgen.scene import Scene, SceneError
from rodgen.scene.keys import with_value
from rodgen.scene.plain import is_number, plain

TRIED = (0.0, 0.21, 0.5, 0.83, 1.0)  # of the range: whether parameters lie on a line
LINE = 1e-14  # of the largest: what a line may miss parameters by
STEP = 1e-3  # of the range, of differences of fourth order: their error is its fourth power
FOURTH = ((1, 8 / 12), (-1, -8 / 12), (2, -1 / 12), (-2, 1 / 12))
SAME = "a number that leaves the structure of the equations as it is"
WHOLE = ("rod.links", "integrate.max_steps")  # keys that no branch can follow
KEPT = 64  # systems remembered


class Variable(ABC):
    """A number between two ends that a system of equations depends on."""

    ends: tuple[float, float]
    base: System

    @property
    def unit(self) -> float:
        """How far the ends are apart."""
        return abs(self.ends[1] - self.ends[0])

    @abstractmethod
    def parameters(self, value: float) -> Array:
        """p of the module at a value."""

    def system(self, value: float) -> System:
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

    def __init__(self, system: System):
        self.base = system
        terms = [TERMS[name] for name in system.scene.structure.loads]
        names = [one.name for term in terms for one in term.proportions]
        given = system.given
        self._loads = {name: np.asarray(given[name]) for name in names if name in given}

    def parameters(self, value: float) -> Array:
        return self.base.parameters(**{k: value * load for k, load in self._loads.items()})

    def near(self, value: float) -> list[tuple[Array, float]]:
        """All of them less none: forces are in proportion to the factor."""
        return [(self.parameters(1.0), 1.0), (self.parameters(0.0), -1.0)]


class Key(Variable):
    """A key of a scene between two values.

    Raises SceneError for a key that the scene does not have, that is no number, that changes the
    equations themselves, such as the number of links, or on which they do not depend; and for
    values that the scene refuses.
    """

    def __init__(self, system: System, scene: Scene, key: str, ends: tuple[float, float]):
        self.base, self.scene, self.key, self.ends = system, scene, key, ends
        self._systems: dict[float, System] = {}
        self._check()

    def _check(self) -> None:
        low, high = self.ends
        for value in self.ends:
            if not (is_number(plain(value, self.key)) and np.isfinite(value)):
                raise SceneError(f"vary.{self.key}", value, "a finite number")
        if low == high:
            raise SceneError(f"vary.{self.key}", high, f"a range: its ends are both {low:g}")
        if self._scene(low).structure != self.base.scene.structure:
            raise SceneError("vary", self.key, SAME)
        self._scene(high)
        first, last = (self._made(value).parameters() for value in self.ends)
        if np.array_equal(first, last):
            raise SceneError("vary", self.key, "a number that the equations depend on")

    def _scene(self, value: float) -> Scene:
        return frozen(with_value(self.scene, self.key, float(value)), self.base.t)

    def _made(self, value: float) -> System:
        return replace(self.base, scene=self._scene(value))

    @cached_property
    def _line(self) -> tuple[Array, Array] | None:
        """Parameters at both ends, where all between lie on the line that joins them and nothing
        but parameters follows the key."""
        if not self.key.startswith(("loads.", "foundation.", "rod.bending_stiffness")):
            return None
        (a, b), (low, high) = (
            [self._made(value).parameters() for value in self.ends],
            self.ends,
        )
        for share in TRIED:
            p = self._made(low + share * (high - low)).parameters()
            if not (np.abs(p - (a + share * (b - a))) <= LINE * (np.abs(a) + np.abs(b))).all():
                return None
        return a, b

    def system(self, value: float) -> System:
        if self._line is not None:
            return self.base
        if value not in self._systems:
            while len(self._systems) > KEPT:
                self._systems.pop(next(iter(self._systems)))
            try:
                self._systems[value] = self._made(value)
            except SceneError as error:
                raise AnalysisError(str(error)) from None
        return self._systems[value]

    def parameters(self, value: float) -> Array:
        if self._line is None:
            return self.system(value).parameters()
        (a, b), (low, high) = self._line, self.ends
        share = (value - low) / (high - low)
        return np.asarray(a + share * (b - a))
