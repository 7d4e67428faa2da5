"""Variables of a study, with names, dimensions and types known before any result; arrays of a block
while its points are computed; and parameters and initial states of many points at once.

A varied number that only stands in p or y0 is set there for all points at once. All else that is
varied, and every value that its table refuses, needs a scene of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.dataset_result import DOUBTS, LONG_NAME, UNITS, UNKNOWN
from rodgen.integrate.stepper import FAILED, FINISHED, TOO_LONG
from rodgen.scene.plain_tables import is_number
from rodgen.studies.sampling import Point, reference_point
from rodgen.studies.specification import Specification
from rodgen.system import ParameterSlot, System

MESSAGE = 200  # characters of a message that are kept


@dataclass(frozen=True)
class StudyVariable:
    """An array of results. dims, shape: beside those of the points; dtype: as NumPy writes it;
    fill: value where there is no result; words: description."""

    name: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    dtype: str = "f8"
    units: str = ""
    fill: Any = math.nan
    words: str = ""

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the array in xarray: description, units, fill value of whole numbers."""
        whole = self.dtype.startswith("i")
        found = {LONG_NAME: self.words, UNITS: self.units, UNKNOWN: self.fill if whole else ""}
        return {name: value for name, value in found.items() if value != ""}


# Variables of every study.
ALWAYS = (
    StudyVariable("status", dtype="U8", fill=""),
    StudyVariable("message", dtype=f"U{MESSAGE}", fill=""),
    StudyVariable(DOUBTS, dtype="i4", fill=-1, words="doubts about the numbers"),
    StudyVariable("energy_error", units="J"),
    StudyVariable("seconds", units="s"),
)
METHOD = StudyVariable("method", dtype="U16", fill="")  # of runs: the method that computed them


class PointArrays:
    """Arrays of the variables of so many points, which hold fill values until a point is set."""

    def __init__(self, variables: Sequence[StudyVariable], count: int):
        self.arrays = {
            one.name: np.full((count, *one.shape), one.fill, dtype=one.dtype) for one in variables
        }
        self.arrays["seconds"][:] = 0.0

    def set_point(
        self,
        at: int,
        values: Mapping[str, Any],
        energy_error: float,
        message: str,
        doubts: int,
    ) -> None:
        """Store the results of a point."""
        for name, value in values.items():
            self.arrays[name][at] = value
        self.arrays["energy_error"][at], self.arrays["doubts"][at] = energy_error, doubts
        self.arrays["status"][at], self.arrays["message"][at] = FINISHED, message[:MESSAGE]

    def set_points(
        self,
        at: NDArray[np.intp],
        values: Mapping[str, NDArray[Any]],
        energy_error: NDArray[np.float64],
        status: NDArray[np.str_],
        messages: Mapping[int, str],
        doubts: NDArray[np.intp],
    ) -> None:
        """Store the results of points computed together; messages: by their position among them."""
        whole = status == FINISHED
        for name, value in values.items():
            self.arrays[name][at[whole]] = value[whole]
        self.arrays["energy_error"][at[whole]] = energy_error[whole]
        self.arrays["doubts"][at[whole]] = doubts[whole]
        self.arrays["status"][at] = status
        for place, message in messages.items():
            self.arrays["message"][at[place]] = message[:MESSAGE]

    def time_out(self, at: int, seconds: float | None) -> None:
        """Record that a point took longer than so many seconds."""
        self.fail(at, f"took longer than {seconds:g} s", TOO_LONG)

    def fail(self, at: int, message: str, status: str = FAILED) -> None:
        """Record that a point failed, and why."""
        self.arrays["status"][at], self.arrays["message"][at] = status, message[:MESSAGE]


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


@lru_cache(maxsize=8)
def slot_names(study: Specification) -> tuple[str, ...]:
    """Return the names of varied numbers that only stand in p or y0, judged by one point. Raises
    InputError where the scene refuses all points that are tried."""
    point = reference_point(study)
    system = System(study.scene_at(point))
    numbers = (name for name, value in point.items() if is_number(value))
    return tuple(name for name in numbers if _slot(study, system, name) is not None)


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
