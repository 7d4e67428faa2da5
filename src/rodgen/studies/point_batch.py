"""Parameters and initial states of many points at once.

A varied number that goes into p or y0 alone is put there for all points in one go. Whatever else is
varied, and every value that its table refuses, goes through a scene of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.scene.plain import is_number
from rodgen.studies.points import Point
from rodgen.studies.reference import reference
from rodgen.studies.specification import Specification
from rodgen.system import ParameterSlot, System


@dataclass(frozen=True)
class PointBatch:
    """Points that share all but numbers that go into p or y0 alone.

    system: of one of them; slots: where these numbers go, by the names of their keys.
    """

    system: System
    slots: Mapping[str, ParameterSlot]

    @classmethod
    def of(cls, study: Specification, point: Point, names: Sequence[str]) -> PointBatch | None:
        """Points that differ from this one in numbers of some names alone; None where one of the
        numbers is more than a slot. Raises InputError for a point that the scene refuses."""
        system = study.system_at(point)
        slots = {name: _slot(study, system, name) for name in names}
        known = {name: slot for name, slot in slots.items() if slot is not None}
        return cls(system, known) if len(known) == len(slots) else None

    def rows(self, points: Sequence[Point]) -> tuple[Array, Array, list[bool]]:
        """p and y0 of points, (points, parameters) and (points, states), and which of the points
        have a value that may go everywhere."""
        p, y = (np.tile(one, (len(points), 1)) for one in (self.system.p, self.system.y0))
        taken = [True] * len(points)
        for name, slot in self.slots.items():
            values = [point[name] for point in points]
            for at, value in enumerate(values):
                if not slot.takes(value):
                    taken[at], values[at] = False, 0.0
            column = np.array(values, dtype=float)[:, None]
            p[:, slot.p], y[:, slot.y] = column, column
        return p, y, taken


def slot_names(study: Specification) -> tuple[str, ...]:
    """Names of varied numbers that go into p or y0 alone, by the look of one point. Raises
    InputError where the scene refuses all that are tried."""
    point = reference(study)
    system = System(study.scene_at(point))
    return tuple(
        name
        for name, value in point.items()
        if is_number(value) and _slot(study, system, name) is not None
    )


def _slot(study: Specification, system: System, name: str) -> ParameterSlot | None:
    slot = system.parameter_map.slot(".".join(study.place(name)))
    return None if slot is None or slot.anchor else slot


def groups(points: Sequence[Point], names: Sequence[str]) -> Iterator[tuple[Point, list[int]]]:
    """Points by their values of some names: these values, and the numbers of the points."""
    found: dict[tuple[Any, ...], list[int]] = {}
    for at, point in enumerate(points):
        found.setdefault(tuple(point[name] for name in names), []).append(at)
    for values, members in found.items():
        yield dict(zip(names, values, strict=True)), members
