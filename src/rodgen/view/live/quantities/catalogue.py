"""The quantities of a live run by name, and their values at the samples of a chunk."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.view.live.chunk import Chunk
from rodgen.view.live.quantities.groups import Groups
from rodgen.view.live.quantities.named import KINDS, PERIODS, Kind, Place, Quantity, named, numbered
from rodgen.view.live.quantities.source import Source

__all__ = ["KINDS", "PERIODS", "Catalogue", "Kind", "Quantity"]

MOST_PLANS = 256  # kept, one for every set of names that plots have asked for


class _Part(NamedTuple):
    """Columns of a group and where they go."""

    group: str
    columns: NDArray[np.int64]
    to: NDArray[np.int64]


class Catalogue:
    """What can be shown of a scene.

    quantities: all of them by name, in the order in which they are offered; kinds: names by kind,
    of what can be shown together; along: of kinds that go along the rod, where on it their
    quantities are, from 0 at joint 0 to 1 at the tail. All are fixed by the structure of the
    scene: values of parameters are taken from each chunk.
    """

    def __init__(self, scene: Scene, model: ModuleType):
        self.source = Source(scene, model)
        self.quantities: dict[str, Quantity] = {}
        self.kinds: dict[str, list[str]] = {}
        self._places: dict[str, Place] = {}
        for quantity, place in named(self.source):
            self.quantities[quantity.name] = quantity
            self.kinds.setdefault(quantity.kind, []).append(quantity.name)
            self._places[quantity.name] = place
        self.along = {
            kind: (np.array(numbers) + (0.5 if kind in ("phi", "omega") else 0)) / self.source.links
            for kind, numbers in numbered(self.source).items()
            if len(numbers)
        }
        self._plans: dict[tuple[str, ...], list[_Part]] = {}
        self._groups: Groups | None = None

    def columns(self, names: Sequence[str], chunk: Chunk) -> Array:
        """Values of quantities at the samples of a chunk, (K, names). Raises SceneError for a name
        that is not known. Groups are kept for the next call with the same chunk."""
        groups = self.groups(chunk)
        out = np.empty((len(chunk), len(names)))
        for group, columns, to in self._plan(tuple(names)):
            out[:, to] = groups[group][:, columns]
        return out

    def groups(self, chunk: Chunk) -> Groups:
        """The groups of a chunk; those of the last one asked for are kept."""
        groups = self._groups
        if groups is None or groups.chunk is not chunk:
            groups = self._groups = Groups(self.source, chunk)
        return groups

    def quantity(self, name: object, field: str = "quantity") -> Quantity:
        """A quantity by name. Raises SceneError that says what there is."""
        found = self.quantities.get(name) if isinstance(name, str) else None
        if found is None:
            raise SceneError(field, name, self._allowed(str(name), self.quantities))
        return found

    def expand(self, name: object, field: str = "quantity") -> list[str]:
        """The names that a name or a kind stands for."""
        if isinstance(name, str) and name in self.kinds:
            return self.kinds[name]
        if isinstance(name, str) and name in self.quantities:
            return [name]
        raise SceneError(field, name, self._allowed(str(name), [*self.quantities, *self.kinds]))

    def _allowed(self, name: str, known: Sequence[str] | dict[str, Quantity]) -> str:
        """The closest names, and all of them with families shortened."""
        close = get_close_matches(name[:64], known, 3)
        shown = []
        for names in self.kinds.values():
            family = len(names) > 4
            shown.append(f"{names[0]} to {names[-1]}" if family else ", ".join(names))
        every = f"one of {', '.join(shown)}"
        return f"{every} (closest: {', '.join(close)})" if close else every

    def _plan(self, names: tuple[str, ...]) -> list[_Part]:
        """Which columns of which groups are wanted, found once for a set of names."""
        plan = self._plans.get(names)
        if plan is None:
            if len(self._plans) >= MOST_PLANS:
                self._plans.clear()
            plan = self._plans[names] = self._planned(names)
        return plan

    def _planned(self, names: tuple[str, ...]) -> list[_Part]:
        wanted: dict[str, list[tuple[int, int]]] = {}
        for at, name in enumerate(names):
            self.quantity(name)
            group, column = self._places[name]
            wanted.setdefault(group, []).append((column, at))
        return [
            _Part(group, *(np.array(part, dtype=np.int64) for part in zip(*pairs, strict=True)))
            for group, pairs in wanted.items()
        ]
