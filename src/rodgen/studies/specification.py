"""Specification of a study as plain data: a scene, and what of it is varied, computed and kept."""

from __future__ import annotations

import hashlib
import inspect
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from rodgen.scene import Scene
from rodgen.scene.keys import find_value
from rodgen.studies.axis import EXTENDABLE, Axis, Sample, Value
from rodgen.system import System

Kept = str | Callable[..., Any]
Texts = dict[tuple[str, ...], str]  # generated texts by their entries in the cache


@dataclass(frozen=True, eq=False, repr=False)
class Specification:
    """Plain data of a study, with the scene and the system of every point; see Study."""

    name: str
    scene: dict[str, Any]
    axes: tuple[Axis, ...]
    sample: Sample | None = None
    analysis: str = "run"
    keep: tuple[Kept, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)
    time_limit: float | None = None

    @cached_property
    def system(self) -> System:
        """The system of the scene before anything is varied."""
        return System(Scene.from_dict(self.scene))

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the results: the varied keys of a grid, "point" of a sample."""
        return tuple(one.name for one in self.axes) if self.sample is None else ("point",)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each dimension."""
        if self.sample is not None:
            return (self.sample.count,)
        return tuple(len(one.values) for one in self.axes)

    @property
    def count(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @cached_property
    def places(self) -> dict[str, tuple[str, ...]]:
        """Path of every varied key through tables and lists of the scene, by its dotted name."""
        values = (one.values for one in self.axes if isinstance(one.values, tuple))
        laws = [value for of in values for value in of if isinstance(value, str)]
        return {one.name: find_value(self.scene, one.name, others=laws)[0] for one in self.axes}

    def place(self, name: str) -> tuple[str, ...]:
        """Return the path of a varied key through tables and lists of the scene, a body by its
        place in the list.

        name: the dotted name of the key.
        """
        return self.places[name]

    def scene_at(self, point: Mapping[str, Value]) -> Scene:
        """Return the scene of a point. Another number of links converts damping as
        `Scene.with_links` does.

        point: values of the varied keys, in SI units; it may leave keys as they are.

        Raises InputError.
        """
        return self.system_at(point).scene

    def system_at(self, point: Mapping[str, Value]) -> System:
        """Return the system of a point.

        point: values of the varied keys, in SI units; it may leave keys as they are.

        Raises InputError.
        """
        return self.system.at(point, unused=True)

    @cached_property
    def contents(self) -> dict[str, str]:
        """Parts of the study as text, equal for equal studies. The number of points of a sample
        that can be extended is left out."""
        axes = [one.contents for one in self.axes]
        sample = None if self.sample is None else self.sample.model_dump()
        if sample is not None and sample["method"] in EXTENDABLE:
            del sample["count"]
        parts: dict[str, Any] = {
            "scene": self.scene,
            "vary": axes,
            "sample": sample,
            "analysis": self.analysis,
            "keep": [_kept_text(one) for one in self.keep],
            "options": self.options,
            "time_limit": self.time_limit,
        }
        return {name: json.dumps(part, sort_keys=True) for name, part in parts.items()}

    @cached_property
    def digest(self) -> str:
        """Hash of the contents, equal for equal studies."""
        return hashlib.sha256("\0".join(self.contents.values()).encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Specification) and self._identity == other._identity

    def __hash__(self) -> int:
        return hash(self._identity)

    @property
    def _identity(self) -> tuple[str, int]:
        return self.digest, self.count


def _kept_text(kept: Kept) -> str:
    """Return the text of a kept quantity; of a function, its name and a hash of its source."""
    if isinstance(kept, str):
        return kept
    try:
        text = inspect.getsource(kept)
    except (OSError, TypeError):
        code = getattr(kept, "__code__", None)
        text = repr((code.co_code, code.co_consts)) if code else repr(kept)
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    return f"{getattr(kept, '__name__', type(kept).__name__)} {digest}"
