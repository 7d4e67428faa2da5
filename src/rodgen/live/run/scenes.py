"""Keys of a scene as they are shown; scenes in another form, and from files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from rodgen.errors import InputError
from rodgen.model.fixtures import (
    AT_IN_MODULE,
    BODY,
    STATE,
    STATE_AT_START,
    TANK,
)
from rodgen.model.parameter import ANY, JOINTS, LINKS, NOT_NEGATIVE, Parameter
from rodgen.model.rod import BOUNDARIES, CLAMP_ANGLE, MASS_PER_LENGTH, ROD, SPRING
from rodgen.model.term import Term
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.scene.keys import put_values
from rodgen.scene.literals import literals
from rodgen.scene.load_tables import FinFactor
from rodgen.scene.numbers import row_of
from rodgen.scene.plain import entry, read_text

LARGEST = 2**20  # bytes of a scene, unpacked
MOST_SCENES = 500  # of a folder
MOST_LISTED = 12  # of the numbers of a list or a text that can be moved one by one
PI = 3.141592653589793
SHAPES = ("phi", "omega")  # initial values of which each link may have its own


@dataclass(frozen=True)
class SceneField:
    """A key of a scene as it is shown: the row of its parameter, its dotted name, what it is in
    words; value: None where it is an expression of time or place, given as text; whole: all numbers
    of its list, where the scene leaves that out. A number in an expression has its place in the
    text behind the key of that."""

    of: Parameter
    key: str
    label: str
    value: float | None
    text: str = ""
    whole: tuple[float, ...] = ()

    def changes(self, value: float | str) -> dict[str, Any]:
        """Another value of the key, for `System.at`."""
        if not self.whole:
            return {self.key: value}
        outer, _, last = self.key.rpartition(".")
        return {outer: [value if k == int(last) else v for k, v in enumerate(self.whole)]}

    @property
    def unit(self) -> str:
        """The unit, as it is shown."""
        return self.of.shown_unit

    @property
    def decades(self) -> bool:
        """Whether a slider moves over powers of ten."""
        return self.of.decades and (self.value or 0.0) > 0

    def reach(self, scale: float) -> tuple[float, float]:
        """From where to where a slider goes, when the value is of such a size."""
        if self.of.angle:
            return -PI, PI
        if self.of.most is not None:
            return 0.0, self.of.most
        if self.decades:
            return scale / 100, scale * 100
        return (-3 * scale if self.of.signed else 0.0), 3 * scale


class Group(NamedTuple):
    """Numbers of a table of a scene: its dotted name, their rows, what is said after the label of
    each, and what holds of keys that the table leaves out."""

    key: str
    table: Any
    rows: Iterable[Parameter]
    suffix: str = ""
    left_out: Mapping[str, Any] = MappingProxyType({})


def groups_of(scene: Scene) -> Iterator[Group]:
    """All tables whose numbers a run takes up."""
    straight = {CLAMP_ANGLE.key: 0.0} if scene.hold.clamped else {}
    rod = (*ROD, MASS_PER_LENGTH, SPRING, CLAMP_ANGLE)
    yield Group("rod", scene.rod, rod, left_out=straight)
    for at, body in enumerate(scene.bodies):
        group = Group(f"bodies.{at}", body, BODY, f" of {body.name}")
        yield group._replace(rows=TANK) if isinstance(body.mass, str) else group
    for name in scene.loads.terms:
        term = TERMS[name]
        one = term.parameters[0]
        place = scene.place(one.name)[: -len(one.keys)]
        key, table = ".".join(place), entry(scene, *place)
        yield Group(key, table, term.parameters)
        if term.placed:
            yield Group(key, table, (AT_IN_MODULE,), f" of the {term.label}")
    if scene.foundation is not None:
        yield Group("foundation", scene.foundation, TERMS["foundation"].given)
    for at, support in enumerate(scene.supports):
        rows, to = TERMS["supports"].given, {"to": [*scene.anchors.place(support)]}
        yield Group(f"supports.{at}", support, rows, f" of support {at}", to)
    for name, state in scene.states.items():
        yield Group(f"states.{name}", state, STATE, f" of {name}")
    yield Group("parameters", scene.numbers, map(row_of, scene.numbers))


def fields_of(scene: Scene) -> Iterator[SceneField]:
    """All numbers that a run takes up, and expressions that stand for them; of a long list the
    first and the last."""
    for group in groups_of(scene):
        for one in group.rows:
            yield from _fields(group, one, scene)


def _fields(group: Group, one: Parameter, scene: Scene) -> Iterator[SceneField]:
    key = ".".join((group.key, *one.keys))
    label = f"{one.label} {one.symbol}".strip() + group.suffix
    value, whole = entry(group.table, one.key), ()
    if value is None:
        value = group.left_out.get(one.key)
        whole = tuple(value) if isinstance(value, list) else ()
    if one.part is not None:
        value = value[one.part]
    if isinstance(value, str):
        yield from _fields_of_text(SceneField(one, key, label, None, value), scene)
    elif isinstance(value, FinFactor):
        for part in FinFactor.model_fields:
            yield SceneField(one, f"{key}.{part}", f"{label}, {part}", float(getattr(value, part)))
    elif isinstance(value, list):
        last, each = len(value) - 1, LINKS if len(value) == scene.rod.links else JOINTS
        for number in range(len(value)) if last < MOST_LISTED else (0, last):  # the ends count most
            said = f"{label}, {each} {number}"
            yield SceneField(one, f"{key}.{number}", said, float(value[number]))
    elif value is not None:
        yield SceneField(one, key, label, float(value), whole=whole)


def _fields_of_text(whole: SceneField, scene: Scene) -> Iterator[SceneField]:
    """An expression after its amplitude, if it has one, and before the other numbers in it."""
    found = list(enumerate(literals(whole.text, scene.numbers)))[:MOST_LISTED]
    keys = {at: f"{whole.key}.{at}" for at, _ in found}
    leading = [at for at, one in found if one.leads]
    for at in leading:
        # Its sign is that of the text, another one another expression.
        size = replace(whole.of, rule=NOT_NEGATIVE)
        yield SceneField(size, keys[at], whole.label, found[at][1].value)
    yield replace(whole, label=f"{whole.label}, expression") if leading else whole
    for at, one in found:
        if at not in leading:
            row = row_of(str(at), ANY if one.signed else NOT_NEGATIVE)
            yield SceneField(row, keys[at], f"{whole.label}: {one.around}", one.value)


def scale_of(field: SceneField) -> float:
    """The size of a value, for its slider; where it is zero, that of a usual one."""
    return abs(field.value or 0.0) or abs(field.of.beginning or 0.0) or 1.0


@dataclass(frozen=True)
class Form:
    """What the module of a scene is specialised to, as a user chooses it; terms: of TERMS."""

    links: int
    boundary: str
    inertia: str
    terms: tuple[str, ...]


def form_of(scene: Scene) -> Form:
    """The form that a scene has; several loads of a kind are one term."""
    rod = scene.rod
    kinds = {TERMS[name].kind_name for name in (*scene.loads.terms, *scene.anchors.terms)}
    terms = tuple(name for name in TERMS if name in kinds)
    return Form(rod.links, rod.boundary, rod.inertia, terms)


# Values of the rod at the start, in words.
RIGID = {
    "initial.phi": "phi: a number, or an expression in s",
    "initial.omega": "omega: a number, or an expression in s",
    "initial.position": "position x, y of joint 0 [m]",
    "initial.velocity": "velocity x, y of joint 0 [m/s]",
}


def starts_of(scene: Scene) -> dict[str, str]:
    """Keys of all values at the start that a scene may give, and what they are in words."""
    key, label = STATE_AT_START.key, STATE_AT_START.label
    return RIGID | {f"states.{name}.{key}": f"{name} {label}" for name in scene.states}


def reshape(scene: Scene, form: Form, starts: Mapping[str, Any]) -> Scene:
    """The scene in another form, with other values at the start (None: left out). Raises
    InputError.

    Left out are values that the form has no place for: the clamp's angle, the position of a rod
    that is held, lists of as many values as the links were. Stiffness and mass of every joint or
    link are read off between those of the former ones.
    """
    table = scene.to_dict()
    rod = table["rod"]
    for key, count in (("bending_stiffness", form.links + 1), ("mass_per_length", form.links)):
        if isinstance(rod.get(key), list) and form.links > 0:
            rod[key] = _resampled(rod[key], count)
    rod |= {"links": form.links, "boundary": form.boundary, "inertia": form.inertia}
    other = (form.links, form.boundary) != (scene.rod.links, scene.rod.boundary)
    hold = BOUNDARIES.get(form.boundary)
    if hold is not None and not hold.clamped:
        rod.pop(CLAMP_ANGLE.key, None)
    for term in TERMS.values():
        _switch(table["loads"] if term.loads else table, term, term.name in form.terms, other)
    put_values(table, starts, Scene)
    initial = table["initial"]
    for key in SHAPES if other else ():
        if isinstance(initial.get(key), list):
            initial.pop(key)
    if hold is not None and not hold.translates:
        for key in ("position", "velocity"):
            initial.pop(key, None)
    table["events"] = [] if other else table.get("events", [])
    return Scene.from_dict(table)


def _resampled(values: list[float], count: int) -> list[float]:
    """So many values, evenly spread from the first to the last of these, linear between them."""
    wanted, known = (np.linspace(0.0, 1.0, size) for size in (count, len(values)))
    return [float(one) for one in np.interp(wanted, known, values)]


def _switch(tables: dict[str, Any], term: Term, on: bool, other: bool) -> None:
    """Have a term, or not; other: without lists of its numbers, as the joints are others."""
    if not on:
        tables.pop(term.table, None)
        return
    if not tables.get(term.table):
        tables[term.table] = [term.beginning] if term.array else term.beginning
    given = tables[term.table]
    for one in () if isinstance(given, list) else term.parameters:
        if other and one.several and isinstance(given.get(one.key), list):
            given.pop(one.key)


def from_toml_text(text: bytes) -> Scene:
    """A scene from the bytes of a file, checked as files are. Raises InputError."""
    if len(text) > LARGEST:
        raise InputError("scene", f"{len(text)} bytes", f"at most {LARGEST} bytes")
    return Scene.from_dict(read_text(text, "this file"))


class Folder:
    """The scenes of a folder: nothing outside of it, and nothing but its own files, is opened."""

    def __init__(self, path: Path):
        self._path = path.resolve()

    def names(self) -> list[str]:
        """File names of its scenes, without the ending."""
        try:
            found = sorted(p.stem for p in self._path.glob("*.toml") if self._inside(p))
        except OSError:
            return []
        return found[:MOST_SCENES]

    def scene(self, name: str) -> Scene:
        """One of them. Raises InputError."""
        if name not in self.names():
            raise InputError("scene", name, f"one of the folder: {', '.join(self.names())}")
        return Scene.from_toml(self._path / f"{name}.toml")

    def _inside(self, path: Path) -> bool:
        """Whether a file is in the folder itself, not a link that leads out of it."""
        return path.is_file() and path.resolve().parent == self._path
