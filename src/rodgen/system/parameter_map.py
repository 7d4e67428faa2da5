"""Map from keys of a scene to indices of p and y0, so that other values need no other scene."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.model.rod import MASS_WAYS
from rodgen.model.terms import BASE_ANGLE, CONTACTS, MOVING_BASE, PARAMETERS
from rodgen.scene import Scene
from rodgen.scene.expression import Expression, open_expression
from rodgen.scene.keys import NUMBERS, expression_texts, is_index
from rodgen.scene.literals import replace_literal
from rodgen.scene.plain_tables import get_at, is_number, set_at
from rodgen.scene.tables import Finite, Table

MOST_KNOWN = 10**5  # values of a key of which it is remembered whether its table takes them
NOWHERE: NDArray[np.intp] = np.array([], dtype=np.intp)
_FINITE = TypeAdapter(Finite)


@dataclass(frozen=True)
class ParameterSlot:
    """Indices of the number of a key in p and y0, and how its values are checked.

    p, y: indices of the numbers in p and in y0 that are the number itself, or, of an anchor, that
    follow from it; table: of the scene, with the keys in it, None for a number of an expression;
    laws: the expressions that have it, and the name that it has in them; text: the expression in
    which it stands, and what the names of its numbers begin with; timed: whether laws of the
    scene in time follow from it; anchor: whether other numbers follow from it, see
    ParameterMap.set_anchors; least: a value that it has to exceed.
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

    def accepts(self, value: Any) -> bool:
        """Whether its table accepts a value, and the module stays the same."""
        if type(value) is not float and not is_number(value):
            return False
        found = self.known.get(value)
        if found is None:
            if len(self.known) > MOST_KNOWN:
                self.known.clear()
            found = self.known[value] = value > self.least and self._is_valid(value)
        return found

    def _is_valid(self, value: Any) -> bool:
        try:
            if self.table is None:
                _FINITE.validate_python(value, strict=True)
                same = self.text is None or self._keeps_parameters(*self.text, value)
                return same and all(law.accepts({name: value}) for law, name in self.laws)
            given = self.table.model_dump(exclude_none=True)
            set_at(given, self.keys, value)
            type(self.table).model_validate(given)
        except (ValidationError, InputError, OverflowError):
            return False
        return True

    def _keeps_parameters(self, e: Expression, prefix: str, value: float) -> bool:
        """Whether an expression with a new number keeps its parametrised text: a whole exponent is
        no number of a module."""
        text = replace_literal(e.text, int(self.keys[-1]), value, ".".join(self.keys))
        made = replace(e, text=text)
        return made.with_parameters(prefix)[0] == e.with_parameters(prefix)[0]


class ParameterMap:
    """Map from keys of a scene to numbers of p or of the state at the start.

    A key that is more than that, such as the number of links or the length of a rod on supports,
    has no slot: its other values are other scenes.
    """

    def __init__(self, scene: Scene, source: Scene | None = None):
        """source: the scene that was frozen at a time to give this one; this one itself if none."""
        self._scene, self._source = scene, source or scene
        self._slots: dict[str, ParameterSlot | None] = {}

    def slot(self, key: str) -> ParameterSlot | None:
        """The slot of a key, None of one that has none."""
        if key not in self._slots:
            self._slots[key] = self._find_slot(tuple(key.split(".")))
        return self._slots[key]

    def set_anchors(self, values: Mapping[str, Any], p: Array) -> None:
        """Set the numbers of supports and foundation in p for other values of some of their keys:
        one joint may have several supports."""
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
        places = self._scene.structure.slices
        for name, numbers in anchors.parameters.items():
            p[places[name]] = numbers

    # Finding slots ------------------------------------------------------------------------------

    def _find_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        find = self._finders.get(keys[0])
        if find is None or len(keys) < 2:
            return None
        if is_number(self._value_at(self._scene, keys)):
            # Of a law at a time, a number within what it is then is another one of the law.
            own = self._value_at(self._source, keys)
            return find(keys) if is_number(own) or isinstance(own, str) else None
        text = self._value_at(self._scene, keys[:-1]) if is_index(keys[-1]) else None
        return self._literal_slot(keys, int(keys[-1])) if isinstance(text, str) else None

    @property
    def _finders(self) -> dict[str, Callable[[tuple[str, ...]], ParameterSlot | None]]:
        return {
            "loads": self._load_slot,
            "rod": self._rod_slot,
            NUMBERS: self._number_slot,
            "initial": self._initial_slot,
            "states": self._state_slot,
            "base": self._base_slot,
            "air": self._air_slot,
            "foundation": self._anchor_slot,
            "supports": self._anchor_slot,
            **{term.table: self._load_slot for term in CONTACTS},
        }

    @staticmethod
    def _value_at(scene: Scene, keys: tuple[str, ...]) -> Any:
        """Return the value at a key, None where nothing is."""
        table = scene.numbers if keys[0] == NUMBERS else scene
        try:
            return get_at(table, *keys[1:] if keys[0] == NUMBERS else keys)
        except (AttributeError, KeyError, IndexError, ValueError, TypeError):
            return None

    def _make_slot(
        self, keys: tuple[str, ...], p: NDArray[np.intp] = NOWHERE, y: NDArray[np.intp] = NOWHERE
    ) -> ParameterSlot:
        """Make a slot whose values the innermost table on the way to them checks."""
        outer = ((get_at(self._scene, *keys[:at]), keys[at:]) for at in range(len(keys) - 1, 0, -1))
        found = (pair for pair in outer if isinstance(pair[0], Table))
        return ParameterSlot(p, y, *next(found, (self._scene, keys)))

    @cached_property
    def _load_parameters(self) -> dict[tuple[str, ...], str]:
        """Names of the parameters of loads, by their keys."""
        scene = self._scene
        paths = (*scene.loads.key_paths.items(), *scene.contacts.key_paths.items())
        return {keys: name for name, keys in paths}

    def _load_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        name, inner = self._load_parameters.get(keys), ""
        if name is None:
            name, inner = self._load_parameters.get(keys[:-1]), keys[-1]
        if name is None or self._follows_mass(name) or name in self._scene.expressions:
            return None
        place = self._scene.structure.slices[name]
        every = np.arange(place.start, place.stop)
        if not inner:
            return self._make_slot(keys, every)
        if is_index(inner):
            return self._make_slot(keys, every[[int(inner)]])
        parts = {"nose": every[:1], "body": every[1:-1], "tail": every[-1:]}
        return self._make_slot(keys, parts[inner]) if inner in parts else None

    def _air_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        """Find the slot of a number of the air, which several loads may have as theirs."""
        scene, places = self._scene, self._scene.structure.slices
        names = [name for name, path in scene.airflow.key_paths.items() if path == keys]
        if not names or any(name in scene.expressions for name in names):
            return None
        return self._make_slot(
            keys, np.array([places[name].start for name in names], dtype=np.intp)
        )

    def _base_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        """Find the slot of a coordinate of the base that is a number."""
        name = f"{MOVING_BASE}_{keys[1]}"
        turns = name == BASE_ANGLE
        if turns or not self._moves_alone(()) or self._source.base != self._scene.base:
            return None
        at = np.array([self._scene.structure.indices[name]], dtype=np.intp)
        return self._make_slot(keys, at)

    def _moves_alone(self, laws: Iterable[Expression]) -> bool:
        """Whether a number of some laws of the base changes nothing but these: no state at the
        start, nothing that stays on the ground, and no jump of a place."""
        scene, turned = self._scene, f"{MOVING_BASE}.{PARAMETERS[BASE_ANGLE].key}"
        turns = any(e.field == turned for e in laws)
        at_start = scene.has_places_of_start or turns
        return not at_start and not any(e.jumps() for e in laws)

    def _follows_mass(self, name: str) -> bool:
        """Whether a parameter was changed for masses that change with time."""
        along = self._source.distribution
        has_own = along.total_link_mass and not along.changing_masses
        return PARAMETERS[name].by_mass and not has_own

    def _rod_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        scene, structure = self._scene, self._scene.structure
        name = keys[-1]
        if len(keys) != 2 or name not in structure.slices or PARAMETERS[name].each:
            return None
        masses = MASS_WAYS & {*structure.nonuniform}
        weighed = masses or self._source.distribution.changing_masses
        placed = structure.nonuniform or scene.has_places_of_start
        alone = {
            "bending_stiffness": True,
            "mass": not weighed,
            "length": not (weighed or placed or scene.rod.mass is None),
        }
        if not alone.get(name):
            return None
        slot = self._make_slot(keys, np.array([structure.indices[name]], dtype=np.intp))
        # With a law of springs, a rod without stiffness is refused.
        sprung = scene.rod.spring is not None and name != "mass"
        least = 0.0 if sprung and name == "bending_stiffness" else -np.inf
        least = 0.0 if name == "mass" else least  # without mass it is another rod
        return replace(slot, least=least, timed=sprung)

    def _number_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        """Find the slot of a number of [parameters] that laws of the module alone name.

        One in a table, in an expression that is checked all along the rod or the span, or from
        which the scene computes other numbers has none: another value may be another scene.
        """
        number, structure = keys[-1], self._scene.structure
        if len(keys) != 2 or number not in structure.numbers:
            return None
        scene = self._scene
        every = (*scene.expressions.values(), *scene.state_rates.values())
        laws = tuple(e for e in every if number in e.names)
        along = {e.text for e in scene.loads_along_rod.values()}
        if any(e.has_table or e.text in along for e in laws):
            return None
        moved = [e for name, e in scene.expressions.items() if name in structure.base_parameters]
        of_base = [e for e in laws if e in moved]
        if of_base and not self._moves_alone(of_base):
            return None
        # The air is given in another text than its laws at the places of loads have.
        given = {scene.given_value(name) for name, e in scene.expressions.items() if e in laws}
        known = {e.text for e in laws} | {text for text in given if isinstance(text, str)}
        naming = re.compile(rf"\b{re.escape(number)}\b")
        if {text for text in self._expression_texts if naming.search(text)} - known:
            return None
        at = np.array([structure.indices[number]], dtype=np.intp)
        named = tuple((law, number) for law in laws)
        return ParameterSlot(at, NOWHERE, None, keys, named, timed=True)

    def _literal_slot(self, keys: tuple[str, ...], at: int) -> ParameterSlot | None:
        """Find the slot of a number in the text of a law without tables, by its place there."""
        scene, structure = self._scene, self._scene.structure
        laws = scene.time_dependent_loads | scene.feedback_loads
        texts = {scene.key_path(name): (PARAMETERS[name].prefix, e) for name, e in laws.items()}
        texts |= {
            ("states", name, "rate"): (f"{name}_rate", e) for name, e in scene.state_rates.items()
        }
        if keys[0] == "air" and scene.air is not None and scene.air.is_standard:
            return None  # its law has more numbers than its text
        prefix, e = texts.get(keys[:-1], ("", None))
        name = f"{prefix}_{at + 1}"
        if e is None or e.has_table or name not in structure.indices:
            return None
        if keys[0] == MOVING_BASE and not self._moves_alone((e,)):
            return None
        open_text, values = e.with_parameters(prefix)
        law = open_expression(open_text, "t", tuple(scene.states)).with_values(values)
        place = np.array([structure.indices[name]], dtype=np.intp)
        known = ((law, name),)
        return ParameterSlot(place, NOWHERE, None, keys, known, (e, prefix), timed=True)

    @cached_property
    def _expression_texts(self) -> set[str]:
        """All expressions of the scene, those of loads that are frozen at a time among them."""
        return set(expression_texts(self._source.model_dump(exclude_none=True)))

    def _initial_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        scene, angles = self._scene, self._scene.structure.angle_slice
        base, half = angles.start, angles.stop
        begin = {"position": 0, "phi": base, "velocity": half, "omega": half + base}.get(keys[1])
        if begin is None or (keys[1] == "position" and scene.has_places_of_start):
            return None
        if len(keys) == 3:
            return self._make_slot(keys, y=np.array([begin + int(keys[2])], dtype=np.intp))
        return self._make_slot(keys, y=np.arange(begin, begin + half - base))

    def _state_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        if len(keys) != 3 or keys[2] != "initial":
            return None
        first = 2 * self._scene.structure.angle_slice.stop
        at = np.array([first + [*self._scene.states].index(keys[1])], dtype=np.intp)
        table = self._scene.states[keys[1]]
        return ParameterSlot(NOWHERE, at, table, keys[2:])

    def _anchor_slot(self, keys: tuple[str, ...]) -> ParameterSlot | None:
        """Find the slot of a stiffness or damping that holds joints."""
        if keys[1 if keys[0] == "foundation" else 2] in ("at", "to", "through"):
            return None
        places = self._scene.structure.slices
        rows = self._scene.anchors.parameters
        every = [np.arange(places[name].start, places[name].stop) for name in rows]
        return replace(self._make_slot(keys, np.concatenate(every)), anchor=True)


def _with_value(of: Any, keys: Sequence[str], value: float) -> Any:
    """Return a table with another value of a key, or of a number in the list there."""
    key, *at = keys
    made: Any = value
    if at:
        made = [*getattr(of, key)]
        made[int(at[0])] = value
    return of.model_copy(update={key: made})
