"""A point of a study by which what all of its points have in common is found."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from rodgen.errors import InputError
from rodgen.studies.points import Point, points
from rodgen.studies.specification import Specification

MOST_TRIED = 1000


@lru_cache(maxsize=8)
def _reference(study: Specification) -> int:
    refused: InputError | None = None
    for index in _tried(study.count):
        try:
            study.system_at(points(study, [index])[0])
        except InputError as error:
            refused = refused or error
        else:
            return index
    assert refused is not None
    raise refused


def reference(study: Specification) -> Point:
    """The first point that the scene does not refuse, of the ends, the middle and up to a thousand
    others. Raises InputError where it refuses them all."""
    return points(study, [_reference(study)])[0]


def _tried(count: int) -> Iterator[int]:
    yield from (0, count - 1, count // 2)
    tried = min(count, MOST_TRIED)
    yield from (at * count // tried for at in range(tried))
