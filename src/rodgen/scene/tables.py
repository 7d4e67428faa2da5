"""The tables of a scene file, each with its keys, their types, units and limits."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic_core import PydanticCustomError

from rodgen.model.parameter import ANY, JOINTS, LINKS, NOT_NEGATIVE, POSITIVE, Parameter
from rodgen.model.quantities import number_in, watched
from rodgen.model.rod import BOUNDARIES, INERTIAS, Boundary
from rodgen.model.term import Term
from rodgen.model.terms import TERMS
from rodgen.scene import structure as st
from rodgen.scene.errors import Missing, SceneError, explain, meant
from rodgen.scene.law import Law
from rodgen.scene.places import place_of, point_of
from rodgen.scene.plain import entry

MOST_PLACED = 100  # loads of one kind

LARGEST = 1e60  # of any value: products of several must still fit in a double


def _not_vanishing(value: float) -> float:
    if value < SMALLEST:
        raise PydanticCustomError("too_small", f"at least {SMALLEST:g}")
    return value


Finite = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
SMALLEST = 1e-60  # of what others are divided by
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0, le=LARGEST)]
Size = Annotated[Positive, AfterValidator(_not_vanishing)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0, le=LARGEST)]
Share = Annotated[float, Field(ge=0, le=1)]
Pair = Annotated[list[Finite], Field(min_length=2, max_length=2)]
NotNegativePair = Annotated[list[NotNegative], Field(min_length=2, max_length=2)]
# Of a list, which may be long, the first wrong value is enough.
Values = Annotated[list[Finite], Field(fail_fast=True)]
Sizes = Annotated[list[Size], Field(fail_fast=True)]
Factors = Annotated[list[NotNegative], Field(fail_fast=True)]

DIRECTIONS, ACTIONS = ("rising", "falling", "either"), ("record", "stop")


class Table(BaseModel):
    """A table of a scene: no key that is not known, no value of another type; never changed."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(
            f"{type(self).__name__}.{name} cannot be set: scenes do not change. "
            f'Make another: scene.replace({{"rod.length": 3.0}}), by the dotted name of the key'
        )

    def __delattr__(self, name: str) -> None:
        raise AttributeError(
            f"{type(self).__name__}.{name} cannot be deleted: scenes do not change. "
            'Make another: scene.replace({"loads.gravity": None}), by the dotted name of the key'
        )

    def __hash__(self) -> int:
        return hash(tuple(_hashable(getattr(self, name)) for name in type(self).model_fields))


def _hashable(value: Any) -> Any:
    """What is equal for equal values, of lists and dictionaries as well."""
    if isinstance(value, dict):
        return frozenset((key, _hashable(one)) for key, one in value.items())
    return tuple(map(_hashable, value)) if isinstance(value, list) else value


def tables_in(key: str, tables: Any, kind: type[Table]) -> list[Any]:
    """Those of an array of tables, [[key]], each by itself, so that what is wrong is named by its
    place. Raises SceneError."""
    if not isinstance(tables, list):
        raise SceneError(key, tables, f"an array of tables, [[{key}]]")
    made = []
    for i, table in enumerate(tables):
        if not isinstance(table, dict | kind):
            raise SceneError(f"{key}[{i}]", table, "a table")
        try:
            made.append(kind.model_validate(table))
        except ValidationError as error:
            found = explain(error, dict(table), kind)
            raise SceneError(f"{key}[{i}].{found.field}", found.value, found.allowed) from None
    return made


class Rod(Table):
    """The rod: links, length [m], bending stiffness [N m^2] (a number, an expression in s or a
    value for every joint), moment of a spring [N m] (an expression in its stiffness k and in d, the
    angle by which it is bent), mass [kg], or mass per length [kg/m] (a number, an expression in s
    and t, or a value for every link); how the mass of a link lies and the start is held; the angle
    of its clamp [rad], for boundaries that have one."""

    links: int
    length: Size
    bending_stiffness: NotNegative | Factors | str
    mass: Size | None = None
    mass_per_length: Size | Sizes | str | None = None
    spring: str | None = None
    inertia: str = "uniform"
    boundary: str = "free"
    clamp_angle: Finite | None = None

    @model_validator(mode="after")
    def _structure(self) -> Self:
        st.choose("rod.boundary", self.boundary, BOUNDARIES)
        st.choose("rod.inertia", self.inertia, INERTIAS)
        st.check_links(self.links, self.boundary, "rod.links")
        if self.clamp_angle is not None and not BOUNDARIES[self.boundary].clamped:
            allowed = f"absent: boundary {self.boundary} has no clamp"
            raise SceneError("rod.clamp_angle", self.clamp_angle, allowed)
        if self.mass is None and self.mass_per_length is None:
            raise SceneError("rod.mass", Missing(), "given, or rod.mass_per_length")
        if self.mass is not None and self.mass_per_length is not None:
            raise SceneError("rod.mass", self.mass, "absent beside rod.mass_per_length")
        return self

    @property
    def hold(self) -> Boundary:
        """How its start is held."""
        return BOUNDARIES[self.boundary]


class Body(Table):
    """A rigid body that is fixed to the link on which s lies: its name, mass [kg] (a number or an
    expression in t), moment of inertia about its own centre [kg m^2], and where that is from the
    point s, along and across the link [m]."""

    name: str
    at: Share
    mass: Size | str
    inertia: NotNegative = 0.0
    offset: Pair = [0.0, 0.0]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if not (self.name.isidentifier() and self.name.isascii() and len(self.name) <= 64):
            raise SceneError("name", self.name, "a plain identifier of at most 64 ASCII characters")
        return self


def check_bodies(bodies: list[Body], rod: Rod) -> None:
    """Raise SceneError unless every body has a name of its own and a place that the rod has for
    it."""
    first: dict[str, int] = {}
    for i, body in enumerate(bodies):
        if first.setdefault(body.name, i) != i:
            allowed = f"unlike that of bodies[{first[body.name]}]"
            raise SceneError(f"bodies[{i}].name", body.name, allowed)
        if rod.inertia != "lumped":
            continue
        why = "of inertia lumped, whose links have no mass but at their ends"
        if point_of(body.at, rod.links)[1] not in (0, 1):
            allowed = f"at a joint, a multiple of 1/{rod.links}, on a rod {why}"
            raise SceneError(f"bodies[{i}].at", body.at, allowed)
        for key, value in (("inertia", body.inertia), ("offset", body.offset)):
            if np.any(value):
                allowed = f"zero on a rod {why}: take inertia uniform"
                raise SceneError(f"bodies[{i}].{key}", value, allowed)


class State(Table):
    """A state that the scene adds: its rate, a number or an expression in t, sensors and states,
    and its value at the start."""

    rate: Finite | str
    initial: Finite = 0.0


class FinFactor(Table):
    """A number for joint 0, one for each of the joints between, and one for the tail."""

    nose: NotNegative = 1.0
    body: NotNegative = 1.0
    tail: NotNegative = 1.0

    def values(self, links: int) -> list[float]:
        """Numbers of all joints."""
        return [self.nose, *[self.body] * (links - 1), self.tail]


RULES: dict[str, Any] = {ANY: Finite, NOT_NEGATIVE: NotNegative, POSITIVE: Positive}
VALUES: dict[str, Any] = {ANY: Values, NOT_NEGATIVE: Factors, POSITIVE: Sizes}


def _field(parameter: Parameter) -> tuple[Any, Any]:
    """Type and default of a key, for pydantic."""
    if parameter.each == JOINTS:
        return FinFactor | Factors, FinFactor()
    kind = RULES[parameter.rule]
    if parameter.each == LINKS:
        kind |= VALUES[parameter.rule] | str
    return kind | str if parameter.timed else kind, (
        ... if parameter.default is None else parameter.default
    )


def _load_table(term: Term) -> type[Table]:
    """The table of a term in [loads], a class of this module, so that scenes can be pickled."""
    name = term.table.title().replace("_", "")
    fields: dict[str, Any] = {one.key: _field(one) for one in term.parameters}
    for key, default in term.beginning.items():
        if isinstance(default, list):
            kind, _ = fields[key]
            fields[key] = Annotated[list[kind], Field(min_length=2, max_length=2)], default  # type: ignore[valid-type]
    if term.placed:
        fields["at"] = Share, Field(1.0, exclude_if=lambda at: at == 1)
    made = create_model(name, __base__=Table, __module__=__name__, __doc__=term.label, **fields)
    globals()[name] = made
    return made


def _tables_of(term: Term) -> Any:
    """What a scene may have of a term: a table or, of one at a place, several."""
    one = _load_table(term)
    several = Annotated[list[one], Field(max_length=MOST_PLACED)]  # type: ignore[valid-type]
    return one | several | None if term.placed else one | None


class Support(Table):
    """Springs [N/m] and dampers [N s/m] in x and y between the point s and a fixed one [m], and a
    spring [N m/rad] and a damper [N m s/rad] that keep its link from turning."""

    at: Share
    to: Pair | None = None
    stiffness: NotNegativePair = [0.0, 0.0]
    damping: NotNegativePair = [0.0, 0.0]
    rotation: NotNegative = 0.0
    rotation_damping: NotNegative = 0.0


class Foundation(Table):
    """An elastic foundation: stiffness [N/m^2], a number or an expression in s, and damping
    [N s/m^2] per length, across the straight rod."""

    stiffness: NotNegative | str
    damping: NotNegative = 0.0


LOADS = [term for term in TERMS.values() if term.loads]


class LoadTables(Table):
    """What is asked of the loads of a scene, whichever there are."""

    if TYPE_CHECKING:  # a table for every term

        def __getattr__(self, name: str) -> Any: ...

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the loads whose tables are there."""
        return tuple(self._tables)

    @property
    def following(self) -> tuple[str, ...]:
        """Those of them that turn with the rod."""
        return tuple(name for name in self.terms if TERMS[name].follows)

    @cached_property
    def _tables(self) -> dict[str, tuple[str, ...]]:
        """Keys of the table of every load, by name."""
        found: dict[str, tuple[str, ...]] = {}
        for term in LOADS:
            table = getattr(self, term.table)
            if isinstance(table, list):
                names = (f"{term.name}_{k + 1}" if k else term.name for k in range(len(table)))
                found |= {name: (term.table, str(k)) for k, name in enumerate(names)}
            elif table is not None:
                found[term.name] = (term.table,)
        return found

    @property
    def places(self) -> dict[str, tuple[str, ...]]:
        """Keys of every parameter of these loads in a scene, from the outermost table in."""
        return self._places

    @cached_property
    def _places(self) -> dict[str, tuple[str, ...]]:
        return {
            one.name: ("loads", *keys, *one.keys)
            for name, keys in self._tables.items()
            for one in TERMS[name].parameters
        }

    @property
    def parameters(self) -> tuple[str, ...]:
        """Parameters of these loads."""
        return tuple(self.places)

    def structure(self, links: int) -> tuple[str, ...]:
        """These loads as a structure of so many links has them."""
        found = []
        for name, keys in self._tables.items():
            place = place_of(getattr(entry(self, *keys), "at", 1.0), links)
            found.append(f"{TERMS[name].kind_name}@{place}" if place else TERMS[name].kind_name)
        return tuple(found)

    def value(self, name: str) -> Any:
        """Value of one of these parameters, as the scene has it."""
        return entry(self, *self.places[name][1:])


if TYPE_CHECKING:
    Loads = LoadTables
else:
    Loads = create_model(
        "Loads",
        __base__=LoadTables,
        __module__=__name__,
        __doc__="The loads that the scene has; those that are absent are not in its equations.",
        **{term.table: (_tables_of(term), None) for term in LOADS},
    )


class Initial(Table):
    """Initial state, by default straight (along the clamp) and at rest; phi and omega are a
    number, a list over the moving links, or an expression in s, the middle of the link from 0 at
    the nose to 1 at the tail."""

    position: Pair | None = None
    velocity: Pair | None = None
    phi: Finite | Values | str | None = None
    omega: Finite | Values | str | None = None

    def of_links(
        self, name: str, rod: Rod, numbers: tuple[tuple[str, float], ...]
    ) -> NDArray[np.float64]:
        """Angles or rates, by the key, of the moving links of a rod; numbers: those that
        expressions name. Raises SceneError."""
        n, field = rod.links, f"initial.{name}"
        links = np.arange(rod.hold.first, n)
        value = getattr(self, name)
        if value is None:  # at rest and straight, along the clamp where there is one
            value = (rod.clamp_angle or 0.0) if name == "phi" else 0.0
        if isinstance(value, list):
            if len(value) != len(links):
                allowed = f"a list of {len(links)} values, one for every moving link"
                raise SceneError(field, value, allowed)
            return np.array(value, dtype=float)
        values = Law(value, field, numbers).at((links + 0.5) / n)
        wrong = links[~np.isfinite(values)]
        if len(wrong):
            raise SceneError(field, value, f"finite at every link (not at link {wrong[0]})")
        return values


class Event(Table):
    """A state or a derived quantity that crosses a value: the run stops, or it is recorded."""

    quantity: str
    value: Finite
    direction: str = "either"
    action: str = "record"
    name: str = Field(default_factory=lambda it: f"{it.get('quantity')} = {it.get('value')!r}")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        st.choose("direction", self.direction, DIRECTIONS)
        st.choose("action", self.action, ACTIONS)
        return self


def check_events(events: list[Event], rod: Rod, states: Iterable[str]) -> None:
    """Raise SceneError unless this rod has all quantities and every event a name of its own;
    states: names of those that are added."""
    known = [*watched(BOUNDARIES[rod.boundary], rod.links), *((name, range(1)) for name in states)]
    first: dict[str, int] = {}
    for i, event in enumerate(events):
        if not any(number_in(event.quantity, name) in span for name, span in known):
            ends = [(name.format(span[0]), name.format(span[-1])) for name, span in known]
            shown = ", ".join(" to ".join(dict.fromkeys(pair)) for pair in ends)
            allowed = f"one of {shown}{meant(event.quantity, sum(ends, ()))}"
            raise SceneError(f"events[{i}].quantity", event.quantity, allowed)
        name, place = event.name, f"events[{i}].name"
        if not (0 < len(name) <= 64 and name.isprintable() and name.strip()):
            raise SceneError(place, name, "1 to 64 printable characters")
        if first.setdefault(name, i) != i:
            raise SceneError(place, name, f"unlike that of events[{first[name]}]")
