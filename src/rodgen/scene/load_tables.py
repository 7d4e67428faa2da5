"""The tables of terms: a key for every parameter."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, create_model, model_validator

from rodgen.errors import InputError, Missing
from rodgen.model.term import (
    AIR,
    ANY,
    AT_LEAST_ONE,
    JOINTS,
    LINKS,
    NOT_NEGATIVE,
    POSITIVE,
    SIDE,
    Parameter,
    Term,
)
from rodgen.model.terms import TERMS
from rodgen.scene.fin_set import SETS, FinSet
from rodgen.scene.number_text import Expressed
from rodgen.scene.plain_tables import get_at
from rodgen.scene.rod_mesh import RodMesh
from rodgen.scene.tables import (
    AtLeastOne,
    Factors,
    Finite,
    NotNegative,
    Positive,
    Share,
    Side,
    Sizes,
    Table,
    Values,
)

MOST_PLACED = 100  # loads of one kind


class FinGeometry(Table):
    """A set of equal fins on a body: chords of root and tip, span beyond the body, and how far the
    leading edge of the tip lies behind that of the root [m]; their number; radius of the body."""

    root: Expressed[Positive] = Field(description="chord where they join the body [m]")
    tip: Expressed[NotNegative] = Field(description="chord at their tip [m]")
    span: Expressed[Positive] = Field(description="from the body to the tip [m]")
    sweep: Expressed[Finite] = Field(
        description="from the leading edge of the root to that of the tip, along the body [m]"
    )
    number: int = Field(description="of fins: 3, 4 or 6")
    body_radius: Expressed[Positive] = Field(description="of the body where they stand [m]")

    @model_validator(mode="after")
    def _check_number(self) -> Self:
        if self.number not in SETS:
            allowed = "one of " + ", ".join(map(str, SETS))
            raise InputError("loads.fins.geometry.number", self.number, allowed)
        return self

    @property
    def fin_set(self) -> FinSet:
        """What the air does to them."""
        return FinSet(self.root, self.tip, self.span, self.sweep, self.number, self.body_radius)


GEOMETRIES: dict[str, dict[str, Any]] = {
    "fins": {
        "geometry": (
            FinGeometry | None,
            Field(None, description="of the fins, in place of `normal_slope` and `area`"),
        )
    }
}


class FinFactor(Table):
    """A number for joint 0, one for each of the joints between, and one for the tail."""

    nose: Expressed[NotNegative] = 1.0
    body: Expressed[NotNegative] = 1.0
    tail: Expressed[NotNegative] = 1.0

    def values(self, links: int) -> list[float]:
        """Numbers of all joints."""
        return [self.nose, *[self.body] * (links - 1), self.tail]


RULES: dict[str, Any] = {ANY: Finite, NOT_NEGATIVE: NotNegative, POSITIVE: Positive}
RULES |= {AT_LEAST_ONE: AtLeastOne, SIDE: Side}
EXPRESSED: dict[str, Any] = {
    ANY: Expressed[Finite],
    NOT_NEGATIVE: Expressed[NotNegative],
    POSITIVE: Expressed[Positive],
    AT_LEAST_ONE: Expressed[AtLeastOne],
    SIDE: Side,
}
VALUES: dict[str, Any] = {ANY: Values, NOT_NEGATIVE: Factors, POSITIVE: Sizes}


def _make_field(parameter: Parameter) -> tuple[Any, Any]:
    """Type and default of a key, for pydantic."""
    if parameter.each == JOINTS:
        return FinFactor | Factors, FinFactor()
    kind = RULES[parameter.rule]
    default: Any = parameter.default
    if parameter.each == LINKS:
        kind |= VALUES[parameter.rule] | str
    elif parameter.timed:
        kind |= str
    else:
        kind = EXPRESSED[parameter.rule]
    if parameter.part is not None:
        # A type that is known when this runs, which annotations are not asked to tell.
        kind = Annotated[list[kind], Field(min_length=2, max_length=2)]  # type: ignore[valid-type]
        default = [parameter.default] * 2
    if parameter.optional or parameter.computed or (parameter.unless and default is None):
        return kind | None, None
    return kind, ... if default is None else default


class TermTable(Table):
    """Base class of the tables of terms. term: its row in the vocabulary."""

    term: ClassVar[Term]

    @property
    def own_rows(self) -> tuple[Parameter, ...]:
        """Rows of its own keys."""
        return tuple(one for one in self.term.parameters if not one.table)

    @model_validator(mode="after")
    def _leave_out(self) -> Self:
        """Leave out the keys in place of which another stands. Raises InputError for both."""
        for one in self.own_rows:
            value, where = getattr(self, one.key), f"loads.{self.term.table}." * self.term.is_load
            if one.unless and getattr(self, one.unless) is not None:
                if one.key in self.model_fields_set:
                    raise InputError(f"{where}{one.key}", value, f"absent beside {one.unless}")
                self.__dict__[one.key] = None
            elif one.unless and value is None:
                raise InputError(f"{where}{one.key}", Missing(), f"given, or {one.unless}")
            if one.beside and (value is None) != (getattr(self, one.beside) is None):
                allowed = f"absent without {one.beside}"
                if value is None:
                    value, allowed = Missing(), f"given beside {one.beside}"
                raise InputError(f"{where}{one.key}", value, allowed)
        _check_geometry(self)
        return self


def make_term_table(term: Term) -> type[Table]:
    """Make the class of a term's table, in this module so that scenes can be pickled."""
    name = term.table.title().replace("_", "")
    rows = [one for one in term.parameters if not one.table]
    fields: dict[str, Any] = {one.key: _make_field(one) for one in rows}
    fields |= GEOMETRIES.get(term.name, {})
    if term.placed and term.is_load and term.kind != AIR:
        fields["at"] = Expressed[Share], Field(1.0, exclude_if=lambda at: at == 1)
    elif term.placed:
        fields["at"] = Expressed[Share], ...
    made = create_model(name, __base__=TermTable, __module__=__name__, __doc__=term.label, **fields)
    made.term = term
    globals()[name] = made
    return made


def _table_type(term: Term) -> Any:
    """Type of a term's key in [loads]: a table or, for a load at a place, several."""
    one = make_term_table(term)
    # A type that is known when this runs, as above.
    several = Annotated[list[one], Field(max_length=MOST_PLACED)]  # type: ignore[valid-type]
    return one | several | None if term.placed else one | None


LOADS = [term for term in TERMS.values() if term.is_load]


class TermTables:
    """Tables of terms, and the parameters of the module that they give."""

    ROWS: ClassVar[Sequence[Term]]
    PATH: ClassVar[tuple[str, ...]]  # of keys, to these tables

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the terms whose tables are there."""
        return tuple(self.table_keys)

    @cached_property
    def table_keys(self) -> dict[str, tuple[str, ...]]:
        """Keys of the table of every term, by name."""
        found: dict[str, tuple[str, ...]] = {}
        for term in self.ROWS:
            table = getattr(self, term.table)
            if isinstance(table, list):
                names = (f"{term.name}_{k + 1}" if k else term.name for k in range(len(table)))
                found |= {name: (term.table, str(k)) for k, name in enumerate(names)}
            elif table is not None:
                found[term.name] = (term.table,)
        return found

    @cached_property
    def key_paths(self) -> dict[str, tuple[str, ...]]:
        """Keys of every parameter of these terms in a scene, from the outermost table in."""
        found = {}
        for name, keys in self.table_keys.items():
            table = get_at(self, *keys)
            for one in TERMS[name].parameters:
                if not one.table and (getattr(table, one.key) is not None or one.computed):
                    found[one.name] = (*self.PATH, *keys, *one.key_path)
        return found

    def place_of(self, name: str) -> float:
        """The s of a load, 1 of one without a place."""
        return float(getattr(get_at(self, *self.table_keys[name]), "at", 1.0))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters of these terms."""
        return tuple(self.key_paths)

    def terms_with_places(self, mesh: RodMesh, shared: Sequence[str] = ()) -> tuple[str, ...]:
        """Names of the terms with their positions on the links, and the optional keys that they
        have; shared: options of tables that several terms share."""
        found, given = [], self.key_paths
        for name in self.table_keys:
            term = TERMS[name]
            place = mesh.place_text(self.place_of(name))
            options = [
                one.option
                for one in term.parameters
                if one.optional and (one.option in shared if one.table else one.name in given)
            ]
            place = "+".join(dict.fromkeys([place, *options] if place else options))
            found.append(f"{term.base_name}@{place}" if place else term.base_name)
        return tuple(found)

    def value(self, name: str) -> Any:
        """Value of one of these parameters, as the scene has it; None of one that is computed."""
        keys = self.key_paths[name][len(self.PATH) :]
        return None if get_at(self, *keys[:-1]) is None else get_at(self, *keys)


def _check_geometry(table: Table) -> None:
    """Raise InputError for what stands beside a geometry that gives it."""
    if getattr(table, "geometry", None) is not None:
        for key in ("normal_slope", "area"):
            if (value := getattr(table, key)) is not None:
                raise InputError(f"loads.fins.{key}", value, "absent beside geometry")


class LoadTables(TermTables, Table):
    """Base class of [loads], with properties that hold for any set of loads."""

    ROWS: ClassVar[Sequence[Term]] = LOADS
    PATH: ClassVar[tuple[str, ...]] = ("loads",)

    if TYPE_CHECKING:  # a table for every term

        def __getattr__(self, name: str) -> Any: ...

    @property
    def air_places(self) -> dict[str, float]:
        """The s of what the air pushes, by the name of the load."""
        return {name: self.place_of(name) for name in self.terms if TERMS[name].kind == AIR}

    def computed_value(self, name: str, diameter: float | None) -> float:
        """Value of a parameter whose key a table does not have: of fins with a geometry from that,
        of an area that of a circle. diameter: of the rod [m]. Raises InputError."""
        *keys, key = self.key_paths[name][1:]
        geometry = getattr(get_at(self, *keys), "geometry", None)
        if geometry is not None:
            return float(getattr(geometry.fin_set, key))
        if key == "area" and diameter is not None:
            return float(np.pi / 4 * diameter**2)
        other = "rod.diameter" if key == "area" else "geometry"
        raise InputError(".".join(self.key_paths[name]), Missing(), f"given, or {other}")

    @property
    def follower_loads(self) -> tuple[str, ...]:
        """Names of the loads that turn with the rod."""
        return tuple(name for name in self.terms if TERMS[name].follows)


if TYPE_CHECKING:
    Loads = LoadTables
else:
    Loads = create_model(
        "Loads",
        __base__=LoadTables,
        __module__=__name__,
        __doc__="The loads that the scene has; those that are absent are not in its equations.",
        **{term.table: (_table_type(term), None) for term in LOADS},
    )
