"""Tables of a scene, checked, and what follows from them: structure, parameters, start, laws."""

from __future__ import annotations

import operator
import re
from functools import cached_property
from typing import Any, ClassVar, Self

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
from rodgen.model.parameter import JOINTS, LINKS
from rodgen.model.rod import CLAMP_ANGLE, ROD, Boundary
from rodgen.model.terms import PARAMETERS, PLACES
from rodgen.scene import spring
from rodgen.scene import structure as st
from rodgen.scene.along import Distribution
from rodgen.scene.anchors import Anchors
from rodgen.scene.course import Course
from rodgen.scene.event import Event, check_events
from rodgen.scene.expression import Expression, Numbers, parsed
from rodgen.scene.grammar import TableData
from rodgen.scene.integration import Integrate
from rodgen.scene.law import Law
from rodgen.scene.load_tables import FinFactor, Loads
from rodgen.scene.lookup_table import MOST_ROWS, LookupTable, parse_table
from rodgen.scene.numbers import check_names, check_states, mass_of
from rodgen.scene.plain import plain
from rodgen.scene.tables import (
    Body,
    Finite,
    Foundation,
    Initial,
    Rod,
    State,
    Support,
    Table,
    check_bodies,
    check_count,
    tables_in,
)
from rodgen.scene.validation import explain


class SceneTables(Table):
    """All tables of a scene, checked together, and what follows from their values; see Scene."""

    # `parameters` are those of the module: the table's own name is that of a file.
    model_config: ClassVar[ConfigDict] = ConfigDict(serialize_by_alias=True, validate_by_name=True)

    name: str = Field(description="a plain identifier; names the folder of the results")
    numbers: dict[str, Finite] = Field(
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
    rod: Rod
    bodies: list[Body] = []
    supports: list[Support] = []
    foundation: Foundation | None = None
    loads: Loads = Loads()
    states: dict[str, State] = Field({}, exclude_if=operator.not_)
    initial: Initial = Initial()
    events: list[Event] = []
    integrate: Integrate = Integrate()

    def __init__(self, /, **tables: Any) -> None:
        """Check tables, each a keyword; arrays, tuples and NumPy's numbers are taken too."""
        tables = plain(tables)
        try:
            super().__init__(**tables)
        except ValidationError as error:
            raise explain(error, tables, type(self)) from None

    @field_validator("events", "bodies", "supports", mode="before")
    @classmethod
    def _many(cls, tables: Any, info: ValidationInfo) -> list[Any]:
        """Each by itself, so that what is wrong is named by its place in the array."""
        key = str(info.field_name)
        kinds: dict[str, type[Table]] = {"events": Event, "bodies": Body, "supports": Support}
        return tables_in(key, tables, kinds[key])

    @field_validator("states", mode="before")
    @classmethod
    def _countable(cls, tables: Any) -> Any:
        """Their number first, as each of them takes some time."""
        if isinstance(tables, dict):
            check_count("states", tables)
        return tables

    @field_validator("tables", mode="before")
    @classmethod
    def _parse_tables(cls, tables: Any) -> Any:
        """Each by itself, so that what is wrong is named by its name."""
        if not isinstance(tables, dict):
            return tables
        check_count("tables", tables)
        made = {name: parse_table(name, table) for name, table in tables.items()}
        if (rows := sum(map(len, made.values()))) > MOST_ROWS:
            raise InputError("tables", rows, f"at most {MOST_ROWS} rows in all")
        return made

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,63}", self.name):
            raise InputError("name", self.name, "a plain identifier of at most 64 ASCII characters")
        rates = [spring.NAME, *(f"{name}_rate" for name in self.states)]
        masses = [mass_of(body.name) for body in self.bodies]
        check_names(self.numbers, "parameters", (*rates, mass_of(""), *masses))
        check_names(self.states, "states", rates)
        check_states(self.states, self.numbers)
        for name in self.states:
            self._rate(name)
        for parameter in self.loads.parameters:
            value, each = self.loads.value(parameter), PARAMETERS[parameter].each
            count = self.rod.links + (each == JOINTS)
            if isinstance(value, list) and len(value) != count:
                allowed = f"a list of {count} values, one for every {each}"
                raise InputError(self.field(parameter), value, allowed)
            self._number_of(parameter)
        for name in ("position", "velocity"):
            value = getattr(self.initial, name)
            if value is not None and not self.hold.translates:
                allowed = f"absent: joint 0 of boundary {self.rod.boundary} is fixed"
                raise InputError(f"initial.{name}", value, allowed)
        self._links("phi")
        self._links("omega")
        check_events(self.events, self.rod, self.states)
        check_bodies(self.bodies, self.rod)
        self._check_span()
        self.anchors.check()
        if self.spring_law is not None and not np.any(self.distribution.joint_stiffness):
            raise InputError(spring.FIELD, self.rod.spring, "absent: no joint has a stiffness")
        return self

    def _check_span(self) -> None:
        """Raise InputError for what cannot be so within the span."""
        for parameter in self.loads.parameters:
            if PARAMETERS[parameter].each == LINKS:
                self._law(parameter).check_poles(self.integrate.span)
        self.along_at(self.integrate.span[0])
        self.distribution.check(self.integrate.span)

    def _links(self, name: str) -> NDArray[np.float64]:
        """Initial values of the moving links."""
        return self.initial.of_links(name, self.rod, self._numbers)

    @property
    def hold(self) -> Boundary:
        """How the start of the rod is held."""
        return self.rod.hold

    @property
    def held(self) -> int:
        """How many links at the start of the rod do not move."""
        return self.hold.first

    @cached_property
    def _numbers(self) -> Numbers:
        """What expressions may name: numbers, and tables by names in quotes."""
        tables = ((repr(name), table) for name, table in self.tables.items())
        return (*self.numbers.items(), *tables)

    def expression(self, name: str) -> Expression | None:
        """The expression that a parameter of a load is given by, where it is given by text: in t,
        or in s where every link has its own.

        name: of the parameter.
        """
        value = self.loads.value(name)
        if not isinstance(value, str):
            return None
        if PARAMETERS[name].each == LINKS:
            return self._law(name).expression
        return parsed(value, "t", self.field(name), self._numbers, tuple(self.states))

    def place(self, name: str) -> tuple[str, ...]:
        """Where a parameter of the module stands: the keys of tables, from the outermost in.

        name: of the parameter.
        """
        return self.loads.places.get(name) or PLACES[name]

    def field(self, name: str) -> str:
        """Where a parameter of the module stands, as a dotted name.

        name: of the parameter.
        """
        return ".".join(self.place(name))

    def _number_of(self, name: str) -> Any:
        """The number that a parameter of a load is, or those of all joints or links; None of one
        that changes with time."""
        value, text, links = self.loads.value(name), self.expression(name), self.rod.links
        if isinstance(value, FinFactor):
            return value.values(links)
        if PARAMETERS[name].each == LINKS:
            law = self._law(name)
            return law.of_links(links, self.integrate.span[0]) if not law.changes else None
        # A text without t is a number like any other.
        return value if text is None else float(text(0.0)) if text.constant else None

    def _law(self, name: str) -> Law:
        """A parameter that every link has of its own."""
        return Law(self.loads.value(name), self.field(name), self._numbers, "st")

    def along_at(self, t: float) -> dict[str, list[float]]:
        """Values, in SI units, of the parameters that change with time and from link to link, by
        name, each a list over the links.

        t: the time [s].
        """
        laws = {name: self._law(name) for name in self.along}
        return {name: law.of_links(self.rod.links, t) for name, law in laws.items()}

    def _rate(self, name: str) -> Expression:
        """The rate of a state that is added."""
        rate, place = self.states[name].rate, f"states.{name}.rate"
        text = rate if isinstance(rate, str) else repr(float(rate))
        return parsed(text, "t", place, self._numbers, tuple(self.states))

    @property
    def structure(self) -> st.Structure:
        """What its module is specialised to: the numbers in its expressions are parameters."""
        return self._structure

    @cached_property
    def _structure(self) -> st.Structure:
        rod = self.rod
        values = dict[str, Any]()

        def text(e: Expression, prefix: str) -> str:
            named, found = e.parametrised(prefix)
            values.update(found)
            return named

        texts = tuple((name, text(force, name)) for name, force in self.expressions.items())
        rates = tuple((name, text(e, f"{name}_rate")) for name, e in self.rates.items())
        terms = self.loads.structure(rod.links) + self.anchors.terms
        what = rod.links, rod.boundary, rod.inertia, terms
        sprung = text(self.spring_law, spring.NAME) if self.spring_law else ""
        along = self.distribution
        masses = tuple((name, link, text(e, mass_of(name))) for name, link, e in along.changing)
        tables = ((name, len(of)) for name, of in values.items() if isinstance(of, TableData))
        return st.Structure(*what, texts, along.uneven, rates, sprung, masses, tuple(tables))

    @property
    def spring_law(self) -> Expression | None:
        """The law of the springs, where that is not Hooke's, else None."""
        text = self.rod.spring
        law = None if text is None else spring.law(text, self._numbers)
        return None if law is None or spring.is_hooke(law.canonical) else law

    @property
    def slack(self) -> bool:
        """Whether the springs do not resist a small bend of the straight rod."""
        return self.spring_law is not None and spring.is_slack(self.spring_law)

    @property
    def anchors(self) -> Anchors:
        """What holds the rod elsewhere than at its start: supports and foundation."""
        start = self.initial.position or (0.0, 0.0)
        return Anchors(self.rod, self.supports, self.foundation, start, self._numbers)

    @property
    def distribution(self) -> Distribution:
        """How stiffness and mass lie along the rod, at the start of the span."""
        return self.distribution_at(self.integrate.span[0])

    def distribution_at(self, t: float) -> Distribution:
        """How stiffness and mass lie along the rod at a time.

        t: the time [s].
        """
        return Distribution(self.rod, self.bodies, self._numbers, t)

    @property
    def mass(self) -> float:
        """Mass of the links and of all bodies at the start of the span [kg]."""
        return self.distribution.mass

    @property
    def expressions(self) -> dict[str, Expression]:
        """Parameters that change with time or with the motion, by name."""
        return self._expressions

    # Kept, as a run asks dozens of times; copies that are made here have other settings in
    # [integrate] alone. Pydantic takes names without an underscore for keys.
    @cached_property
    def _expressions(self) -> dict[str, Expression]:
        found = {name: self.expression(name) for name in self.loads.parameters}
        return {
            name: e
            for name, e in found.items()
            if e and (e.changes if PARAMETERS[name].each else not e.constant)
        }

    @property
    def along(self) -> dict[str, Expression]:
        """Parameters that change with time and may differ from link to link, by name."""
        return {name: e for name, e in self.expressions.items() if PARAMETERS[name].each}

    @property
    def timed(self) -> dict[str, Expression]:
        """Parameters that change with time alone, by name."""
        found = self.expressions.keys() - self.along.keys()
        return {name: e for name, e in self.expressions.items() if name in found and not e.signals}

    @property
    def fed(self) -> dict[str, Expression]:
        """Parameters that follow the motion, by name."""
        found = self.expressions.keys() - self.along.keys()
        return {name: e for name, e in self.expressions.items() if name in found and e.signals}

    @property
    def rates(self) -> dict[str, Expression]:
        """Rates of the states that are added, by name."""
        return {name: self._rate(name) for name in self.states}

    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the parameters of its module, by name, in SI units; of a table TableData, an
        array of its knots and then its values."""
        rod, along = self.rod, self.distribution
        values: dict[str, Any] = {
            one.name: getattr(rod, one.key) or 0.0 for one in (*ROD, CLAMP_ANGLE)
        }
        values |= {"bending_stiffness": along.stiffness, "mass": along.links_mass}
        if "stiffness" in along.uneven:
            values["joint_stiffness"] = along.joint_stiffness
        if {*along.uneven} - {"stiffness"}:
            values |= along.of_links(steady=bool(along.changing))
        values |= along.numbers_of_changing
        values |= {name: self._number_of(name) for name in self.loads.parameters}
        for name, text in self.expressions.items():
            values |= text.parametrised(name)[1]
        values |= self.anchors.parameters
        if self.spring_law is not None:
            values |= self.spring_law.parametrised(spring.NAME)[1]
        for name, text in self.rates.items():
            values |= text.parametrised(f"{name}_rate")[1]
        return {name: values[name] for name in self.structure.parameters}

    def initial_state(self) -> NDArray[np.float64]:
        """The state y at the start of the span, (states,), in SI units and the order of the
        module's STATE."""
        position, velocity = self.initial.position, self.initial.velocity
        base = self.hold.translates
        return np.concatenate(
            (
                np.array(position or [0.0, 0.0]) if base else [],
                self._links("phi"),
                np.array(velocity or [0.0, 0.0]) if base else [],
                self._links("omega"),
                [state.initial for state in self.states.values()],
            )
        )

    @property
    def course(self) -> Course:
        """What the scene has as functions of time, over the span."""
        return self._course

    @cached_property
    def _course(self) -> Course:
        laws = [*self.expressions.values(), *self.rates.values()]
        masses = [mass for *_, mass in self.distribution.changing]
        fed = [*self.fed.values(), *self.rates.values()]
        timed, along = tuple(self.timed.values()), tuple(self.along.values())
        law, (start, end) = self.spring_law, self.integrate.span
        return Course(
            start,
            end,
            (*laws, *masses),
            timed,
            along,
            tuple(fed),
            spread=(*along, *masses),
            links=self.rod.links,
            spring=(law, tuple(self.distribution.joint_stiffness)) if law else None,
            masses=tuple(masses),
        )

    def breaks(self) -> list[float]:
        """Times inside the span at which a load, the rate of a state or a mass is not smooth in t,
        ascending [s]: an integrator of one's own should step onto them."""
        return self.course.breaks()
