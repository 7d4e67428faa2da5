"""Fields of a scene for the page; scenes in another form, and from files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from rodgen.model.rod import (
    AT_IN_MODULE,
    BODY,
    BOUNDARIES,
    CHANGING_BODY,
    CLAMP_ANGLE,
    MASS_PER_LENGTH,
    REST_CURVATURE,
    ROD,
    SPRING,
    STATE,
    STATE_AT_START,
)
from rodgen.model.term import AIR, ANY, JOINTS, LINKS, NOT_NEGATIVE, Parameter, Term
from rodgen.model.terms import AIR_ROWS, TERMS
from rodgen.scene import Scene
from rodgen.scene.air_table import DENSITY
from rodgen.scene.keys import set_values
from rodgen.scene.literals import literals, number_parameter
from rodgen.scene.load_tables import FinFactor
from rodgen.scene.mesh import mesh_dependent_values, refined_tables
from rodgen.scene.plain_tables import get_at
from rodgen.scene.term_texts import check_choice, check_links

# Bytes of a scene that comes from a browser; a message of its connection has at most a million.
LARGEST = 2**19
MOST_LISTED = 12  # of the numbers of a list or a text that can be moved one by one
ROUNDING = 1e-12  # of the length
SHAPES = ("phi", "omega")  # initial values of which each link may have its own


@dataclass(frozen=True)
class SceneField:
    """A key of a scene as a field of the page: the row of its parameter, its dotted name, its
    label; value: None where it is an expression of time or place, given as text; whole: all numbers
    of its list, where the scene leaves that out. The key of a number in an expression is that of
    the expression, and the number's place in its text."""

    of: Parameter
    key: str
    label: str
    value: float | None
    text: str = ""
    whole: tuple[float, ...] = ()

    def changes(self, value: float | str) -> dict[str, Any]:
        """Changes that give the key another value, for `System.at`."""
        if not self.whole:
            return {self.key: value}
        outer, _, last = self.key.rpartition(".")
        return {outer: [value if k == int(last) else v for k, v in enumerate(self.whole)]}

    @property
    def unit(self) -> str:
        """Unit, as it is shown."""
        return self.of.display_unit

    @property
    def is_logarithmic(self) -> bool:
        """Whether the slider is logarithmic."""
        return self.of.decades and (self.value or 0.0) > 0

    def slider_range(self, scale: float) -> tuple[float, float]:
        """Range of the slider, lower and upper end, for a value of this size."""
        if self.of.is_angle:
            return -math.pi, math.pi
        if self.of.most is not None:
            return 0.0, self.of.most
        if self.is_logarithmic:
            return scale / 100, scale * 100
        return (-3 * scale if self.of.is_signed else 0.0), 3 * scale


class FieldGroup(NamedTuple):
    """Numbers of a table of a scene: its dotted name, the table, their rows, a suffix to the label
    of each, and the values of keys that the table leaves out."""

    key: str
    table: Any
    rows: Iterable[Parameter]
    suffix: str = ""
    left_out: Mapping[str, Any] = MappingProxyType({})


def groups_of(scene: Scene) -> Iterator[FieldGroup]:
    """Groups of all tables whose numbers a live run can change, loads first."""
    yield from _load_groups(scene)
    yield from _contact_groups(scene)
    straight = {CLAMP_ANGLE.key: 0.0} if scene.boundary_condition.is_clamped else {}
    rod = (*ROD, MASS_PER_LENGTH, SPRING, REST_CURVATURE, CLAMP_ANGLE)
    yield FieldGroup("rod", scene.rod, rod, left_out=straight)
    for at, body in enumerate(scene.bodies):
        group = FieldGroup(f"bodies.{at}", body, BODY, f" of {body.name}")
        yield group._replace(rows=CHANGING_BODY) if isinstance(body.mass, str) else group
    if scene.air is not None:
        given = (one for one in AIR_ROWS if getattr(scene.air, one.key) is not None)
        yield FieldGroup("air", scene.air, given)
    for name in ("base", "foundation"):
        if (table := getattr(scene, name)) is not None:
            yield FieldGroup(name, table, TERMS[name].given or TERMS[name].parameters)
    for at, support in enumerate(scene.supports):
        rows, to = TERMS["supports"].given, {"to": _fixed_point(scene, support)}
        yield FieldGroup(f"supports.{at}", support, rows, f" of support {at}", to)
    for name, state in scene.states.items():
        yield FieldGroup(f"states.{name}", state, STATE, f" of {name}")
    yield FieldGroup("parameters", scene.numbers, map(number_parameter, scene.numbers))


def _fixed_point(scene: Scene, table: Any) -> list[float]:
    """Fixed point of a support or a stop [m], without rounding."""
    least = ROUNDING * scene.rod.length  # of what is no zero
    return [x if abs(x) >= least else 0.0 for x in scene.anchors.fixed_point(table)]


def _load_groups(scene: Scene) -> Iterator[FieldGroup]:
    for name, keys in scene.loads.table_keys.items():
        term, key, table = TERMS[name], ".".join(("loads", *keys)), get_at(scene.loads, *keys)
        rows = scene.structure.load_rows[name].parameters
        yield FieldGroup(key, table, (one for one in rows if not one.table))
        if term.placed:
            yield FieldGroup(key, table, (AT_IN_MODULE,), f" of the {term.label}")


def _contact_groups(scene: Scene) -> Iterator[FieldGroup]:
    """Groups of the stops and walls."""
    for name, keys in scene.contacts.table_keys.items():
        table, term = get_at(scene, *keys), TERMS[name]
        left_out = {"to": _fixed_point(scene, table)} if hasattr(table, "to") else {}
        rows = scene.structure.load_rows[name].parameters
        yield FieldGroup(".".join(keys), table, rows, left_out=left_out)
        if term.placed:
            yield FieldGroup(".".join(keys), table, (AT_IN_MODULE,), f" of the {term.label}")


def fields_of(scene: Scene) -> Iterator[SceneField]:
    """Fields of all numbers that a live run can change, and of expressions that stand for them; of
    a long list the first and the last."""
    for group in groups_of(scene):
        for one in group.rows:
            yield from _fields(group, one, scene)


def _fields(group: FieldGroup, one: Parameter, scene: Scene) -> Iterator[SceneField]:
    key = ".".join((group.key, *one.key_path))
    label = f"{one.label} {one.symbol}".strip() + group.suffix
    value, whole = get_at(group.table, one.key), ()
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
    """Fields of an expression: its amplitude, if it has one, its text, its other numbers."""
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
            row = number_parameter(str(at), ANY if one.signed else NOT_NEGATIVE)
            yield SceneField(row, keys[at], f"{whole.label}: {one.around}", one.value)


def slider_scale(field: SceneField) -> float:
    """Size of a value, for its slider; a usual one where it is zero."""
    return abs(field.value or 0.0) or abs(field.of.initial_value or 0.0) or 1.0


@dataclass(frozen=True)
class StructureForm:
    """Choices of a user that fix the module of a scene; terms: of TERMS."""

    links: int
    boundary: str
    inertia: str
    terms: tuple[str, ...]


def structure_form(scene: Scene) -> StructureForm:
    """Form of a scene; several loads of a kind are one term."""
    rod = scene.rod
    kinds = {TERMS[name].base_name for name in scene.structure.loads}
    terms = tuple(name for name in TERMS if name in kinds)
    return StructureForm(rod.links, rod.boundary, rod.inertia, terms)


# Values of the rod at the start, in words.
RIGID = {
    "initial.phi": "phi: a number, or an expression in s",
    "initial.omega": "omega: a number, or an expression in s",
    "initial.position": "position x, y of joint 0 [m]",
    "initial.velocity": "velocity x, y of joint 0 [m/s]",
}


def initial_labels(scene: Scene) -> dict[str, str]:
    """Labels of all initial values that a scene may give, by their keys."""
    key, label = STATE_AT_START.key, STATE_AT_START.label
    return RIGID | {f"states.{name}.{key}": f"{name} {label}" for name in scene.states}


def reshape(scene: Scene, form: StructureForm, starts: Mapping[str, Any]) -> Scene:
    """Convert a scene to another form, with other initial values (None: left out). Raises
    InputError.

    Left out are values that the form has no place for: the clamp's angle, the position of a rod
    that is held, lists of as many values as the links were. Stiffness and mass of every joint or
    link are interpolated between the former ones; what else depends on the number of links is
    converted, as by `Scene.with_links` (see `conversions`).
    """
    check_choice("rod.boundary", form.boundary, BOUNDARIES)
    check_links(form.links, form.boundary, "rod.links")
    boundary, table = BOUNDARIES[form.boundary], refined_tables(scene, form.links)
    rod = table["rod"]
    joints = dict.fromkeys(("bending_stiffness", REST_CURVATURE.key), form.links + 1)
    for key, count in (joints | {"mass_per_length": form.links}).items():
        if isinstance(rod.get(key), list):
            places, known = (np.linspace(0.0, 1.0, size) for size in (count, len(rod[key])))
            rod[key] = np.interp(places, known, rod[key]).tolist()
    rod |= {"links": form.links, "boundary": form.boundary, "inertia": form.inertia}
    other = (form.links, form.boundary) != (scene.rod.links, scene.rod.boundary)
    if not boundary.is_clamped:
        rod.pop(CLAMP_ANGLE.key, None)
    for term in TERMS.values():
        tables = table["loads"] if term.is_load else table
        _switch_term(tables, term, term.name in form.terms, other)
        if term.kind == AIR and isinstance(given := tables.get(term.table), dict):
            given.setdefault("at", 1.0)
        for given in table.get(term.table, []) if term.array and term.placed else []:
            given.setdefault("at", 1.0 / form.links if term.at_joints else 1.0)
    if any(TERMS[name].kind == AIR for name in form.terms):
        table.setdefault("air", {DENSITY.key: DENSITY.first})
    set_values(table, starts, Scene)
    initial = table["initial"]
    for key in SHAPES if other else ():
        if isinstance(initial.get(key), list):
            initial.pop(key)
    for key in () if boundary.translates else ("position", "velocity"):
        initial.pop(key, None)
    table["events"] = [] if other else table.get("events", [])
    return Scene.from_dict(table)


def conversions(scene: Scene, links: int) -> str:
    """Say what of a scene is converted for another number of links; empty for nothing."""
    ratio = links / scene.rod.links
    changes = [
        f"{one.field} {one.value:.6g} to {one.after_refinement(ratio):.6g}"
        for one in mesh_dependent_values(scene)
    ]
    changes += ["rod.spring"] * (scene.rod.spring is not None)
    if ratio == 1.0 or not changes:
        return ""
    return f"Converted, so that {links} links are the same rod: {', '.join(changes)}."


def _switch_term(tables: dict[str, Any], term: Term, on: bool, other: bool) -> None:
    """Add a term, or remove it; other: without lists of its numbers, as the joints are others."""
    if not on:
        tables.pop(term.table, None)
        return
    if not tables.get(term.table):
        tables[term.table] = [term.initial_table] if term.array else term.initial_table
    given = tables[term.table]
    for one in () if isinstance(given, list) else term.parameters:
        if other and one.is_array and isinstance(given.get(one.key), list):
            given.pop(one.key)
