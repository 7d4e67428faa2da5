"""What can be shown of a live run by name, and its values at the samples of a chunk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.catalogue import Piece, loads_at_work
from rodgen.live.own import OwnQuantity
from rodgen.live.samples import Chunk
from rodgen.loading.module import asked
from rodgen.model.parameter import typeset
from rodgen.model.quantities import (
    ADDED,
    KINDS,
    LOADS,
    OWN,
    PERIODS,
    POWERS,
    QUANTITIES,
    TURNS,
    WORKS,
    numbers,
)
from rodgen.model.terms import PARAMETERS, words_of
from rodgen.scene import Scene
from rodgen.system import System

__all__ = ["KINDS", "PERIODS", "TURNS", "Catalogue", "Shown"]

MOST_OWN = 100  # expressions that are known at a time
MOST_PLANS = 256  # kept, one for every set of names that plots have asked for
STATE = "state"  # kind of those that a scene adds, whose units are not known
POTENTIAL = ("spring_energy", "gravity_energy")


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
    """What can be shown of a system.

    quantities: all of them by name, in the order in which they are offered; kinds: names by kind,
    of what can be shown together; along: of kinds that go along the rod, where on it their
    quantities are, from 0 at joint 0 to 1 at the tail; works: loads without potential, and others
    that put in energy. Expressions of quantities are quantities too, once they have been asked for.
    All are fixed by the structure of the system, which model is of: values of parameters are taken
    from each chunk.
    """

    def __init__(self, system: System | Scene, model: ModuleType, others: tuple[str, ...] = ()):
        system = System.of(system)
        self.model, self._timed = model, system.timed
        powers = loads_at_work(model)
        self.works = (*powers, *others)
        self.quantities: dict[str, Shown] = {}
        self.kinds: dict[str, list[str]] = {}
        self.along: dict[str, Array] = {}
        self._places: dict[str, _Place] = {}
        every = list(_every(system.scene, self.works, powers))
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
        self._own: dict[str, OwnQuantity] = {}
        self._absent: set[str] = set()
        t, p, self._atol = system.settings.span[0], system.p, system.settings.atol
        some = np.sin(np.arange(1.0, 1.0 + len(model.STATE)))[None, :]  # bent and moving
        none = np.zeros((1, len(self.works)))
        self._some = Chunk(np.array([t]), some, none, self.works, p)
        self.settle(t, p)

    def settle(self, t: float, p: Array) -> bool:
        """Take up parameters: of potential energies that are zero however the rod moves, as those
        of springs in a chain, none stands for its kind. Whether others are than before."""
        with np.errstate(all="ignore"):
            _, *values = asked(self.model, "energy", t, self._some.y[0], p)
        before = self._absent
        self._absent = {name for name, value in zip(POTENTIAL, values, strict=True) if value == 0}
        return self._absent != before

    def columns(self, names: Sequence[str], chunk: Chunk) -> Array:
        """Values of quantities at the samples of a chunk, (K, names). Raises InputError for a name
        that is not known. What was computed is kept for the next call with the same chunk."""
        own = {at: self._own[name] for at, name in enumerate(names) if name in self._own}
        if own:
            return self._with_own(names, own, chunk)
        if self._last is None or self._last[0] is not chunk:
            self._last = chunk, motion_of(self.model, chunk, self._timed)
        motion, out = self._last[1], np.empty((len(chunk), len(names)))
        with np.errstate(all="ignore"):  # a state may have stopped being finite
            for quantity, columns, to in self._plan(tuple(names)):
                out[:, to] = motion.values(quantity).reshape(len(chunk), -1)[:, columns]
        return out

    def least(self, names: Sequence[str]) -> float:
        """What of these quantities is not more than an error of the method: as much of their values
        in some state of a size of one as the absolute tolerance is of that."""
        sizes = np.abs(self.columns(names, self._some))
        return self._atol * float(np.where(np.isfinite(sizes), sizes, 0.0).max(initial=0.0))

    def _with_own(self, names: Sequence[str], own: dict[int, OwnQuantity], chunk: Chunk) -> Array:
        out = np.empty((len(chunk), len(names)))
        rest = [at for at in range(len(names)) if at not in own]
        out[:, rest] = self.columns([names[at] for at in rest], chunk)
        for at, quantity in own.items():
            out[:, at] = quantity.values(self.model, self.columns, chunk)
        return out

    def _take_own(self, name: str, field: str) -> Shown:
        """An expression of quantities, which is a quantity from now on. Raises InputError."""
        if len(self._own) >= MOST_OWN:
            raise InputError(field, name, f"one of the {MOST_OWN} expressions that are known")
        known = self._places.keys()
        own = self._own[name] = OwnQuantity.of(name, known, field)
        told = {one.name: one.unit for one in self.quantities.values() if one.kind != STATE}
        found = self.quantities[name] = Shown(name, name, own.unit(told), OWN)
        return found

    def quantity(self, name: object, field: str = "quantity") -> Shown:
        """A quantity by name. Raises InputError that says what there is."""
        found = self.quantities.get(name) if isinstance(name, str) else None
        if found is None and isinstance(name, str) and not name.isidentifier():
            found = self._take_own(name, field)
        if found is None:
            raise InputError(field, name, self._allowed(str(name), self.quantities))
        return found

    def expand(self, name: object, field: str = "quantity") -> list[str]:
        """The names that a name or a kind stands for. Raises InputError that says what there is."""
        if isinstance(name, str) and name in self.kinds:
            return [one for one in self.kinds[name] if one not in self._absent]
        if isinstance(name, str) and (name in self.quantities or not name.isidentifier()):
            return [self.quantity(name, field).name]
        raise InputError(field, name, self._allowed(str(name), [*self.quantities, *self.kinds]))

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


def _every(
    scene: Scene, works: tuple[str, ...], powers: tuple[str, ...]
) -> Iterator[tuple[Shown, _Place]]:
    """All numbers that a rod has, in the order of the rows of the vocabulary."""
    loads = [PARAMETERS[name] for name in scene.loads.parameters]
    terms = {
        WORKS: {term: words_of(term) for term in works},
        POWERS: {term: words_of(term) for term in powers},
        LOADS: {one.name: one.label for one in loads if one.timed and one.unit == "N"},
        ADDED: {name: name for name in scene.states},
        "": {"": ""},
    }
    held = sorted({tie.link for tie in scene.anchors.ties})
    for quantity in QUANTITIES:
        if quantity.name == "gravity_energy" and "gravity" not in scene.loads.terms:
            continue
        unit = typeset(quantity.unit)
        for term, words in terms.get(quantity.each, {}).items():
            for name, label, kind, at, along in numbers(
                quantity, scene.hold, scene.rod.links, held
            ):
                column = sum(at) if len(at) < 2 else 2 * at[0] + at[1]  # of x and y by joint
                shown = Shown(name.format(term), label.format(words), unit, kind)
                yield shown, _Place(quantity.name.format(term), column, along)
