"""Checked tables of a scene, and what follows from them: structure, parameters, start, laws."""

from __future__ import annotations

import operator
from functools import cached_property
from typing import Any, ClassVar, Self, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from rodgen.errors import InputError
from rodgen.model.rod import CLAMP_ANGLE, MASS_WAYS, ROD, Boundary
from rodgen.model.term import JOINTS, LINKS
from rodgen.model.terms import BASE_ANGLE, BASE_ROWS, MOVING_BASE, PARAMETERS, PLACES, boundary_of
from rodgen.scene import spring_law
from rodgen.scene import structure as st
from rodgen.scene.anchors import Anchors
from rodgen.scene.base_table import BaseTable
from rodgen.scene.distribution import Distribution
from rodgen.scene.expression import Expression, Numbers, parse_expression
from rodgen.scene.grammar import TableData
from rodgen.scene.integration import EventTable, IntegrationTable, check_events
from rodgen.scene.law import Law
from rodgen.scene.literals import NAME, check_names, check_states, mass_name
from rodgen.scene.load_tables import FinFactor, Loads
from rodgen.scene.lookup_table import MOST_ROWS, LookupTable, parse_table
from rodgen.scene.number_text import Expressed
from rodgen.scene.plain_tables import to_plain
from rodgen.scene.tables import (
    REST,
    BodyTable,
    Finite,
    FoundationTable,
    InitialTable,
    RodTable,
    StateTable,
    SupportTable,
    Table,
    check_bodies,
    check_count,
    validate_tables,
)
from rodgen.scene.time_laws import TimeLaws, check_motion
from rodgen.scene.validation import to_input_error


class SceneTables(Table):
    """All tables of a scene, checked together, and what follows from their values; see Scene."""

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
    base: BaseTable | None = None
    loads: Loads = Loads()
    states: dict[str, StateTable] = Field({}, exclude_if=operator.not_)
    initial: InitialTable = InitialTable()
    events: list[EventTable] = []
    integrate: IntegrationTable = IntegrationTable()

    def __init__(self, /, **tables: Any) -> None:
        """Check tables, each a keyword; arrays, tuples and NumPy's numbers are taken too."""
        tables = to_plain(tables)
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

    @field_validator("events", "bodies", "supports", mode="before")
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

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        if not NAME.fullmatch(self.name):
            raise InputError("name", self.name, "a plain identifier of at most 64 ASCII characters")
        rates = [spring_law.NAME, *(f"{name}_rate" for name in self.states)]
        masses = [mass_name(body.name) for body in self.bodies]
        check_names(self.numbers, "parameters", (*rates, mass_name(""), *masses))
        check_names(self.states, "states", rates)
        check_states(self.states, self.numbers)
        for name in self.states:
            self._state_rate(name)
        if self.base is not None:
            self.base.check_boundary(self.rod.boundary_condition, self.rod.boundary)
        for parameter in self.given_parameters:
            value, each = self.given_value(parameter), PARAMETERS[parameter].each
            count = self.rod.links + (each == JOINTS)
            if isinstance(value, list) and len(value) != count:
                allowed = f"a list of {count} values, one for every {each}"
                raise InputError(self.key_of(parameter), value, allowed)
            self._load_value(parameter)
        for name in ("position", "velocity"):
            value = getattr(self.initial, name)
            if value is not None and not self.boundary_condition.translates:
                allowed = f"absent: joint 0 of boundary {self.rod.boundary} is fixed"
                raise InputError(f"initial.{name}", value, allowed)
        if self.initial.angle is not None and self.boundary_condition.is_clamped:
            allowed = "absent: the clamp has one, rod.clamp_angle"
            raise InputError("initial.angle", self.initial.angle, allowed)
        if self.initial.phi == REST in self.numbers:
            allowed = f'another name: initial.phi = "{REST}" is the shape without load'
            raise InputError(f"parameters.{REST}", self.numbers[REST], allowed)
        self._initial_values("phi")
        self._initial_values("omega")
        check_events(self.events, self.rod, self.states)
        check_bodies(self.bodies, self.rod)
        self._check_span()
        self.anchors.check()
        if self.spring_law is not None and not np.any(self.distribution.joint_stiffness):
            raise InputError(spring_law.FIELD, self.rod.spring, "absent: no joint has a stiffness")
        return self

    def _check_span(self) -> None:
        """Raise InputError for loads, stiffness or masses that are impossible within the span."""
        for name in self._base_values:
            if (e := self.expression(name)) is not None:
                check_motion(e, *self.integrate.span)
        for parameter in self.loads.parameters:
            if PARAMETERS[parameter].each == LINKS:
                self._law(parameter).check_poles(self.integrate.span)
        self.link_values_at(self.integrate.span[0])
        self.distribution.check(self.integrate.span)

    def _initial_values(self, name: str) -> NDArray[np.float64]:
        """Initial values of the moving links."""
        if name == "phi" and self.initial.phi == REST:
            start = self.integrate.span[0]
            clamped = self.boundary_condition.is_clamped
            angle = self.clamp_angle_at(start) if clamped else self.anchors.angle
            shape: NDArray[np.float64] = angle + self.distribution.rest_shape
            return shape[self.n_fixed_links :]
        straight = self.clamp_angle_at(self.integrate.span[0]) if name == "phi" else 0.0
        return self.initial.link_values(name, self.rod, self._numbers, straight)

    def clamp_angle_at(self, t: float) -> float:
        """Angle of the clamp at a time [rad]; zero without one.

        t: the time [s].
        """
        return (self.rod.clamp_angle or 0.0) + self._base_at(BASE_ANGLE, t)

    @property
    def boundary_condition(self) -> Boundary:
        """Boundary condition at the start of the rod, which a base moves or not."""
        return boundary_of(self.rod.boundary, () if self.base is None else (MOVING_BASE,))

    @property
    def n_fixed_links(self) -> int:
        """Number of links at the start of the rod that do not move."""
        return self.boundary_condition.first

    @cached_property
    def _numbers(self) -> Numbers:
        """Values of the names in expressions: numbers, and tables by names in quotes."""
        tables = ((repr(name), table) for name, table in self.tables.items())
        return (*self.numbers.items(), *tables)

    @property
    def _base_values(self) -> dict[str, Any]:
        """Values of what moves the start of the rod, by parameter."""
        return {} if self.base is None else self.base.values

    @property
    def given_parameters(self) -> tuple[str, ...]:
        """Names of the parameters of its loads and of its base."""
        return (*self.loads.parameters, *self._base_values)

    def given_value(self, name: str) -> Any:
        """Value of one of these parameters, as the scene has it.

        name: of the parameter.
        """
        moved = self._base_values
        return moved[name] if name in moved else self.loads.value(name)

    def expression(self, name: str) -> Expression | None:
        """Expression of a parameter of a load or of the base that is given as text, in t, or in s
        where every link has its own; None for other parameters.

        name: of the parameter.
        """
        value = self.given_value(name)
        if not isinstance(value, str):
            return None
        if PARAMETERS[name].each == LINKS:
            return self._law(name).expression
        # What is moved is given: it follows no sensor and no state.
        states = None if name in self._base_values else tuple(self.states)
        return parse_expression(value, "t", self.key_of(name), self._numbers, states)

    def key_path(self, name: str) -> tuple[str, ...]:
        """Keys of tables, from the outermost in, that lead to a parameter of the module.

        name: of the parameter.
        """
        return self.loads.key_paths.get(name) or PLACES[name]

    def key_of(self, name: str) -> str:
        """Dotted name in the scene of a parameter of the module.

        name: of the parameter.
        """
        return ".".join(self.key_path(name))

    def _load_value(self, name: str) -> Any:
        """Value of a parameter of a load or of the base: a number, or those of all joints or links;
        None for one that changes with time."""
        value, text, links = self.given_value(name), self.expression(name), self.rod.links
        if isinstance(value, FinFactor):
            return value.values(links)
        if PARAMETERS[name].each == LINKS:
            law, start = self._law(name), self.integrate.span[0]
            return None if law.is_time_dependent else law.link_values(links, start)
        # A text without t is a number like any other.
        return value if text is None else float(text(0.0)) if text.is_constant else None

    def _law(self, name: str) -> Law:
        """Value along the rod of a parameter that every link has of its own."""
        return Law(self.loads.value(name), self.key_of(name), self._numbers, "st")

    def link_values_at(self, t: float) -> dict[str, list[float]]:
        """Values, in SI units, of the parameters that change with time and from link to link, by
        name, each a list over the links.

        t: the time [s].
        """
        laws = {name: self._law(name) for name in self.loads_along_rod}
        return {name: law.link_values(self.rod.links, t) for name, law in laws.items()}

    def _state_rate(self, name: str) -> Expression:
        """Expression of the rate of an added state."""
        rate, place = self.states[name].rate, f"states.{name}.rate"
        text = rate if isinstance(rate, str) else repr(float(rate))
        return parse_expression(text, "t", place, self._numbers, tuple(self.states))

    @cached_property
    def structure(self) -> st.Structure:
        """Structure to which its module is specialised: numbers in expressions are parameters."""
        rod = self.rod
        values = dict[str, Any]()

        def parametrise(e: Expression, prefix: str) -> str:
            named, found = e.with_parameters(prefix)
            values.update(found)
            return named

        texts = tuple((name, parametrise(force, name)) for name, force in self.expressions.items())
        rates = tuple(
            (name, parametrise(e, f"{name}_rate")) for name, e in self.state_rates.items()
        )
        terms = self.loads.terms_with_places(rod.links) + self.anchors.terms
        terms += () if self.base is None else (f"{MOVING_BASE}@{'+'.join(self.base.keys)}",)
        what = rod.links, rod.boundary, rod.inertia, terms
        sprung = parametrise(self.spring_law, spring_law.NAME) if self.spring_law else ""
        along = self.distribution
        masses = tuple(
            (name, link, parametrise(e, mass_name(name))) for name, link, e in along.changing_masses
        )
        tables = ((name, len(of)) for name, of in values.items() if isinstance(of, TableData))
        return st.Structure(*what, texts, along.nonuniform, rates, sprung, masses, tuple(tables))

    @property
    def spring_law(self) -> Expression | None:
        """The law of the springs, where that is not Hooke's, else None."""
        text = self.rod.spring
        law = None if text is None else spring_law.parse_spring_law(text, self._numbers)
        return None if law is None or spring_law.is_hooke(law.canonical) else law

    @property
    def has_no_tangent_stiffness(self) -> bool:
        """Whether the springs have no tangent stiffness in the straight rod."""
        return self.spring_law is not None and spring_law.has_no_tangent_stiffness(self.spring_law)

    @property
    def anchors(self) -> Anchors:
        """Supports and foundation of the rod."""
        start = self.initial.position or self._base_start
        turned = self.initial.angle or 0.0
        placed = any(one.name in self._base_values for one in BASE_ROWS[:2])
        held = self.rod, self.supports, self.foundation
        return Anchors(*held, start, self._numbers, turned, placed)

    @property
    def _base_start(self) -> tuple[float, float]:
        """Place of joint 0 at the start of the span, where it is held [m]."""
        x, y = (self._base_at(one.name, self.integrate.span[0]) for one in BASE_ROWS[:2])
        return x, y

    def _base_at(self, name: str, t: float) -> float:
        """Coordinate of the base at a time [s]; zero where it is not given."""
        if name not in self._base_values:
            return 0.0
        e = self.expression(name)
        return float(self.given_value(name) if e is None else e(t))

    @property
    def distribution(self) -> Distribution:
        """Stiffness and mass along the rod, at the start of the span."""
        return self.distribution_at(self.integrate.span[0])

    def distribution_at(self, t: float) -> Distribution:
        """Stiffness and mass along the rod at a time.

        t: the time [s].
        """
        return Distribution(self.rod, self.bodies, self._numbers, t)

    @property
    def mass(self) -> float:
        """Mass of the links and of all bodies at the start of the span [kg]."""
        return self.distribution.mass

    # Kept, as a run asks dozens of times; copies that are made here have other settings in
    # [integrate] alone.
    @cached_property
    def expressions(self) -> dict[str, Expression]:
        """Parameters that change with time or with the motion, by name."""
        found = {name: self.expression(name) for name in self.given_parameters}
        return {
            name: e
            for name, e in found.items()
            if e and (e.has_variable if PARAMETERS[name].each else not e.is_constant)
        }

    @property
    def loads_along_rod(self) -> dict[str, Expression]:
        """Parameters that change with time and may differ from link to link, by name."""
        return {name: e for name, e in self.expressions.items() if PARAMETERS[name].each}

    @property
    def time_dependent_loads(self) -> dict[str, Expression]:
        """Parameters that change with time alone, by name."""
        return {name: e for name, e in self._single_loads.items() if not e.signals}

    @property
    def feedback_loads(self) -> dict[str, Expression]:
        """Parameters that follow the motion, by name."""
        return {name: e for name, e in self._single_loads.items() if e.signals}

    @property
    def _single_loads(self) -> dict[str, Expression]:
        """Parameters of one number that change with time or with the motion, by name."""
        return {name: e for name, e in self.expressions.items() if not PARAMETERS[name].each}

    @property
    def state_rates(self) -> dict[str, Expression]:
        """Rates of the added states, by name."""
        return {name: self._state_rate(name) for name in self.states}

    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the parameters of its module, by name, in SI units; of a table TableData, an
        array of its knots and then its values."""
        rod, along = self.rod, self.distribution
        values: dict[str, Any] = {
            one.name: getattr(rod, one.key) or 0.0 for one in (*ROD, CLAMP_ANGLE)
        }
        values |= {"bending_stiffness": along.stiffness, "mass": along.total_link_mass}
        values |= along.joint_parameters
        if not MASS_WAYS.isdisjoint(along.nonuniform):
            values |= along.link_parameters()
        values |= along.changing_mass_parameters
        values |= {name: self._load_value(name) for name in self.given_parameters}
        for name, text in self.expressions.items():
            values |= text.with_parameters(name)[1]
        values |= self.anchors.parameters
        if self.spring_law is not None:
            values |= self.spring_law.with_parameters(spring_law.NAME)[1]
        for name, text in self.state_rates.items():
            values |= text.with_parameters(f"{name}_rate")[1]
        return {name: values[name] for name in self.structure.parameters}

    def initial_state(self) -> NDArray[np.float64]:
        """The state y at the start of the span, (states,), in SI units and the order of the
        module's STATE."""
        position, velocity = self.initial.position, self.initial.velocity
        base = self.boundary_condition.translates
        return np.concatenate(
            (
                np.array(position or [0.0, 0.0]) if base else [],
                self._initial_values("phi"),
                np.array(velocity or [0.0, 0.0]) if base else [],
                self._initial_values("omega"),
                [state.initial for state in self.states.values()],
            )
        )

    @cached_property
    def time_laws(self) -> TimeLaws:
        """Functions of time in the scene, over the span."""
        groups = self._single_loads, self.loads_along_rod, self.state_rates
        single, spread, rates = (tuple(of.values()) for of in groups)
        masses = tuple(mass for *_, mass in self.distribution.changing_masses)
        law, (start, end) = self.spring_law, self.integrate.span
        along = self.distribution
        spring = (law, tuple(along.joint_stiffness), tuple(along.rest_angles)) if law else None
        base = tuple(e for name, e in self.expressions.items() if name in self._base_values)
        return TimeLaws(start, end, single, spread, rates, masses, self.rod.links, spring, base)

    def breaks(self) -> list[float]:
        """Break points: times inside the span [s] at which a load, the rate of a state or a mass is
        not smooth in t, ascending. An integrator of your own should step onto them."""
        return self.time_laws.breaks()
