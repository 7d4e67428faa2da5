"""Which numbers of a module a key of a scene is, so that another value needs no other scene."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.model.terms import PARAMETERS
from rodgen.scene import Scene
from rodgen.scene.expression import Expression, open_expression
from rodgen.scene.keys import is_place, texts
from rodgen.scene.literals import with_literal
from rodgen.scene.plain import entry, is_number, put
from rodgen.scene.tables import Finite, Table

NUMBERS = "parameters"  # the table of numbers that have names
MOST_KNOWN = 10**5  # values of a key of which it is remembered whether its table takes them
NOWHERE: NDArray[np.intp] = np.array([], dtype=np.intp)
_FINITE = TypeAdapter(Finite)


@dataclass(frozen=True)
class ParameterSlot:
    """Where the number of a key goes, and by what it is checked.

    p, y: indices of the numbers in p and in y0 that are the number itself, or, of an anchor, that
    follow from it; table: of the scene, with the keys in it, None for a number of an expression;
    laws: the expressions that have it, and the name that it has in them; text: the expression in
    which it stands, and what the names of its numbers begin with; timed: whether laws of the
    scene in time follow from it; anchor: whether other numbers follow from it, see
    ParameterMap.put_anchors; least: a value that it has to exceed.
    """

    p: NDArray[np.intp]
    y: NDArray[np.intp]
    table: Table | None
    keys: tuple[str, ...]
    laws: tuple[tuple[Expression, str], ...] = ()
    text: tuple[Expression, str] | None = None
    timed: bool = False
    anchor: bool = False
    least: float = -np.inf
    known: dict[float, bool] = field(default_factory=dict, compare=False)

    def takes(self, value: Any) -> bool:
        """Whether its table takes a value; one that it does not take is refused by the scene."""
        if type(value) is not float and not is_number(value):
            return False
        found = self.known.get(value)
        if found is None:
            if len(self.known) > MOST_KNOWN:
                self.known.clear()
            found = self.known[value] = value > self.least and self._takes(value)
        return found

    def _takes(self, value: Any) -> bool:
        try:
            if self.table is None:
                _FINITE.validate_python(value, strict=True)
                same = self.text is None or self._keeps(*self.text, value)
                return same and all(law.takes({name: value}) for law, name in self.laws)
            given = self.table.model_dump(exclude_none=True)
            put(given, self.keys, value)
            type(self.table).model_validate(given)
        except (ValidationError, InputError, OverflowError):
            return False
        return True

    def _keeps(self, e: Expression, prefix: str, value: float) -> bool:
        """Whether an expression with the number in its place has the names that it has now: a whole
        exponent is no number of a module."""
        text = with_literal(e.text, int(self.keys[-1]), value, ".".join(self.keys))
        made = replace(e, text=text)
        return made.parametrised(prefix)[0] == e.parametrised(prefix)[0]


class ParameterMap:
    """The keys of a scene whose numbers are numbers of p or of the state at the start.

    A key that is more than that, such as the number of links or the length of a rod on supports,
    has no slot: its other values are other scenes.
    """

    def __init__(self, scene: Scene, source: Scene | None = None):
        """source: the scene whose loads at a time this one has, itself where they do not change."""
        self._scene, self._source = scene, source or scene
        self._slots: dict[str, ParameterSlot | None] = {}

    def slot(self, key: str) -> ParameterSlot | None:
        """The slot of a key, None of one that has none."""
        if key not in self._slots:
            self._slots[key] = self._found(tuple(key.split(".")))
        return self._slots[key]

    def put_anchors(self, values: Mapping[str, Any], p: Array) -> None:
        """Put numbers of supports and foundation into p, where some of their keys have other
        values: one joint may have several."""
        anchors = replace(self._scene.anchors, supports=(), foundation=None)
        for key, value in values.items():
            table, *keys = key.split(".")
            if table == "foundation":
                of = anchors.foundation or self._scene.foundation
                anchors = replace(anchors, foundation=_with_value(of, keys, value))
            elif table == "supports":
                several = [*(anchors.supports or self._scene.supports)]
                several[int(keys[0])] = _with_value(several[int(keys[0])], keys[1:], value)
                anchors = replace(anchors, supports=several)
        places = self._scene.structure.places
        for name, numbers in anchors.parameters.items():
            p[places[name]] = numbers

    # Finding slots ------------------------------------------------------------------------------

    def _found(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        find = self._finders.get(keys[0])
        if find is None or len(keys) < 2:
            return None
        if is_number(self._value(self._scene, keys)):
            # Of a law at a time, a number within what it is then is another one of the law.
            own = self._value(self._source, keys)
            return find(keys) if is_number(own) or isinstance(own, str) else None
        text = self._value(self._scene, keys[:-1]) if is_place(keys[-1]) else None
        return self._of_literal(keys, int(keys[-1])) if isinstance(text, str) else None

    @property
    def _finders(self) -> dict[str, Callable[[tuple[str, ...]], ParameterSlot | None]]:
        return {
            "loads": self._of_load,
            "rod": self._of_rod,
            NUMBERS: self._of_number,
            "initial": self._of_start,
            "states": self._of_state,
            "foundation": self._of_anchor,
            "supports": self._of_anchor,
        }

    @staticmethod
    def _value(scene: Scene, keys: tuple[str, ...]) -> Any:
        """Return the value at a key, None where nothing is."""
        table = scene.numbers if keys[0] == NUMBERS else scene
        try:
            return entry(table, *keys[1:] if keys[0] == NUMBERS else keys)
        except (AttributeError, KeyError, IndexError, ValueError, TypeError):
            return None

    def _slot(
        self, keys: tuple[str, ...], p: NDArray[np.intp] = NOWHERE, y: NDArray[np.intp] = NOWHERE
    ) -> ParameterSlot:
        table, inner = self._table(keys)
        return ParameterSlot(p, y, table, inner)

    def _table(self, keys: tuple[str, ...]) -> tuple[Table, tuple[str, ...]]:
        """The innermost table on the way to a value, and the keys in it."""
        found: Table = self._scene
        depth = 0
        for at in range(1, len(keys)):
            inner = entry(self._scene, *keys[:at])
            if isinstance(inner, Table):
                found, depth = inner, at
        return found, keys[depth:]

    @cached_property
    def _names(self) -> dict[tuple[str, ...], str]:
        """Parameters of loads by their keys."""
        return {keys: name for name, keys in self._scene.loads.places.items()}

    def _of_load(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        name, inner = self._names.get(keys), ""
        if name is None:
            name, inner = self._names.get(keys[:-1]), keys[-1]
        if name is None or self._follows_mass(name) or name in self._scene.expressions:
            return None
        place = self._scene.structure.places[name]
        every = np.arange(place.start, place.stop)
        if not inner:
            return self._slot(keys, every)
        if is_place(inner):
            return self._slot(keys, every[[int(inner)]])
        parts = {"nose": every[:1], "body": every[1:-1], "tail": every[-1:]}
        return self._slot(keys, parts[inner]) if inner in parts else None

    def _follows_mass(self, name: str) -> bool:
        """Whether a parameter was changed for masses that change with time."""
        return PARAMETERS[name].by_mass and bool(self._source.distribution.changing)

    def _of_rod(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        scene, structure = self._scene, self._scene.structure
        name = keys[-1]
        if len(keys) != 2 or name not in structure.places or PARAMETERS[name].each:
            return None
        weighed = {*structure.uneven} - {"stiffness"} or self._source.distribution.changing
        placed = structure.uneven or scene.supports or scene.foundation
        alone = {
            "bending_stiffness": True,
            "mass": not weighed,
            "length": not (weighed or placed or scene.rod.mass is None),
        }
        if not alone.get(name):
            return None
        slot = self._slot(keys, np.array([structure.positions[name]], dtype=np.intp))
        # With a law of springs, a rod without stiffness is refused.
        sprung = scene.rod.spring is not None and name != "mass"
        least = 0.0 if sprung and name == "bending_stiffness" else -np.inf
        return replace(slot, least=least, timed=sprung)

    def _of_number(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        """Find the slot of a number of [parameters] that laws of the module alone name.

        A table, what is looked at all along the rod or the span, and what a scene makes other
        numbers of may be another scene at another value.
        """
        number, structure = keys[-1], self._scene.structure
        if len(keys) != 2 or number not in structure.numbers:
            return None
        scene = self._scene
        every = (*scene.expressions.values(), *scene.rates.values())
        laws = tuple(e for e in every if number in e.names)
        along = {e.text for e in scene.along.values()}
        if any(e.tabulated or e.text in along for e in laws):
            return None
        known, naming = {e.text for e in laws}, re.compile(rf"\b{re.escape(number)}\b")
        if {text for text in self._texts if naming.search(text)} - known:
            return None
        at = np.array([structure.positions[number]], dtype=np.intp)
        named = tuple((law, number) for law in laws)
        return ParameterSlot(at, NOWHERE, None, keys, named, timed=True)

    def _of_literal(self, keys: tuple[str, ...], at: int) -> ParameterSlot | None:
        """Find the slot of a number in the text of a law without tables, by its place there."""
        scene, structure = self._scene, self._scene.structure
        texts = {scene.place(name): (name, e) for name, e in scene.timed.items()}
        texts |= {scene.place(name): (name, e) for name, e in scene.fed.items()}
        texts |= {("states", name, "rate"): (f"{name}_rate", e) for name, e in scene.rates.items()}
        prefix, e = texts.get(keys[:-1], ("", None))
        name = f"{prefix}_{at + 1}"
        if e is None or e.tabulated or name not in structure.positions:
            return None
        open_text, values = e.parametrised(prefix)
        law = open_expression(open_text, "t", tuple(scene.states)).with_values(values)
        place = np.array([structure.positions[name]], dtype=np.intp)
        laws = ((law, name),)
        return ParameterSlot(place, NOWHERE, None, keys, laws, (e, prefix), timed=True)

    @cached_property
    def _texts(self) -> set[str]:
        """All expressions of the scene, of which loads may be numbers at a time."""
        return set(texts(self._source.model_dump(exclude_none=True)))

    def _of_start(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        scene, base = self._scene, 2 * self._scene.hold.translates
        half = base + scene.rod.links - scene.held
        begin = {"position": 0, "phi": base, "velocity": half, "omega": half + base}.get(keys[1])
        if begin is None or (keys[1] == "position" and (scene.supports or scene.foundation)):
            return None
        if len(keys) == 3:
            return self._slot(keys, y=np.array([begin + int(keys[2])], dtype=np.intp))
        return self._slot(keys, y=np.arange(begin, begin + half - base))

    def _of_state(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        if len(keys) != 3 or keys[2] != "initial":
            return None
        names = [*self._scene.states]
        states = 2 * (2 * self._scene.hold.translates + self._scene.rod.links - self._scene.held)
        at = np.array([states + names.index(keys[1])], dtype=np.intp)
        table = self._scene.states[keys[1]]
        return ParameterSlot(NOWHERE, at, table, keys[2:])

    def _of_anchor(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        """Find the slot of a stiffness or damping that holds joints."""
        if keys[1 if keys[0] == "foundation" else 2] in ("at", "to"):
            return None
        places = self._scene.structure.places
        rows = self._scene.anchors.parameters
        every = [np.arange(places[name].start, places[name].stop) for name in rows]
        return replace(self._slot(keys, np.concatenate(every)), anchor=True)


def _with_value(of: Any, keys: Sequence[str], value: float) -> Any:
    """Return a table with another value of a key, or of a number in the list there."""
    key, *at = keys
    made: Any = value
    if at:
        made = [*getattr(of, key)]
        made[int(at[0])] = value
    return of.model_copy(update={key: made})
