"""Reference point of a study, from which the properties common to all of its points are found."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from rodgen.errors import InputError
from rodgen.studies.sampling import Point, points_at
from rodgen.studies.specification import Specification

MOST_TRIED = 1000


@lru_cache(maxsize=8)
def _reference_index(study: Specification) -> int:
    refused: InputError | None = None
    for index in _candidates(study.count):
        try:
            study.system_at(points_at(study, [index])[0])
        except InputError as error:
            refused = refused or error
        else:
            return index
    assert refused is not None
    raise refused


def reference_point(study: Specification) -> Point:
    """Return the first point that the scene accepts, of both ends, the middle and up to a thousand
    others. Raises InputError where it refuses them all."""
    return points_at(study, [_reference_index(study)])[0]


def _candidates(count: int) -> Iterator[int]:
    yield from (0, count - 1, count // 2)
    tried = min(count, MOST_TRIED)
    yield from (at * count // tried for at in range(tried))
