"""Checked tables of a scene, and what follows from them: structure, parameters, start."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    model_validator,
)

from rodgen.errors import InputError
from rodgen.model.quantities import FLOW
from rodgen.model.rod import CLAMP_ANGLE, MASS_WAYS, ROD
from rodgen.model.term import JOINTS, LINKS
from rodgen.model.terms import BASE_ROWS, MOVING_BASE, PARAMETERS
from rodgen.scene import spring_law
from rodgen.scene import structure as st
from rodgen.scene.anchors import Anchors
from rodgen.scene.contact_terms import check_stops
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import OF_STOPS, TableData
from rodgen.scene.integration import EventTable, check_events
from rodgen.scene.literals import NAME, check_names, check_states, mass_name
from rodgen.scene.load_tables import FinFactor
from rodgen.scene.plain_tables import get_at
from rodgen.scene.scene_laws import SceneLaws
from rodgen.scene.tables import (
    REST,
    check_bodies,
)
from rodgen.scene.time_laws import check_motion


class SceneTables(SceneLaws):
    """All tables of a scene, checked together, and what follows from their values; see Scene."""

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
        self.airflow.check()
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
                held = "is fixed" if self.base is None else "is where [base] has it"
                allowed = f"absent: joint 0 of boundary {self.rod.boundary} {held}"
                raise InputError(f"initial.{name}", value, allowed)
        if self.initial.angle is not None and self.boundary_condition.is_clamped:
            allowed = "absent: the clamp has one, rod.clamp_angle"
            raise InputError("initial.angle", self.initial.angle, allowed)
        if self.initial.phi == REST in self.numbers:
            allowed = f'another name: initial.phi = "{REST}" is the shape without load'
            raise InputError(f"parameters.{REST}", self.numbers[REST], allowed)
        check_bodies(self.bodies, self.rod, self.mesh)
        self._check_mesh()
        self._check_span()
        self._initial_values("phi")
        self._initial_values("omega")
        self.anchors.check()
        self.contacts.check(self.mesh, self.boundary_condition)
        for e in (*self.expressions.values(), *self.state_rates.values()):
            check_stops(e, self.contacts.terms)
        self._check_events()
        if self.spring_law is not None and not np.any(self.distribution.joint_stiffness):
            raise InputError(spring_law.FIELD, self.rod.spring, "absent: no joint has a stiffness")
        return self

    def _check_events(self) -> None:
        """Raise InputError for events that cannot be looked out for."""
        events = self.structure.contact_events if self.contacts.terms else ()
        names = [*self.states, *self.term_numbers]
        check_events(self.events, self.rod, names, (one.name for one in events))

    @property
    def term_numbers(self) -> list[str]:
        """Names of the numbers of contacts, and of points that the air pushes."""
        found = self.structure.contacts if self.contacts.terms else ()
        flows = (f"{what}_{name}" for name in self.loads.air_places for what in FLOW)
        return [*(name for one in found for name in one.numbers), *flows]

    @property
    def has_places_of_start(self) -> bool:
        """Whether anything on the ground is where the rod begins, so that another start of the rod,
        or another rod, moves it."""
        computed = any(stop.to is None for stop in self.stops)
        return bool(self.supports or self.foundation or computed)

    @property
    def obstacles(self) -> list[NDArray[np.float64]]:
        """Lines of stops and walls, for drawing, each (k, 2) [m]: what pushes is to their right."""
        return self.contacts.outlines(self.rod.length, self.anchors.fixed_point)

    @property
    def watched_events(self) -> tuple[EventTable, ...]:
        """Events that runs look out for: those of [[events]], and touching and leaving."""
        return (*self.events, *self.structure.contact_events)

    def _check_mesh(self) -> None:
        """Raise InputError for damping that knows links of equal length alone."""
        for name in self.loads.parameters:
            if PARAMETERS[name].by_mass and not self.mesh.is_even:
                raise InputError(self.key_of(name), self.loads.value(name), st.EQUAL_LINKS)

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

    def _load_value(self, name: str) -> Any:
        """Value of a parameter of a load or of the base: a number, or those of all joints or links;
        None for one that changes with time."""
        value, text = self.given_value(name), self.expression(name)
        if PARAMETERS[name].computed and value is None:
            if name in self.loads.key_paths:
                return self.loads.computed_value(name, self.rod.diameter)
            *keys, _, axis = self.contacts.key_paths[name]
            return self.anchors.fixed_point(get_at(self, *keys))[int(axis)]
        if PARAMETERS[name].by_mass and not self.distribution.total_link_mass:
            return 0.0  # of a rod whose links have no mass
        if isinstance(value, FinFactor):
            return value.values(self.rod.links)
        if PARAMETERS[name].each == LINKS:
            law, start = self._law(name), self.integrate.span[0]
            return None if law.is_time_dependent else law.link_values(self.mesh, start)
        # A text without t is a number like any other.
        return value if text is None else float(text(0.0)) if text.is_constant else None

    @cached_property
    def structure(self) -> st.Structure:
        """Structure to which its module is specialised: numbers in expressions are parameters."""
        rod = self.rod
        values = dict[str, Any]()

        def parametrise(e: Expression, prefix: str) -> str:
            named, found = e.with_parameters(prefix)
            values.update(found)
            return named

        texts = tuple(
            (name, parametrise(e, PARAMETERS[name].prefix)) for name, e in self.expressions.items()
        )
        rates = tuple(
            (name, parametrise(e, f"{name}_rate")) for name, e in self.state_rates.items()
        )
        terms = self.loads.terms_with_places(self.mesh, self.airflow.options) + self.anchors.terms
        terms += self.contacts.terms_with_places(self.mesh)
        terms += () if self.base is None else (f"{MOVING_BASE}@{'+'.join(self.base.keys)}",)
        what = rod.links, rod.boundary, rod.inertia, terms
        sprung = parametrise(self.spring_law, spring_law.NAME) if self.spring_law else ""
        along = self.distribution
        masses = tuple(
            (name, link, parametrise(e, mass_name(name))) for name, link, e in along.changing_masses
        )
        tables = ((name, len(of)) for name, of in values.items() if isinstance(of, TableData))
        given = along.nonuniform, rates, sprung, masses, tuple(tables), self._sensor_places
        return st.Structure(*(*what, texts, *given))

    @property
    def _sensor_places(self) -> tuple[tuple[str, str], ...]:
        """Places on the links of the sensors, by their s, where links differ in length."""
        if self.mesh.is_even:
            return ()
        laws = (*self.expressions.values(), *self.state_rates.values())
        places = {of.at for e in laws for of in e.sensors if of.what not in OF_STOPS}
        return tuple((repr(s), self.mesh.place_text(s)) for s in sorted(places))

    @property
    def anchors(self) -> Anchors:
        """Supports and foundation of the rod."""
        start = self.initial.position or self._base_start
        turned = self.initial.angle or 0.0
        placed = any(one.name in self._base_values for one in BASE_ROWS[:2])
        held = self.rod, self.supports, self.foundation
        return Anchors(*held, start, self._numbers, turned, placed, self.bodies)

    @property
    def _base_start(self) -> tuple[float, float]:
        """Place of joint 0 at the start of the span, where it is held [m]."""
        x, y = (self._base_at(one.name, self.integrate.span[0]) for one in BASE_ROWS[:2])
        return x, y

    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the parameters of its module, by name, in SI units; of a table TableData, an
        array of its knots and then its values."""
        rod, along = self.rod, self.distribution
        values: dict[str, Any] = {
            one.name: getattr(rod, one.key) or 0.0 for one in (*ROD, CLAMP_ANGLE)
        }
        values |= {"bending_stiffness": along.stiffness, "mass": along.unit_mass}
        values |= along.joint_parameters
        if not MASS_WAYS.isdisjoint(along.nonuniform):
            values |= along.link_parameters()
        values |= along.changing_mass_parameters
        values |= {name: self._load_value(name) for name in self.given_parameters}
        for name, text in self.expressions.items():
            values |= text.with_parameters(PARAMETERS[name].prefix)[1]
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
