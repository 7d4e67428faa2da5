"""The tables of a scene file, each with its keys, their types, units and limits."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sized
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)
from pydantic_core import PydanticCustomError

from rodgen.errors import InputError, Missing
from rodgen.model.rod import BOUNDARIES, INERTIAS, Boundary
from rodgen.scene.expression_text import Numbers
from rodgen.scene.law import Law
from rodgen.scene.number_text import AS_TEXTS, Expressed, to_texts
from rodgen.scene.plain_tables import AGAIN, make_immutable
from rodgen.scene.rod_mesh import RodMesh
from rodgen.scene.term_texts import check_choice, check_links
from rodgen.scene.validation import to_input_error

MOST_TABLES = 1000  # of a kind: bodies, supports, events, states
LARGEST = 1e60  # of any value: products of several must still fit in a double


def _check_not_tiny(value: float) -> float:
    if 0 < value < SMALLEST:
        raise PydanticCustomError("too_small", f"at least {SMALLEST:g}")
    return value


def _check_side(value: float) -> float:
    if value not in (1, -1):
        raise PydanticCustomError("side", "1 or -1")
    return value


Finite = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
REST = "rest"  # initial angles without a load
SMALLEST = 1e-60  # of what others are divided by
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0, le=LARGEST)]
Size = Annotated[Positive, AfterValidator(_check_not_tiny)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0, le=LARGEST)]
Mass = Annotated[NotNegative, AfterValidator(_check_not_tiny)]  # which may be none
Share = Annotated[float, Field(ge=0, le=1)]
AtLeastOne = Annotated[float, Field(allow_inf_nan=False, ge=1, le=LARGEST)]
Side = Annotated[float, AfterValidator(_check_side)]
Pair = Annotated[list[Expressed[Finite]], Field(min_length=2, max_length=2), AS_TEXTS]
NotNegativePair = Annotated[
    list[Expressed[NotNegative]], Field(min_length=2, max_length=2), AS_TEXTS
]
# Of a list, which may be long, the first wrong value is enough.
Values = Annotated[list[Expressed[Finite]], Field(fail_fast=True), AS_TEXTS]
Sizes = Annotated[list[Expressed[Size]], Field(fail_fast=True), AS_TEXTS]
Masses = Annotated[list[Expressed[Mass]], Field(fail_fast=True), AS_TEXTS]
Factors = Annotated[list[Expressed[NotNegative]], Field(fail_fast=True), AS_TEXTS]


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)  # which is not public
HIDDEN = {name for name in dir(BaseModel) if not name.startswith("_")}


class TableType(ModelMetaclass):
    """Type of tables."""

    def __dir__(self) -> list[str]:
        """Names that editors complete, without pydantic's thirty, some of which warn."""
        return [name for name in super().__dir__() if name not in HIDDEN]


class Table(BaseModel, metaclass=TableType):
    """Base class of tables: unknown keys and values of another type are refused; never changed."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    def __setattr__(self, name: str, value: Any) -> None:
        table = type(self).__name__.removesuffix("Table")
        raise AttributeError(f"{table}.{name} cannot be set: scenes do not change. {AGAIN}")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(
            f"{type(self).__name__}.{name} cannot be deleted: scenes do not change. "
            'Make another: scene.replace({"loads.gravity": None}), by the dotted name of the key'
        )

    def __iter__(self) -> Generator[tuple[str, Any], None, None]:
        """Yield keys and values; pydantic's would add what was computed from them and kept."""
        for name in type(self).model_fields:
            yield name, getattr(self, name)

    def __hash__(self) -> int:
        # Of lists that were put in place of others, too.
        return hash(tuple(make_immutable(getattr(self, name)) for name in type(self).model_fields))

    def __dir__(self) -> list[str]:
        """Names that editors complete."""
        return [name for name in super().__dir__() if name not in HIDDEN]

    @model_validator(mode="after")
    def _freeze(self) -> Self:
        for name in type(self).model_fields:
            self.__dict__[name] = make_immutable(self.__dict__[name])
        return self


def list_words(vocabulary: Mapping[str, Any], describe: bool = False) -> str:
    """The words of a vocabulary as they stand in a file, each with its description if asked for."""
    found = (f'`"{name}"`' + f": {one.description}" * describe for name, one in vocabulary.items())
    return ("; " if describe else ", ").join(found)


def check_count(key: str, tables: Sized) -> None:
    """Raise InputError for more tables of a kind than a scene can have."""
    if len(tables) > MOST_TABLES:
        raise InputError(key, len(tables), f"at most {MOST_TABLES} tables")


def validate_tables(
    key: str, tables: Any, kind: type[Table], context: Mapping[str, float] | None
) -> list[Any]:
    """Validate the tables of an array, [[key]], one by one; context: numbers that expressions may
    name. Raises InputError with the place."""
    if not isinstance(tables, list):
        raise InputError(key, tables, f"an array of tables, [[{key}]]")
    check_count(key, tables)
    made = []
    for i, table in enumerate(tables):
        if not isinstance(table, dict | kind):
            raise InputError(f"{key}[{i}]", table, "a table")
        try:
            made.append(kind.model_validate(table, context=context))
        except ValidationError as error:
            found = to_input_error(error, kind)
            raise InputError(f"{key}[{i}].{found.field}", found.value, found.allowed) from None
    return made


Station = Annotated[list[NotNegative], Field(min_length=2, max_length=2)]
Stations = Annotated[list[Station], Field(min_length=1)]
MASS_KEYS = "mass", "mass_per_length", "stations"  # of which a rod has one


class RodTable(Table):
    """The rod, of rigid links that are joined by rotary springs."""

    links: int = Field(description="number of rigid links, 1 to 1000000 (2 for `cantilever`)")
    joints: Values | str | None = Field(
        default=None,
        description="s of the joints, from 0 to 1: n + 1 values, or an expression in `i`, the "
        "number of a joint, and `n`, that of the links; without it all links are equally long",
    )
    length: Expressed[Size] = Field(description="length of the whole rod [m]")
    bending_stiffness: NotNegative | Factors | str = Field(
        description="EI [N m^2]: a number, an expression in s, or n + 1 values, one for every joint"
    )
    mass: Expressed[Mass] | None = Field(
        default=None,
        description="mass of the whole rod without its bodies [kg], 0 for "
        "[none](#links-without-mass); this or `mass_per_length` is required",
    )
    mass_per_length: Mass | Masses | str | None = Field(
        default=None,
        description="mass per length [kg/m]: a number, an expression in s and t, or n values, one "
        "for every link",
    )
    stations: Stations | None = Field(
        default=None,
        description="in place of both, masses at stations, `[[x, mass], ...]`: from the start [m], "
        "ascending, and [kg]; each is spread evenly to the middles between them, the first and the "
        'last to the ends of the rod; `mass = "stations.csv"` reads them from a file',
    )
    spring: str | None = Field(
        default=None,
        description="moment of the spring in a joint [N m]: an expression in `d`, the angle by "
        'which it is bent, and its stiffness `k`; without it `"k*d"`',
    )
    rest_curvature: Finite | Values | str | None = Field(
        default=None,
        description="curvature where no load acts, to the left [1/m]: a number, an expression in "
        "s, or n + 1 values, one for every joint; without it straight",
    )
    diameter: Expressed[Positive] | None = Field(
        default=None,
        description="diameter of its body [m]: of the reference area of what the air pushes",
    )
    inertia: str = Field(
        default="uniform",
        description="how the mass of a link lies: " + list_words(INERTIAS, describe=True),
    )
    boundary: str = Field(
        default="free",
        description=f"how the start is held: {list_words(BOUNDARIES)}, [see below](#boundaries)",
    )
    clamp_angle: Expressed[Finite] | None = Field(
        default=None,
        description="angle at which the start is held [rad], of `cantilever` and `clamped` alone; "
        "without it 0",
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        check_choice("rod.boundary", self.boundary, BOUNDARIES)
        check_choice("rod.inertia", self.inertia, INERTIAS)
        check_links(self.links, self.boundary, "rod.links")
        if self.clamp_angle is not None and not BOUNDARIES[self.boundary].is_clamped:
            allowed = f"absent: boundary {self.boundary} has no clamp"
            raise InputError("rod.clamp_angle", self.clamp_angle, allowed)
        given = [key for key in MASS_KEYS if getattr(self, key) is not None]
        if not given:
            raise InputError("rod.mass", Missing(), "given, or rod.mass_per_length")
        if len(given) > 1:
            value = getattr(self, given[0])
            raise InputError(f"rod.{given[0]}", value, f"absent beside rod.{given[1]}")
        self._check_stations()
        return self

    def _check_stations(self) -> None:
        """Raise InputError for stations that do not ascend along the rod."""
        before = -1.0
        for at, (place, _) in enumerate(self.stations or ()):
            if not before < place <= self.length:
                least = f"above {before:g}, the station before it," if at else "at least 0"
                allowed = f"{least} and at most the length, {self.length:g} m"
                raise InputError(f"rod.stations[{at}]", place, allowed)
            before = place

    @property
    def boundary_condition(self) -> Boundary:
        """Boundary condition at its start."""
        return BOUNDARIES[self.boundary]

    def mesh(self, numbers: Numbers) -> RodMesh:
        """Where its joints are; numbers: values of the names in expressions. Raises InputError."""
        return RodMesh.parse(self.links, self.joints, numbers)


class BodyTable(Table):
    """A rigid body, fixed to the link on which its s lies."""

    name: str = Field(description="a plain identifier, each body its own")
    at: Expressed[Share] = Field(
        description="s of its place, from 0 (nose or root) to 1 (tail); at a joint the link that "
        "begins there, at the tail the last"
    )
    mass: Size | str = Field(description="mass [kg]: a number or an expression in t")
    inertia: Expressed[NotNegative] = Field(
        default=0.0, description="moment of inertia about its own centre [kg m^2]"
    )
    offset: Pair = Field(
        default=[0.0, 0.0],
        description="of its centre from that point of the link [m], along the link and across it "
        "(to its left)",
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        if not (self.name.isidentifier() and self.name.isascii() and len(self.name) <= 64):
            raise InputError("name", self.name, "a plain identifier of at most 64 ASCII characters")
        return self


def check_bodies(bodies: list[BodyTable], rod: RodTable, mesh: RodMesh) -> None:
    """Raise InputError unless every body has a name of its own and a place on the rod."""
    first: dict[str, int] = {}
    for i, body in enumerate(bodies):
        if first.setdefault(body.name, i) != i:
            allowed = f"unlike that of bodies[{first[body.name]}]"
            raise InputError(f"bodies[{i}].name", body.name, allowed)
        if rod.inertia != "lumped":
            continue
        why = "of inertia lumped, whose links have no mass but at their ends"
        if mesh.link_and_share(body.at)[1] not in (0, 1):
            where = f"a multiple of 1/{rod.links}" if mesh.is_even else "one of rod.joints"
            allowed = f"at a joint, {where}, on a rod {why}"
            raise InputError(f"bodies[{i}].at", body.at, allowed)
        for key, value in (("inertia", body.inertia), ("offset", body.offset)):
            if np.any(value):
                allowed = f"zero on a rod {why}: take inertia uniform"
                raise InputError(f"bodies[{i}].{key}", value, allowed)


class StateTable(Table):
    """A state of a controller, an actuator or a filter."""

    rate: Finite | str = Field(
        description="per second: a number or an expression in t, sensors and states"
    )
    initial: Expressed[Finite] = Field(default=0.0, description="its value at the start")


class SupportTable(Table):
    """Springs and dampers from a point of the rod to a fixed point."""

    at: Expressed[Share] = Field(description="s of the point, from 0 (nose or root) to 1 (tail)")
    to: Pair | None = Field(
        default=None,
        description="fixed point `[x, y]` [m] to which the springs pull; without it where the "
        "rod without load has that point",
    )
    stiffness: NotNegativePair = Field(
        default=[0.0, 0.0], description="in x and y, `[k_x, k_y]` [N/m], each at least 0"
    )
    damping: NotNegativePair = Field(
        default=[0.0, 0.0], description="in x and y, `[c_x, c_y]` [N s/m], each at least 0"
    )
    rotation: Expressed[NotNegative] = Field(
        default=0.0,
        description="spring against rotation of its link out of the direction of the straight rod "
        "[N m/rad]",
    )
    rotation_damping: Expressed[NotNegative] = Field(
        default=0.0, description="damper against rotation [N m s/rad]"
    )


class FoundationTable(Table):
    """Springs and dampers all along the rod, which act across an axis in the direction of the
    straight rod."""

    stiffness: NotNegative | str = Field(
        description="per length [N/m^2]: a number or an expression in s"
    )
    damping: Expressed[NotNegative] = Field(default=0.0, description="per length [N s/m^2]")
    through: Pair | None = Field(
        default=None,
        description="point `[x, y]` [m] through which the axis goes; without it the origin or, "
        "where `[base]` moves joint 0, its place at the start",
    )


class InitialTable(Table):
    """The state at the start of the span; s in an expression is that of the middle of a link."""

    position: Pair | None = Field(
        default=None,
        description="of joint 0 [m], `[x, y]`; only where it is free; without it `[0, 0]`",
    )
    velocity: Pair | None = Field(
        default=None,
        description="of joint 0 [m/s], `[x, y]`; only where it is free; without it `[0, 0]`",
    )
    phi: Finite | Values | str | None = Field(
        default=None,
        description="absolute angles [rad]: a number, a list over the moving links, an expression "
        f'in s, or `"{REST}"`, the shape that `rest_curvature` gives; without it straight, along '
        "the clamp",
    )
    angle: Expressed[Finite] | None = Field(
        default=None,
        description=f'angle of link 0 [rad] for `phi = "{REST}"` of a rod without a clamp; without '
        "it 0",
    )
    omega: Finite | Values | str | None = Field(
        default=None,
        description="their rates [rad/s]: a number, a list over the moving links, or an "
        "expression in s; without it 0",
    )

    @model_validator(mode="after")
    def _check_angle(self) -> Self:
        if self.angle is not None and self.phi != REST:
            allowed = f'absent: initial.phi is not "{REST}"'
            raise InputError("initial.angle", self.angle, allowed)
        return self

    @property
    def given_angles(self) -> tuple[str, Any]:
        """Key that says the angles at the start, of a shape at rest that of its first link, and its
        value."""
        return ("initial.angle", self.angle) if self.phi == REST else ("initial.phi", self.phi)

    def link_values(
        self, name: str, rod: RodTable, numbers: Numbers, default: float
    ) -> NDArray[np.float64]:
        """Initial angles or rates, by the key, of the moving links; numbers: values of the names in
        expressions; default: of all, where none are given. Raises InputError."""
        field, links = f"initial.{name}", np.arange(rod.boundary_condition.first, rod.links)
        value = getattr(self, name)
        if value is None:  # at rest and straight, along the clamp where there is one
            value = default
        if isinstance(value, list):
            if len(value) != len(links):
                allowed = f"a list of {len(links)} values, one for every moving link"
                raise InputError(field, to_texts(value), allowed)
            return np.array(value, dtype=float)
        values = Law(value, field, numbers).at(rod.mesh(numbers).middles[links])
        wrong = links[~np.isfinite(values)]
        if len(wrong):
            raise InputError(field, value, f"finite at every link (not at link {wrong[0]})")
        return values
