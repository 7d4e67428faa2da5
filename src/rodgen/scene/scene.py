"""A scene: what is modelled, integrated and plotted; TOML in, checked values out."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError, field_validator, model_validator

from rodgen.scene import structure as st
from rodgen.scene.errors import SceneError, check_type
from rodgen.scene.explain import explain
from rodgen.scene.expression import Expression
from rodgen.scene.mesh import with_links
from rodgen.scene.onsets import onsets
from rodgen.scene.plain import plain
from rodgen.scene.tables import (
    AUTO,
    EITHER,
    Event,
    FinFactor,
    Initial,
    Integrate,
    Loads,
    Rod,
    Table,
    check_events,
)
from rodgen.scene.toml import read_table


class Scene(Table):
    """A whole scene, checked. Raises SceneError where a file or a value cannot be used."""

    name: str
    rod: Rod
    loads: Loads = Loads()
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

    @classmethod
    def from_toml(cls, path: str | Path) -> Scene:
        """Read a scene from a TOML file, of at most 10 MB, 1e5 values, and 50 levels."""
        return cls.from_dict(read_table(Path(path)))

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Scene:
        """Check a scene that is already a dictionary of tables."""
        if not isinstance(table, dict):
            raise SceneError("scene", table, "a table")
        return cls(**{str(key): value for key, value in table.items()})

    @field_validator("events", mode="before")
    @classmethod
    def _events(cls, tables: Any) -> list[Event]:
        """Each by itself, so that what is wrong is named by its place in the array."""
        if not isinstance(tables, list):
            raise SceneError("events", tables, "an array of tables, [[events]]")
        events = []
        for i, table in enumerate(tables):
            if not isinstance(table, dict | Event):
                raise SceneError(f"events[{i}]", table, "a table")
            try:
                events.append(Event.model_validate(table))
            except ValidationError as error:
                found = explain(error, dict(table), Event)
                raise SceneError(f"events[{i}].{found.field}", found.value, found.allowed) from None
        return events

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,63}", self.name):
            raise SceneError("name", self.name, "a plain identifier of at most 64 ASCII characters")
        external = self.loads.external_damping
        fins = external.fin_factor if external else None
        if isinstance(fins, list) and len(fins) != self.rod.links + 1:
            allowed = f"a list of {self.rod.links + 1} values, one for every joint"
            raise SceneError("loads.external_damping.fin_factor", fins, allowed)
        for name in ("position", "velocity"):
            value = getattr(self.initial, name)
            if value is not None and not self.hold.translates:
                allowed = f"absent: joint 0 of boundary {self.rod.boundary} is fixed"
                raise SceneError(f"initial.{name}", value, allowed)
        self._links("phi")
        self._links("omega")
        check_events(self.events, self.rod)
        return self

    def _links(self, name: str) -> NDArray[np.float64]:
        """Initial values of the moving links."""
        n = self.rod.links
        links = np.arange(self.held, n)
        value = getattr(self.initial, name)
        if value is None:  # at rest and straight, along the clamp where there is one
            value = (self.rod.clamp_angle or 0.0) if name == "phi" else 0.0
        if isinstance(value, list):
            if len(value) != len(links):
                allowed = f"a list of {len(links)} values, one for every moving link"
                raise SceneError(f"initial.{name}", value, allowed)
            return np.array(value, dtype=float)
        if isinstance(value, str):
            made = Expression(value, "s", f"initial.{name}")((links + 0.5) / n)
            values = np.broadcast_to(made, links.shape).astype(float)
            if not np.all(np.isfinite(values)):
                bad = int(links[~np.isfinite(values)][0])
                raise SceneError(
                    f"initial.{name}", value, f"finite at every link (not at link {bad})"
                )
            return values
        return np.full(len(links), float(value))

    @property
    def hold(self) -> st.Hold:
        """How the start of the rod is held."""
        return st.BOUNDARIES[self.rod.boundary]

    @property
    def held(self) -> int:
        """How many links at the start of the rod do not move."""
        return self.hold.first

    @property
    def structure(self) -> st.Structure:
        """What its module is specialised to."""
        rod = self.rod
        timed = tuple((name, force.canonical) for name, force in self.timed.items())
        return st.Structure(rod.links, rod.boundary, rod.inertia, self.loads.terms, timed)

    @property
    def timed(self) -> dict[str, Expression]:
        """Parameters that change with time, by name."""
        found = {name: self.loads.expression(name) for name in self.loads.parameters}
        return {name: e for name, e in found.items() if e and not e.constant}

    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the parameters of its module, by name."""
        rod = self.rod
        values: dict[str, Any] = {
            "mass": rod.mass,
            "length": rod.length,
            "bending_stiffness": rod.bending_stiffness,
            "clamp_angle": rod.clamp_angle or 0.0,
        }
        for name in self.loads.parameters:
            value, text = self.loads.value(name), self.loads.expression(name)
            # A text without t is a number like any other.
            values[name] = float(text(0.0)) if text and text.constant else value
            if isinstance(value, FinFactor):
                values[name] = value.values(rod.links)
        return {name: values[name] for name in self.structure.parameters}

    def initial_state(self) -> NDArray[np.float64]:
        """y at the start of the span, in the order of the module's STATE."""
        position, velocity = self.initial.position, self.initial.velocity
        base = self.hold.translates
        return np.concatenate(
            (
                np.array(position or [0.0, 0.0]) if base else [],
                self._links("phi"),
                np.array(velocity or [0.0, 0.0]) if base else [],
                self._links("omega"),
            )
        )

    def breaks(self) -> list[float]:
        """Times inside the span at which a load is not smooth, ascending."""
        start, end = self.integrate.span
        found: list[float] = []
        for at in sorted(at for e in self.timed.values() for at in e.breaks(start, end)):
            # What two expressions compare may meet zero a rounding apart.
            if not found or at - found[-1] > 4 * np.spacing(abs(at)):
                found.append(at)
        return found

    def pulses(self) -> list[tuple[float, float, float]]:
        """Begin, peak and end of what a load does after a rest that is longer, ascending."""
        start, end = self.integrate.span
        return sorted(pulse for e in self.timed.values() for pulse in onsets(e, start, end))

    def swing(self) -> float:
        """Half a period [s] of the load that swings fastest; infinity where none swings."""
        start, end = self.integrate.span
        return min((e.swing(start, end) for e in self.timed.values()), default=math.inf)

    def pole(self) -> tuple[float, Expression] | None:
        """The first time in the span at which a load grows beyond all bounds, and that load."""
        start, end = self.integrate.span
        found = [(at, e) for e in self.timed.values() for at in e.poles(start, end)]
        return min(found, key=lambda pair: pair[0], default=None)

    def with_integrate(self, **changes: Any) -> Scene:
        """The same scene with other values in [integrate]; those that are None are left.

        A tolerance takes the place of a step of the scene, where the method has a use for either;
        another output_every that of t_eval.
        """
        changes = {name: value for name, value in changes.items() if value is not None}
        table = self.model_dump(exclude_none=True)
        method = changes.get("method", self.integrate.method)
        if method in EITHER and {"rtol", "atol"} & set(changes):
            table["integrate"].pop("step", None)
        if "output_every" in changes:
            table["integrate"].pop("t_eval", None)
        table["integrate"] |= changes
        return Scene.from_dict(table)

    def integrated_by(self, method: str) -> Scene:
        """The same scene by a method that was found for it; what `auto` finds is no method of equal
        steps, whatever the step that stands in the scene."""
        found: dict[str, Any] = {"method": method}
        if self.integrate.method == AUTO:
            found["step"] = None
        return self.model_copy(update={"integrate": self.integrate.model_copy(update=found)})

    def with_links(self, links: int) -> Scene:
        """The same rod with another number of links: coefficients of damping that belong to a
        number of links are converted, c_int by (n'/n)^2, a fin by n'/n. Raises SceneError for a
        number that is not allowed, and for a scene that has a list of a value for every link or
        watches one of its links."""
        return Scene.from_dict(with_links(self, links))


def check_scene(scene: object) -> None:
    """Raise TypeError for what is no Scene, such as the path of one."""
    check_type("scene", scene, Scene, see="Scene.from_toml")
