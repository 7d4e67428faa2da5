"""Samples of a run that need no integration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import xarray as xr

from rodgen.arrays import Array
from rodgen.integrate.files.file_layout import NO_STATS
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import Stats
from rodgen.loading import build
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene import Scene
from rodgen.system import System

STATS = Stats(10, 2, 30, 4, 5, 0.25)
EVENTS = [{"quantity": "phi_1", "value": 0.0}, {"quantity": "tip_y", "value": 1.0, "name": "high"}]


@dataclass
class Samples:
    """States and works at random; how to put them into a file."""

    scene: Scene
    model: ModuleType
    p: Array
    t: Array
    y: Array
    work: dict[str, Array]

    def create(self, path: Path, events: int = 0) -> Stream:
        return Stream.create(path, System(self.scene), self.model, list(self.work), events)

    def append(self, stream: Stream, first: int, last: int) -> None:
        part = slice(first, last)
        work = {term: values[part] for term, values in self.work.items()}
        stream.append(self.t[part], self.y[part], work)

    @property
    def solution(self) -> Solution:
        return Solution(System(self.scene), self.t, self.y, self.work, NO_STATS, model=self.model)


def same(one: Solution, other: Solution) -> None:
    """Both are the same run, to the bit."""
    for name in ("scene", "stats", "status", "message", "energy_error"):
        assert getattr(one, name) == getattr(other, name), name
    assert [event[:2] for event in one.events] == [event[:2] for event in other.events]
    xr.testing.assert_identical(one.to_xarray(), other.to_xarray())


@pytest.fixture
def samples(make_scene: Callable[..., Scene]) -> Callable[..., Samples]:
    """Samples of two links under loads of most kinds; keywords are those of make_scene."""

    def make(count: int = 200, **keywords: object) -> Samples:
        bare = make_scene(**{"links": 2, "terms": (*THESIS_TERMS, "supports"), **keywords})
        scene = Scene.from_dict({**bare.model_dump(exclude_none=True), "events": EVENTS})
        model = build(scene, "numpy")
        p = model.parameters(**scene.parameters)
        random = np.random.default_rng(7)
        t = np.arange(float(count)) / 100
        y = random.normal(size=(count, len(model.STATE)))
        terms = model.power(0.0, y[0], p)
        return Samples(scene, model, p, t, y, {term: random.normal(size=count) for term in terms})

    return make
