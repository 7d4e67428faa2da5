"""Adaptive refinement of a map of two axes, in rounds, where neighbouring points differ.

The first round is a coarse grid; each next one splits the rectangles whose known points are of
different classes, and the large ones beside them, until these are as narrow as asked for. A patch
of another class that lies between the points of the first round is not found.
"""

from __future__ import annotations

import math
import re
from collections.abc import Generator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import even_indices
from rodgen.errors import InputError
from rodgen.integrate.stepper import NO_RESULT
from rodgen.studies.kept_quantities import quantity_variables

if TYPE_CHECKING:
    from rodgen.studies.study import Study

FIRST = 12  # rectangles of the first round along either axis
LARGE = 4  # points across, from which the neighbours of a mixed rectangle are split, too
UNKNOWN, LOST = -1, -2  # classes: not computed, failed
_LEVEL = re.compile(r"(.+?)\s*>\s*([-+.\deE]+)\s*")

Rectangle = tuple[int, int, int, int]  # first and last number of a point along both axes
Rounds = Generator[list[int], Mapping[str, NDArray[Any]], None]


@dataclass(frozen=True)
class PointClasses:
    """Classes of points: the values of a variable of whole numbers or text, or whether a real
    variable is above a level, by default the middle of its values in the first round."""

    name: str
    level: float = math.nan
    ordinal: bool = False

    @classmethod
    def of(cls, study: Study, by: str | None = None) -> PointClasses:
        """Choose the variable. by: its name, with "> level" where it is a real number; by default
        the first that is not real, else the first. Raises InputError."""
        kept = [one for one in quantity_variables(study) if not one.shape]
        ordinal = [one.name for one in kept if one.dtype != "f8"]
        if by is None and kept:
            return cls((ordinal or [kept[0].name])[0], ordinal=bool(ordinal))
        text, level = by or "", math.nan
        if (found := _LEVEL.fullmatch(text)) and found[1] in {one.name for one in kept}:
            text, level = found[1], _parse_level(found[2], text)
        if text not in {one.name for one in kept}:
            names = ", ".join(one.name for one in kept)
            raise InputError("adaptive", by, f"a number or text that is kept: one of {names}")
        return cls(text, level, text in ordinal)

    def with_level(self, values: Mapping[str, NDArray[Any]]) -> PointClasses:
        """Return the classes with a level, by default the middle of these values."""
        if self.ordinal or math.isfinite(self.level):
            return self
        found = values[self.name][np.isfinite(values[self.name])]
        level = (found.min() + found.max()) / 2 if len(found) else 0.0
        return PointClasses(self.name, float(level))

    def classify(
        self, values: Mapping[str, NDArray[Any]], known: dict[Any, int]
    ) -> NDArray[np.int_]:
        """Return the class of every point, LOST if it failed; known: classes of values so far."""
        found, failed = values[self.name], np.isin(values["status"], NO_RESULT)
        keys = found.tolist() if self.ordinal else (found > self.level).tolist()
        made = np.array([known.setdefault(key, len(known)) for key in keys], dtype=int)
        return np.where(failed, LOST, made)


def refinement_rounds(study: Study, width: float | None = None, by: str | None = None) -> Rounds:
    """Yield the flat numbers of the points to compute, round by round; their results are sent in,
    arrays by the names of variables in the same order.

    width: share of an axis within which the border between classes is to be found; by default the
    spacing of the grid. by: see `PointClasses.of`. Raises InputError for a study that is no grid of
    two axes of two values or more, and for a width that is not between 0 and 1."""
    shape, least = _check_grid(study, width)
    by_class, known = PointClasses.of(study, by), dict[Any, int]()
    classes = np.full(shape, UNKNOWN)
    left = _first_rectangles(shape, least)
    asked = sorted({corner for one in left for corner in _corners(one)})
    while asked:
        flat = [int(np.ravel_multi_index(at, shape)) for at in asked]
        values = yield flat
        by_class = by_class.with_level(values)
        classes[tuple(np.array(asked).T)] = by_class.classify(values, known)
        left = _split_rectangles(left, classes, least)
        corners = {corner for one in left for corner in _corners(one)}
        asked = sorted(at for at in corners if classes[at] == UNKNOWN)


def _check_grid(study: Study, width: float | None) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the shape of the grid, and the width to be reached along both axes, in its steps."""
    if study.sample is not None or len(study.axes) != 2 or min(study.shape) < 2:
        raise InputError("adaptive", list(study.shape), "a grid of two axes, of two values or more")
    if width is not None and not (isinstance(width, int | float) and 0 < width < 1):
        raise InputError("adaptive", width, "a width above 0 and below 1, the share of an axis")
    rows, columns = study.shape
    least = [max(1, int((width or 0.0) * (count - 1) + 1e-9)) for count in (rows, columns)]
    return (rows, columns), (least[0], least[1])


def _first_rectangles(shape: tuple[int, int], least: tuple[int, int]) -> list[Rectangle]:
    """Return the rectangles of the first round."""
    cuts = []
    for count, step in zip(shape, least, strict=True):
        parts = min(FIRST, max(1, (count - 1) // step))
        cuts.append(even_indices(0, count - 1, parts + 1).tolist())
    rows, columns = (list(pairwise(cut)) for cut in cuts)
    return [(*row, *column) for row in rows for column in columns]


def _corners(one: Rectangle) -> list[tuple[int, int]]:
    a, b, c, d = one
    return [(a, c), (a, d), (b, c), (b, d)]


def _split_rectangles(
    left: list[Rectangle], classes: NDArray[np.int_], least: tuple[int, int]
) -> list[Rectangle]:
    """Return the rectangles of the next round: parts of those in or beside which classes differ;
    the others as they are, since a neighbour's points may yet show that they are mixed."""
    made: list[Rectangle] = []
    for a, b, c, d in left:
        wide, high = b - a > least[0], d - c > least[1]
        margin = 1 if max(b - a, d - c) >= LARGE else 0
        rows, columns = margin * (b - a), margin * (d - c)
        around = classes[max(0, a - rows) : b + rows + 1, max(0, c - columns) : d + columns + 1]
        there = around[around != UNKNOWN]
        if not (wide or high):
            continue
        if (there == there[0]).all():
            made.append((a, b, c, d))
            continue
        across = [(a, (a + b) // 2), ((a + b) // 2, b)] if wide else [(a, b)]
        along = [(c, (c + d) // 2), ((c + d) // 2, d)] if high else [(c, d)]
        made += [(*row, *column) for row in across for column in along]
    return made


def _parse_level(text: str, whole: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError("adaptive", whole, "the name of a variable > a number") from None
