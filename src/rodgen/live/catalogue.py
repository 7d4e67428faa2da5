"""What can be shown of a live run by name, and its values at the samples of a chunk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.catalogue import Piece, loads_at_work
from rodgen.integrate.stepper import Array
from rodgen.live.samples import Chunk
from rodgen.model.parameter import typeset
from rodgen.model.quantities import ADDED, KINDS, LOADS, PERIODS, QUANTITIES, WORKS, numbers
from rodgen.model.terms import PARAMETERS, words_of
from rodgen.scene import Scene, SceneError

__all__ = ["KINDS", "PERIODS", "Catalogue", "Shown"]

MOST_PLANS = 256  # kept, one for every set of names that plots have asked for


class Shown(NamedTuple):
    """A single number that can be shown; kind is what it can be shown together with."""

    name: str
    label: str
    unit: str
    kind: str


class _Place(NamedTuple):
    """Where the values of a number are: in a quantity, (K, columns); how far along the rod, from 0
    at joint 0 to 1 at the tail."""

    quantity: str
    column: int
    along: float | None


class _Part(NamedTuple):
    """Columns of a quantity and where they go."""

    quantity: str
    columns: NDArray[np.int64]
    to: NDArray[np.int64]


class Catalogue:
    """What can be shown of a scene.

    quantities: all of them by name, in the order in which they are offered; kinds: names by kind,
    of what can be shown together; along: of kinds that go along the rod, where on it their
    quantities are, from 0 at joint 0 to 1 at the tail; works: loads without potential. All are
    fixed by the structure of the scene: values of parameters are taken from each chunk.
    """

    def __init__(self, scene: Scene, model: ModuleType):
        self._model, self._timed = model, scene.timed
        self.works = loads_at_work(scene, model)
        self.quantities: dict[str, Shown] = {}
        self.kinds: dict[str, list[str]] = {}
        self.along: dict[str, Array] = {}
        self._places: dict[str, _Place] = {}
        every = list(_every(scene, self.works))
        for kind in KINDS:
            some = [(shown, place) for shown, place in every if shown.kind == kind]
            if not some:
                continue
            self.kinds[kind] = [shown.name for shown, _ in some]
            self.quantities |= {shown.name: shown for shown, _ in some}
            self._places |= {shown.name: place for shown, place in some}
            along = [place.along for _, place in some if place.along is not None]
            if along:
                self.along[kind] = np.array(along)
        self._plans: dict[tuple[str, ...], list[_Part]] = {}
        self._last: tuple[Chunk, Piece] | None = None

    def columns(self, names: Sequence[str], chunk: Chunk) -> Array:
        """Values of quantities at the samples of a chunk, (K, names). Raises SceneError for a name
        that is not known. What was computed is kept for the next call with the same chunk."""
        if self._last is None or self._last[0] is not chunk:
            self._last = chunk, motion_of(self._model, chunk, self._timed)
        motion, out = self._last[1], np.empty((len(chunk), len(names)))
        with np.errstate(all="ignore"):  # a state may have stopped being finite
            for quantity, columns, to in self._plan(tuple(names)):
                out[:, to] = motion.values(quantity).reshape(len(chunk), -1)[:, columns]
        return out

    def quantity(self, name: object, field: str = "quantity") -> Shown:
        """A quantity by name. Raises SceneError that says what there is."""
        found = self.quantities.get(name) if isinstance(name, str) else None
        if found is None:
            raise SceneError(field, name, self._allowed(str(name), self.quantities))
        return found

    def expand(self, name: object, field: str = "quantity") -> list[str]:
        """The names that a name or a kind stands for. Raises SceneError that says what there is."""
        if isinstance(name, str) and name in self.kinds:
            return self.kinds[name]
        if isinstance(name, str) and name in self.quantities:
            return [name]
        raise SceneError(field, name, self._allowed(str(name), [*self.quantities, *self.kinds]))

    def _allowed(self, name: str, known: Sequence[str] | dict[str, Shown]) -> str:
        """The closest names, and all of them with families shortened."""
        close = get_close_matches(name[:64], known, 3)
        shown = []
        for names in self.kinds.values():
            family = len(names) > 4
            shown.append(f"{names[0]} to {names[-1]}" if family else ", ".join(names))
        every = f"one of {', '.join(shown)}"
        return f"{every} (closest: {', '.join(close)})" if close else every

    def _plan(self, names: tuple[str, ...]) -> list[_Part]:
        """Which columns of which quantities are wanted, found once for a set of names."""
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
            place = self._places[name]
            wanted.setdefault(place.quantity, []).append((place.column, at))
        return [
            _Part(quantity, *(np.array(part, dtype=np.int64) for part in zip(*pairs, strict=True)))
            for quantity, pairs in wanted.items()
        ]


def motion_of(model: ModuleType, chunk: Chunk, timed: Mapping[str, Any]) -> Piece:
    """The motion that the samples of a chunk are of; timed: loads that change with time."""
    works = dict(zip(chunk.works, chunk.work.T, strict=True))
    return Piece(model, chunk.p, chunk.y, chunk.t, works, chunk.given, chunk.start, timed)


def _every(scene: Scene, works: tuple[str, ...]) -> Iterator[tuple[Shown, _Place]]:
    """All numbers that a rod has, in the order of the rows of the vocabulary."""
    loads = [PARAMETERS[name] for name in scene.loads.parameters]
    terms = {
        WORKS: {term: words_of(term) for term in works},
        LOADS: {one.name: one.label for one in loads if one.timed and one.unit == "N"},
        ADDED: {name: name for name in scene.states},
        "": {"": ""},
    }
    for quantity in QUANTITIES:
        unit = typeset(quantity.unit)
        for term, words in terms.get(quantity.each, {}).items():
            for name, label, kind, at, along in numbers(quantity, scene.hold, scene.rod.links):
                column = sum(at) if len(at) < 2 else 2 * at[0] + at[1]  # of x and y by joint
                shown = Shown(name.format(term), label.format(words), unit, kind)
                yield shown, _Place(quantity.name.format(term), column, along)
