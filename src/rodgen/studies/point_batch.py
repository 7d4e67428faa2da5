"""Parameters and initial states of many points at once.

A varied number that only stands in p or y0 is set there for all points at once. All else that is
varied, and every value that its table refuses, needs a scene of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.scene.plain_tables import is_number
from rodgen.studies.reference_point import reference_point
from rodgen.studies.sampling import Point
from rodgen.studies.specification import Specification
from rodgen.system import ParameterSlot, System


@dataclass(frozen=True)
class PointBatch:
    """Points that differ only in numbers that stand in p or y0.

    system: of one of them; slots: where these numbers stand, by the names of their keys.
    """

    system: System
    slots: Mapping[str, ParameterSlot]

    @classmethod
    def of(cls, study: Specification, point: Point, names: Sequence[str]) -> PointBatch | None:
        """Make the batch of points that differ from this one only in numbers of these names, None
        where one is more than a slot. Raises InputError for a point that the scene refuses."""
        system = study.system_at(point)
        slots = {name: _slot(study, system, name) for name in names}
        known = {name: slot for name, slot in slots.items() if slot is not None}
        return cls(system, known) if len(known) == len(slots) else None

    def rows(self, points: Sequence[Point]) -> tuple[Array, Array, list[bool]]:
        """Return p and y0 of points, (points, parameters) and (points, states), and which of the
        points have values that all slots take."""
        p, y = (np.tile(one, (len(points), 1)) for one in (self.system.p, self.system.y0))
        taken = [True] * len(points)
        for name, slot in self.slots.items():
            values = [point[name] for point in points]
            for at, value in enumerate(values):
                if not slot.accepts(value):
                    taken[at], values[at] = False, 0.0
            column = np.array(values, dtype=float)[:, None]
            p[:, slot.p], y[:, slot.y] = column, column
        return p, y, taken


def slot_names(study: Specification) -> tuple[str, ...]:
    """Return the names of varied numbers that only stand in p or y0, judged by one point. Raises
    InputError where the scene refuses all points that are tried."""
    point = reference_point(study)
    system = System(study.scene_at(point))
    return tuple(
        name
        for name, value in point.items()
        if is_number(value) and _slot(study, system, name) is not None
    )


def _slot(study: Specification, system: System, name: str) -> ParameterSlot | None:
    slot = system.parameter_map.slot(".".join(study.place(name)))
    return None if slot is None or slot.anchor else slot


def group_by(points: Sequence[Point], names: Sequence[str]) -> Iterator[tuple[Point, list[int]]]:
    """Group points by their values of some names; yields these values and the points' numbers."""
    found: dict[tuple[Any, ...], list[int]] = {}
    for at, point in enumerate(points):
        found.setdefault(tuple(point[name] for name in names), []).append(at)
    for values, members in found.items():
        yield dict(zip(names, values, strict=True)), members
