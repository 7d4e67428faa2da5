"""A point of a study by which what all of its points have in common is found."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

from rodgen.scene import SceneError
from rodgen.studies.points import Point, points

if TYPE_CHECKING:
    from rodgen.studies.specification import Study

MOST_TRIED = 1000


@lru_cache(maxsize=8)
def _reference(study: Study) -> int:
    refused: SceneError | None = None
    for index in _tried(study.count):
        try:
            study.scene_at(points(study, [index])[0])
        except SceneError as error:
            refused = refused or error
        else:
            return index
    assert refused is not None
    raise refused


def reference(study: Study) -> Point:
    """The first point that the scene does not refuse, of the ends, the middle and up to a thousand
    others. Raises SceneError where it refuses them all."""
    return points(study, [_reference(study)])[0]


def _tried(count: int) -> Iterator[int]:
    yield from (0, count - 1, count // 2)
    tried = min(count, MOST_TRIED)
    yield from (at * count // tried for at in range(tried))
