"""The laws in the tables of a scene: expressions in time, in place and of the motion."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from rodgen.model.term import LINKS
from rodgen.model.terms import BASE_ANGLE, PARAMETERS, PLACES, rows_of
from rodgen.scene import spring_law
from rodgen.scene.contact_terms import contact_terms
from rodgen.scene.distribution import Distribution
from rodgen.scene.expression import Expression, parse_expression
from rodgen.scene.law import Law
from rodgen.scene.scene_fields import SceneFields
from rodgen.scene.time_laws import TimeLaws


class SceneLaws(SceneFields):
    """Tables of a scene with the laws that their texts are."""

    @property
    def _base_values(self) -> dict[str, Any]:
        """Values of what moves the start of the rod, by parameter."""
        return {} if self.base is None else self.base.values

    @property
    def given_parameters(self) -> tuple[str, ...]:
        """Names of the parameters of its loads, of its contacts, of the air and of its base."""
        tables = self.loads.parameters, self.contacts.parameters, self.airflow.key_paths
        return tuple(name for names in (*tables, self._base_values) for name in names)

    def given_value(self, name: str) -> Any:
        """Value of one of these parameters, as the scene has it; None of one that follows from
        others.

        name: of the parameter.
        """
        moved = self._base_values
        if name in moved:
            return moved[name]
        if name in self.airflow.key_paths:
            return self.airflow.value(name)
        tables = self.contacts if name in self.contacts.key_paths else self.loads
        return tables.value(name)

    def expression(self, name: str) -> Expression | None:
        """Expression of a parameter of a load or of the base that is given as text, in t, or in s
        where every link has its own; None for other parameters.

        name: of the parameter.
        """
        if name in self.airflow.key_paths:
            return self.airflow.expression(name)
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
        every = self.loads.key_paths, self.contacts.key_paths, self.airflow.key_paths
        return next((paths[name] for paths in every if name in paths), None) or PLACES[name]

    def key_of(self, name: str) -> str:
        """Dotted name in the scene of a parameter of the module.

        name: of the parameter.
        """
        return ".".join(self.key_path(name))

    def _law(self, name: str) -> Law:
        """Value along the rod of a parameter that every link has of its own."""
        return Law(self.loads.value(name), self.key_of(name), self._numbers, "st")

    def link_values_at(self, t: float) -> dict[str, list[float]]:
        """Values, in SI units, of the parameters that change with time and from link to link, by
        name, each a list over the links.

        t: the time [s].
        """
        laws = {name: self._law(name) for name in self.loads_along_rod}
        return {name: law.link_values(self.mesh, t) for name, law in laws.items()}

    def _state_rate(self, name: str) -> Expression:
        """Expression of the rate of an added state."""
        rate, place = self.states[name].rate, f"states.{name}.rate"
        text = rate if isinstance(rate, str) else repr(float(rate))
        return parse_expression(text, "t", place, self._numbers, tuple(self.states))

    @property
    def state_rates(self) -> dict[str, Expression]:
        """Rates of the added states, by name."""
        return {name: self._state_rate(name) for name in self.states}

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

    def clamp_angle_at(self, t: float) -> float:
        """Angle of the clamp at a time [rad]; zero without one.

        t: the time [s].
        """
        return (self.rod.clamp_angle or 0.0) + self._base_at(BASE_ANGLE, t)

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
        laws = single, spread, rates, masses, self.mesh, spring, base
        rows = rows_of(self.contacts.terms_with_places(self.mesh))
        contacts = contact_terms(rows, self.boundary_condition, self.rod.links)
        return TimeLaws(start, end, *laws, contacts)

    def breaks(self) -> list[float]:
        """Break points: times inside the span [s] at which a load, the rate of a state or a mass is
        not smooth in t, ascending. An integrator of your own should step onto them."""
        return self.time_laws.breaks()
