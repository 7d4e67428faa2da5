"""A scene as something to be integrated by anyone: start, span, samples, stretches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np

import rodgen
from rodgen.judge.precision.contestant import Array

SAMPLES = 100  # intervals between the states that are compared


def without_events(table: dict[str, Any]) -> dict[str, Any]:
    """A scene's tables as they are integrated by everyone: peers know nothing of its events, and
    states can be compared only where all of them reach the end."""
    return {name: value for name, value in table.items() if name != "events"}


@dataclass(frozen=True, eq=False)
class Job:
    """A scene, of which every contestant gives the states at the same times."""

    name: str
    scene: rodgen.Scene

    @classmethod
    def of(cls, name: str, table: dict[str, Any]) -> Job:
        """From the scene's tables; its samples are a hundredth of the span apart."""
        scene = rodgen.Scene.from_dict(without_events(table))
        first, last = scene.integrate.span
        return cls(name, scene.with_integrate(output_every=(last - first) / SAMPLES))

    @cached_property
    def model(self) -> ModuleType:
        """The module in C, by which states are judged."""
        return rodgen.build(self.scene, target="c")

    @cached_property
    def p(self) -> Array:
        """Its parameters."""
        p: Array = self.model.parameters(**self.scene.parameters)
        return p

    @cached_property
    def start(self) -> Array:
        """The state at the start (states,)."""
        y0: Array = self.scene.initial_state()
        return y0

    @property
    def span(self) -> tuple[float, float]:
        """From when to when [s]."""
        first, last = self.scene.integrate.span
        return first, last

    @cached_property
    def times(self) -> Array:
        """When the states are compared [s] (samples,), start and end among them."""
        times: Array = np.asarray(self.scene.integrate.samples)
        return times

    @property
    def stretches(self) -> list[tuple[float, float]]:
        """The span, parted where a load is not smooth: every method steps onto these times."""
        first, last = self.span
        return list(pairwise([first, *self.scene.breaks(), last]))
