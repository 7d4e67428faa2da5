"""The tables of a scene, each checked by itself, and the names that expressions call."""

from __future__ import annotations

import operator
from functools import cached_property
from typing import Any, ClassVar, get_args

from pydantic import (
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
)

from rodgen.errors import InputError
from rodgen.model.rod import Boundary
from rodgen.model.terms import MOVING_BASE, boundary_of
from rodgen.scene.air_table import Airflow, AirTable
from rodgen.scene.base_table import BaseTable
from rodgen.scene.contact_tables import ContactTables, JointStopTable, StopTable, WallTable
from rodgen.scene.expression_text import Numbers
from rodgen.scene.integration import EventTable, IntegrationTable
from rodgen.scene.load_tables import Loads
from rodgen.scene.lookup_table import MOST_ROWS, LookupTable, parse_table
from rodgen.scene.number_text import Expressed
from rodgen.scene.plain_tables import to_plain
from rodgen.scene.rod_mesh import RodMesh
from rodgen.scene.tables import (
    BodyTable,
    Finite,
    FoundationTable,
    InitialTable,
    RodTable,
    StateTable,
    SupportTable,
    Table,
    check_count,
    validate_tables,
)
from rodgen.scene.units import to_si
from rodgen.scene.validation import to_input_error


class SceneFields(Table):
    """All tables of a scene, each by itself."""

    # `parameters` are those of the module: the table's own name is that of a file.
    model_config: ClassVar[ConfigDict] = ConfigDict(serialize_by_alias=True, validate_by_name=True)

    name: str = Field(description="a plain identifier; names the folder of the results")
    numbers: dict[str, Expressed[Finite]] = Field(
        {},
        alias="parameters",
        exclude_if=operator.not_,
        description="numbers that expressions call by these names, each a plain identifier",
    )
    tables: dict[str, LookupTable] = Field(
        {},
        exclude_if=operator.not_,
        description="numbers that `interp(x, 'NAME')` reads: lists `knots`, which ascend, and "
        "`values`; 200000 rows in all",
    )
    rod: RodTable
    bodies: list[BodyTable] = []
    supports: list[SupportTable] = []
    foundation: FoundationTable | None = None
    stops: list[StopTable] = []
    joint_stops: list[JointStopTable] = []
    walls: list[WallTable] = []
    base: BaseTable | None = None
    air: AirTable | None = None
    loads: Loads = Loads()
    states: dict[str, StateTable] = Field({}, exclude_if=operator.not_)
    initial: InitialTable = InitialTable()
    events: list[EventTable] = []
    integrate: IntegrationTable = IntegrationTable()

    def __init__(self, /, **tables: Any) -> None:
        """Check tables, each a keyword; arrays, tuples and NumPy's numbers are taken too."""
        tables = to_si(to_plain(tables), type(self))
        try:
            # As pydantic does, with a context: it gets the numbers that expressions may name.
            self.__pydantic_validator__.validate_python(tables, self_instance=self, context={})
        except ValidationError as error:
            raise to_input_error(error, type(self)) from None

    @field_validator("numbers")
    @classmethod
    def _add_to_context(cls, numbers: dict[str, float], info: ValidationInfo) -> dict[str, float]:
        """Add the numbers to the context: expressions in the tables that follow may name them."""
        assert info.context is not None
        info.context.update(numbers)
        return numbers

    @field_validator("events", "bodies", "supports", "stops", "joint_stops", "walls", mode="before")
    @classmethod
    def _validate_array(cls, tables: Any, info: ValidationInfo) -> list[Any]:
        """Validate the tables of an array one by one, so that errors name the place."""
        key = str(info.field_name)
        (kind,) = get_args(cls.model_fields[key].annotation)
        return validate_tables(key, tables, kind, info.context)

    @field_validator("states", mode="before")
    @classmethod
    def _check_state_count(cls, tables: Any) -> Any:
        """Check the number of states first, as each of them takes some time."""
        if isinstance(tables, dict):
            check_count("states", tables)
        return tables

    @field_validator("tables", mode="before")
    @classmethod
    def _parse_tables(cls, tables: Any) -> Any:
        """Parse tables one by one, so that errors name the table."""
        if not isinstance(tables, dict):
            return tables
        check_count("tables", tables)
        made = {name: parse_table(name, table) for name, table in tables.items()}
        if (rows := sum(map(len, made.values()))) > MOST_ROWS:
            raise InputError("tables", rows, f"at most {MOST_ROWS} rows in all")
        return made

    @cached_property
    def contacts(self) -> ContactTables:
        """Stops and walls."""
        return ContactTables(self.stops, self.joint_stops, self.walls)

    @cached_property
    def airflow(self) -> Airflow:
        """The air at every point that it pushes."""
        return Airflow(self.air, self.loads.air_places, self._numbers, tuple(self.states))

    @property
    def boundary_condition(self) -> Boundary:
        """Boundary condition at the start of the rod, which a base moves or not."""
        return boundary_of(self.rod.boundary, () if self.base is None else (MOVING_BASE,))

    @property
    def n_fixed_links(self) -> int:
        """Number of links at the start of the rod that do not move."""
        return self.boundary_condition.first

    @property
    def mesh(self) -> RodMesh:
        """Where the joints of the rod are."""
        return self.rod.mesh(self._numbers)

    @cached_property
    def _numbers(self) -> Numbers:
        """Values of the names in expressions: numbers, and tables by names in quotes."""
        tables = ((repr(name), table) for name, table in self.tables.items())
        return (*self.numbers.items(), *tables)
