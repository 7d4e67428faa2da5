"""Structure of a scene, to which its module is specialised: terms and expressions, no values."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache
from itertools import starmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.model.rod import (
    BOUNDARIES,
    INERTIAS,
    LINK_LENGTH,
    MASS_WAYS,
    NONUNIFORM,
    ROD,
    STEADY,
    Boundary,
    changing_body_rows,
)
from rodgen.model.term import ANY, JOINTS, LINKS, NOT_NEGATIVE, SPRINGS, Parameter, Term
from rodgen.model.terms import (
    BASE_ROWS,
    PARAMETERS,
    THESIS_TERMS,
    boundary_of,
    load_places,
    rows_of,
)
from rodgen.scene import spring_law
from rodgen.scene.contact_terms import ContactTerm, check_stops, contact_terms
from rodgen.scene.expression import Expression, open_expression
from rodgen.scene.grammar import OF_STOPS, Sensor, TableData
from rodgen.scene.integration import EventTable
from rodgen.scene.literals import check_name, mass_name, number_parameter, table_parameter
from rodgen.scene.plain_tables import to_plain
from rodgen.scene.rod_mesh import RodMesh
from rodgen.scene.term_texts import (
    check_choice,
    check_links,
    check_place,
    check_term,
    sort_terms,
)

# What the thesis's damping of a rod whose links differ has to be.
EQUAL_LINKS = "absent: the thesis's damping is that of links of equal length, material_damping and "
EQUAL_LINKS += "viscous_drag are of any"
LONGEST = 150  # letters of loads in the name of a module, which is one of files


@dataclass(frozen=True, repr=False)
class Structure:
    """The structure of a scene: everything that its module is specialised to.

    n_links: their number; boundary: how the start is held; inertia: "uniform" or "lumped"; terms:
    names of the loads and of what else acts, with a place if that is not the tail
    (follower@6+1/10: on link 6, at a tenth of it); expressions: loads that are functions of time or
    of the motion, by parameter, as canonical text (part of the code; their numbers are parameters);
    nonuniform: what differs along the rod, keys of model.rod.NONUNIFORM; states: added
    states by name, with their rates as such text; spring: law of the springs as such text, "" for
    the moment k d; masses: masses that are functions of time, as such text, by name of the body and
    its link ("" and -1 for the links themselves); tables: how many rows those tables have whose
    numbers are not in these texts, by name; sensor_places: where links differ in length, on which
    of them the sensors are, as places of loads, by their s.

    Examples
    --------
    >>> import rodgen
    >>> structure = rodgen.Structure(2, "pinned", terms=("gravity",))
    >>> structure.stem, structure.parameters
    ('rod_pinned_n2_gravity', ('mass', 'length', 'bending_stiffness', 'gravity'))
    >>> structure.module_stem("c"), structure.width, structure.indices["gravity"]
    ('rod_pinned_n2_gravity_c', 4, 3)
    >>> structure.state_names, structure.hash == rodgen.Structure(3, "pinned").hash
    ((), False)
    """

    n_links: int
    boundary: str = "free"
    inertia: str = "uniform"
    terms: tuple[str, ...] = THESIS_TERMS
    expressions: tuple[tuple[str, str], ...] = field(default=())
    nonuniform: tuple[str, ...] = ()
    states: tuple[tuple[str, str], ...] = ()
    spring: str = ""
    masses: tuple[tuple[str, int, str], ...] = ()
    tables: tuple[tuple[str, int], ...] = ()
    sensor_places: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "n_links", to_plain(self.n_links, "links"))
        check_choice("boundary", self.boundary, BOUNDARIES)
        check_choice("inertia", self.inertia, INERTIAS)
        for term in self.terms:
            check_term(term, self.n_links, self.boundary_condition)
        for what in self.nonuniform:
            check_choice("nonuniform", what, NONUNIFORM)
        object.__setattr__(
            self, "nonuniform", tuple(what for what in NONUNIFORM if what in self.nonuniform)
        )
        weighed = [what for what in self.nonuniform if what in MASS_WAYS]
        if len(weighed) > 1:
            raise InputError(
                "nonuniform", weighed, "of mass, bodies and points one: the last say more"
            )
        for what, inertia in (("bodies", "uniform"), ("points", "lumped")):
            if what in self.nonuniform and self.inertia != inertia:
                raise InputError("nonuniform", what, f"absent for inertia {self.inertia}")
        self._check_lengths(weighed)
        check_links(self.n_links, self.boundary)
        ordered = sort_terms(self.terms)
        if ordered != self.terms:
            object.__setattr__(self, "terms", ordered)
        own = self._own_parameters
        timed = [name for name in own if PARAMETERS[name].timed]
        for name, _ in self.expressions:
            check_choice("expressions", name, timed or ["none: no term may change with time"])
        by_name = sorted(self.expressions, key=lambda pair: timed.index(pair[0]))
        object.__setattr__(self, "expressions", tuple(by_name))
        for name in (*self.numbers, *self.state_names, *dict(self.tables)):
            check_name(name, f"expressions.{name}")
        for e in self.laws.values():
            check_stops(e, self.loads)
        named = dict.fromkeys(name for e in self._all_expressions for name in e.tables)
        rows = dict(self.tables)
        if named.keys() != rows.keys() or any(count < 2 for count in rows.values()):
            allowed = f"the rows, at least 2, of {', '.join(named) or 'no table'}"
            raise InputError("tables", self.tables, allowed)
        object.__setattr__(self, "tables", tuple((name, rows[name]) for name in named))

    def _check_lengths(self, weighed: list[str]) -> None:
        """Raise InputError for links of unequal length without masses or springs of their own, with
        the thesis's damping, or with sensors of which the link is not known."""
        if "lengths" not in self.nonuniform:
            return
        if "stiffness" not in self.nonuniform or not weighed:
            allowed = "with stiffness, and with mass, bodies or points, beside lengths"
            raise InputError("nonuniform", self.nonuniform, allowed)
        for term in self.load_rows.values():
            if any(one.by_mass for one in term.parameters):
                raise InputError("terms", term.name, EQUAL_LINKS)
        seen = {repr(of.at) for of in self.sensors if of.what not in OF_STOPS}
        if missing := seen - dict(self.sensor_places).keys():
            raise InputError("sensor_places", self.sensor_places, f"a place for s = {min(missing)}")
        for _, place in self.sensor_places:
            check_place(place, self.n_links, "sensor_places")

    def __repr__(self) -> str:
        """Text with the fields that differ from their defaults."""
        said = (one for one in fields(self) if getattr(self, one.name) != one.default)
        return f"Structure({', '.join(f'{one.name}={getattr(self, one.name)!r}' for one in said)})"

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the added states, in the order in which y has them."""
        return tuple(name for name, _ in self.states)

    @cached_property
    def boundary_condition(self) -> Boundary:
        """Boundary condition at the start of the rod."""
        return boundary_of(self.boundary, self.terms)

    @cached_property
    def base_parameters(self) -> tuple[str, ...]:
        """Names of the parameters that move what holds the start of the rod."""
        return tuple(one.name for one in BASE_ROWS if one.name in self._own_parameters)

    @cached_property
    def has_moving_base(self) -> bool:
        """Whether the pivot or the clamp of the rod moves with time."""
        return any(name in dict(self.expressions) for name in self.base_parameters)

    @cached_property
    def loads(self) -> tuple[str, ...]:
        """Names of the loads, in the order of the terms."""
        return tuple(load_places(self.terms))

    @cached_property
    def load_rows(self) -> dict[str, Term]:
        """Rows of the loads in the vocabulary, by name, with the parameters that the module has,
        whether functions of time or not."""
        return rows_of(self.terms)

    @cached_property
    def contacts(self) -> tuple[ContactTerm, ...]:
        """Contacts of the rod."""
        return contact_terms(self.load_rows, self.boundary_condition, self.n_links)

    @cached_property
    def contact_events(self) -> tuple[EventTable, ...]:
        """Events of touching and leaving."""
        return tuple(event for one in self.contacts for event in one.events)

    @cached_property
    def potentials(self) -> tuple[str, ...]:
        """Names of the loads that have a potential: no work of theirs is counted."""
        varying = dict(self.expressions)
        terms = [term for term in self.load_rows.values() if term.is_conservative]
        return tuple(t.name for t in terms if not any(one.name in varying for one in t.parameters))

    @cached_property
    def _own_parameters(self) -> list[str]:
        """Names of the parameters of the rod, its boundary and its terms, whether functions of time
        or not; those of further loads of a kind come last."""
        loads = [one for row in self.load_rows.values() for one in row.parameters]
        ways = [NONUNIFORM[what] for what in self.nonuniform]
        differing = [one for way in ways for one in way.parameters]
        if self.masses:
            carrying = not {"bodies", "points"}.isdisjoint(self.nonuniform)
            steady = [STEADY[one.name] for one in differing if one.name in STEADY and carrying]
            differing = [one for one in differing if one.name not in STEADY] + steady
        known = {
            one.name for one in (*ROD, *self.boundary_condition.parameters, *loads, *differing)
        }
        known -= {name for way in ways for name in way.instead}
        first = [name for name in PARAMETERS if name in known]
        return [*first, *(one.name for one in loads if one.name not in first)]

    @cached_property
    def open_expressions(self) -> dict[str, Expression]:
        """Expressions with names in place of their numbers, by parameter."""
        texts = ((name, text) for name, text in self.expressions if not PARAMETERS[name].is_array)
        return {name: open_expression(text, "t", self.state_names, name) for name, text in texts}

    def mesh(self, p: NDArray[np.float64]) -> RodMesh:
        """Where the joints of one rod are.

        p: its parameters, (width,) in SI units.
        """
        place = self.slices.get(LINK_LENGTH.name)
        return RodMesh(self.n_links) if place is None else RodMesh.of_lengths(p[place].tolist())

    def expression_values(self, p: NDArray[np.float64]) -> dict[str, Any]:
        """Numbers and tables in the expressions of one rod, by name.

        p: its parameters, (width,) in SI units.
        """
        found: dict[str, Any] = {name: float(p[self.indices[name]]) for name in self.numbers}
        return found | {name: _table(p[self.slices[name]].tobytes()) for name, _ in self.tables}

    def time_dependent_loads(self, p: NDArray[np.float64]) -> dict[str, Expression]:
        """Loads of one rod, and coordinates of its base, that change with time alone, by the names
        of their parameters.

        p: its parameters, (width,) in SI units.
        """
        values, loads = self.expression_values(p), self.open_expressions.items()
        return {name: e.with_values(values) for name, e in loads if not e.signals}

    @cached_property
    def open_along(self) -> dict[str, Expression]:
        """Expressions in s and t, of which every link has a mean, by parameter."""
        texts = ((name, text) for name, text in self.expressions if PARAMETERS[name].is_array)
        return {name: open_expression(text, "t", ("s",), name) for name, text in texts}

    @cached_property
    def open_rates(self) -> dict[str, Expression]:
        """Rates of the added states, with names in place of their numbers."""
        named = ((name, text, f"states.{name}.rate") for name, text in self.states)
        return {name: open_expression(text, "t", self.state_names, at) for name, text, at in named}

    @cached_property
    def open_masses(self) -> dict[str, Expression]:
        """Masses that are functions of time, by their names in modules."""
        named = ((mass_name(name), text) for name, _, text in self.masses)
        return {name: open_expression(text, "t", ("s",), name) for name, text in named}

    @property
    def changing_bodies(self) -> dict[str, int]:
        """Links of the bodies whose masses are functions of time, by the prefix of their
        parameters."""
        return {f"body_{name}": link for name, link, _ in self.masses if name}

    @cached_property
    def _all_expressions(self) -> list[Expression]:
        """All expressions in time, place or the motion."""
        groups = self.open_expressions, self.open_rates, self.open_masses, self.open_along
        return [e for group in groups for e in group.values()]

    @cached_property
    def laws(self) -> dict[str, Expression]:
        """Expressions that a module evaluates from its state: those that follow states or sensors,
        by parameter, and the rates of added states, by rate_NAME."""
        fed = {name: e for name, e in self.open_expressions.items() if e.signals}
        return fed | {f"rate_{name}": e for name, e in self.open_rates.items()}

    @cached_property
    def has_feedback(self) -> bool:
        """Whether any law reads a sensor or a state."""
        return any(e.signals for e in self.laws.values())

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """The sensors that laws read."""
        return tuple(dict.fromkeys(of for e in self.laws.values() for of in e.sensors))

    @cached_property
    def spring_law(self) -> Expression:
        """The law of the springs, without values of the numbers in it."""
        return open_expression(self.spring or spring_law.HOOKE, spring_law.BEND)

    @cached_property
    def numbers(self) -> dict[str, str]:
        """Rules for the values of the numbers in expressions, by name."""
        found = {name: ANY for e in self._all_expressions for name in e.names}
        found |= dict.fromkeys(self.spring_law.names, NOT_NEGATIVE)
        return {name: rule for name, rule in found.items() if name != spring_law.STIFFNESS}

    @cached_property
    def rows(self) -> tuple[Parameter, ...]:
        """The parameters in the order in which p holds them; those of several numbers last."""
        timed = dict(self.expressions)
        own = [PARAMETERS[name] for name in self._own_parameters if name not in timed]
        own += starmap(number_parameter, self.numbers.items())
        own += (row for name in self.changing_bodies for row in changing_body_rows(name))
        own += (table_parameter(name) for name, _ in self.tables)
        return tuple(sorted(own, key=lambda one: one.is_array))

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters, in the order in which p holds them."""
        return tuple(one.name for one in self.rows)

    @cached_property
    def angle_indices(self) -> dict[str, int]:
        """Indices in p of angles of loads and of the clamp, by parameter."""
        names = [one.name for one in self.rows if one.is_angle and not one.is_array]
        return {name: self.slices[name].start for name in names}

    @cached_property
    def angle_slice(self) -> slice:
        """Slice of the states that are angles."""
        first = 2 * self.boundary_condition.translates
        return slice(first, first + self.n_links - self.boundary_condition.first)

    @cached_property
    def index_ranges(self) -> dict[str, range]:
        """Joints, links or rows that have a number each, of every parameter that has several."""
        found = {JOINTS: range(self.n_links + 1), LINKS: range(self.n_links)}
        found[SPRINGS] = self.boundary_condition.spring_joints(self.n_links)
        own = {name: range(2 * rows) for name, rows in self.tables}
        return own | {one.name: found[one.each] for one in self.rows if one.each in found}

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Slices of p that hold the parameters, by name."""
        found, start = {}, 0
        for name in self.parameters:
            stop = start + len(self.index_ranges.get(name, (name,)))
            found[name] = slice(start, stop)
            start = stop
        return found

    @cached_property
    def indices(self) -> dict[str, int]:
        """Index in p of each parameter, by name; of several numbers the first."""
        return {name: place.start for name, place in self.slices.items()}

    @cached_property
    def width(self) -> int:
        """Length of p."""
        return int(max(place.stop for place in self.slices.values()))

    @property
    def stem(self) -> str:
        """File name of the module in its default form and target, without its ending."""
        return self.module_stem()

    def module_stem(self, target: str = "numpy", form: str = "chain") -> str:
        """File name of a module of this structure, without its ending.

        target: "c" or "numpy"; form: "chain" or "dense".

        Expressions and places of loads are part of the code: with some, it ends in six letters of
        the hash, so that modules that differ in them have names and symbols of their own. Of many
        loads the first are named, and the others counted.
        """
        loads = [*self.loads] or ["conservative"]
        while len("_".join(loads)) > LONGEST:
            loads.pop()
        more = len(self.loads) - len(loads)
        counted = f"_and_{more}_more" if more > 0 else ""
        terms = "" if self.terms == THESIS_TERMS else "_" + "_".join(loads) + counted
        inertia = "" if self.inertia == "uniform" else f"_{self.inertia}"
        how = "" if form == "chain" else f"_{form}"
        where = "" if target == "numpy" else f"_{target}"
        nonuniform = "_nonuniform_" + "_".join(self.nonuniform) if self.nonuniform else ""
        coded = (self.expressions, self.states, self.spring, self.masses)
        special = any((counted, *coded, *load_places(self.terms).values()))
        timed = f"_{self.hash[:6]}" if special else ""
        return f"rod_{self.boundary}_n{self.n_links}{terms}{inertia}{nonuniform}{how}{where}{timed}"

    @cached_property
    def hash(self) -> str:
        """Content hash: equal for scenes that need the same code."""
        content: list[object] = [self.n_links, self.boundary, self.inertia, self.terms]
        content += [self.expressions, *([self.nonuniform] if self.nonuniform else [])]
        later = ("states", "spring", "masses", "tables", "sensor_places")
        content += [{name: getattr(self, name)} for name in later if getattr(self, name)]
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]


@lru_cache(maxsize=256)
def _table(numbers: bytes) -> TableData:
    """Table from the bytes of its numbers in p, which many rods have in common."""
    return TableData.of(np.frombuffer(numbers))
