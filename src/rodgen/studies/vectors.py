"""Parameters and initial states of many points at once.

A varied number that the scene does no more with than to copy it into p or y0 is copied here, for
all points in one go; that it is such a number is found out by trying it on one point. Whatever
else is varied, and every value that its table refuses, goes through a scene of its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.expression import Expression
from rodgen.scene.keys import texts
from rodgen.scene.plain import entry, is_number, put
from rodgen.scene.tables import Finite, Table
from rodgen.studies.points import Point
from rodgen.studies.reference import reference

if TYPE_CHECKING:
    from rodgen.studies.specification import Study

TABLES = "rod", "loads", "parameters", "initial", "states"  # of which numbers are copied
STIFFNESS = "rod", "bending_stiffness"
TRIES = (0.875, 1.25), (0.5, 0.25)  # times a number, and instead of zero
_FINITE = TypeAdapter(Finite)


@dataclass(frozen=True)
class Slot:
    """Where a number is copied to in p and in y0, and by what it is checked.

    table: of the scene, with the keys in it, None for one of [parameters]; laws: the expressions
    that name it.
    """

    p: NDArray[np.intp]
    y: NDArray[np.intp]
    table: Table | None
    keys: tuple[str, ...]
    laws: tuple[Expression, ...] = ()
    known: dict[Any, bool] = field(default_factory=dict, compare=False)

    def takes(self, value: Any) -> bool:
        """Whether its table takes a value."""
        found = self.known.get(value)
        if found is None:
            if len(self.known) > 10**5:
                self.known.clear()
            found = self.known[value] = is_number(value) and self._takes(value)
        return found

    def _takes(self, value: Any) -> bool:
        try:
            if self.table is None:
                _FINITE.validate_python(value, strict=True)
                return all(law.takes({self.keys[-1]: value}) for law in self.laws)
            given = self.table.model_dump(exclude_none=True)
            put(given, self.keys, value)
            type(self.table).model_validate(given)
        except (ValidationError, SceneError):
            return False
        return True


@dataclass(frozen=True)
class Copying:
    """Points that share all but numbers that are copied: the scene of one of them, its p and y0,
    and where the numbers go."""

    scene: Scene
    p: Array
    y: Array
    slots: Mapping[str, Slot]

    def rows(self, points: Sequence[Point]) -> tuple[Array, Array, list[bool]]:
        """p and y0 of points, (points, parameters) and (points, states), and which of the points
        have a value that may be copied everywhere."""
        p, y = np.tile(self.p, (len(points), 1)), np.tile(self.y, (len(points), 1))
        taken = [True] * len(points)
        for name, slot in self.slots.items():
            values = [point[name] for point in points]
            for at, value in enumerate(values):
                if not slot.takes(value):
                    taken[at], values[at] = False, 0.0
            column = np.array(values, dtype=float)[:, None]
            p[:, slot.p], y[:, slot.y] = column, column
        return p, y, taken


def packed(scene: Scene) -> tuple[Array, Array]:
    """p and y0 of one scene."""
    structure, given = scene.structure, scene.parameters
    p = np.empty(structure.width)
    for name, place in structure.places.items():
        p[place] = given[name]
    return p, scene.initial_state()


def copying(study: Study, point: Point, names: Sequence[str]) -> Copying | None:
    """How points are made that differ from this one in numbers of some names alone; None where one
    of the numbers is more than copied. Raises SceneError for a point that the scene refuses."""
    scene = study.scene_at(point)
    p, y = packed(scene)
    slots: dict[str, Slot] = {}
    for name in names:
        slot = _slot(study, point, name, scene, p, y)
        if slot is None:
            return None
        slots[name] = slot
    return Copying(scene, p, y, slots)


def copied(study: Study) -> tuple[str, ...]:
    """Names of varied numbers that are copied, by the look of one point. Raises SceneError where
    the scene refuses all that are tried."""
    point = reference(study)
    scene = study.scene_at(point)
    p, y = packed(scene)
    return tuple(name for name in point if _slot(study, point, name, scene, p, y) is not None)


def _slot(study: Study, point: Point, name: str, scene: Scene, p: Array, y: Array) -> Slot | None:
    """Where a varied number is copied to, if it is."""
    keys, value = study.place(name), point[name]
    if keys[0] not in TABLES or not is_number(value):
        return None
    if keys[:2] == STIFFNESS and scene.rod.spring is not None:
        return None  # with a law of springs, a rod without stiffness is refused
    laws = _laws(scene, keys[-1]) if keys[0] == "parameters" else ()
    if laws is None:
        return None
    before, places = np.concatenate((p, y)), None
    for other in [value * by for by in TRIES[0]] if value else TRIES[1]:
        try:
            tried = study.scene_at({**point, name: other})
        except SceneError:
            return None
        if tried.structure != scene.structure:
            return None
        after = np.concatenate(packed(tried))
        changed = np.flatnonzero(~((after == before) | (np.isnan(after) & np.isnan(before))))
        fits = (before[changed] == value).all() and (after[changed] == other).all()
        if not len(changed) or not fits or not (places is None or np.array_equal(places, changed)):
            return None
        places = changed
    assert places is not None
    table, inner = _table(scene, keys)
    width = len(p)
    return Slot(places[places < width], places[places >= width] - width, table, inner, laws)


def _table(scene: Scene, keys: tuple[str, ...]) -> tuple[Table | None, tuple[str, ...]]:
    """The innermost table of a scene on the way to a value, and the keys in it."""
    if keys[0] == "parameters":
        return None, keys
    found: Table = scene
    depth = 0
    for at in range(1, len(keys)):
        inner = entry(scene, *keys[:at])
        if isinstance(inner, Table):
            found, depth = inner, at
    return found, keys[depth:]


def _laws(scene: Scene, number: str) -> tuple[Expression, ...] | None:
    """The expressions that name a number of [parameters]; None where one is more than a law that
    the module has as it stands: a table, what is looked at all along the rod or the span, or what
    a scene makes other numbers of, which may switch at a value that was not tried."""
    laws = [e for e in (*scene.expressions.values(), *scene.rates.values()) if number in e.names]
    along = {e.text for e in scene.along.values()}
    if any(e.tabulated or e.text in along for e in laws):
        return None
    known, naming = {e.text for e in laws}, re.compile(rf"\b{re.escape(number)}\b")
    found = {text for text in texts(scene.model_dump(exclude_none=True)) if naming.search(text)}
    return tuple(laws) if found <= known else None


def groups(points: Sequence[Point], names: Sequence[str]) -> Iterator[tuple[Point, list[int]]]:
    """Points by their values of some names: these values, and the numbers of the points."""
    found: dict[tuple[Any, ...], list[int]] = {}
    for at, point in enumerate(points):
        found.setdefault(tuple(point[name] for name in names), []).append(at)
    for values, members in found.items():
        yield dict(zip(names, values, strict=True)), members
