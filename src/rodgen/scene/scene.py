"""A scene: what is modelled, integrated and plotted; TOML in, checked values out."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError, model_validator

from rodgen.scene import structure as st
from rodgen.scene.errors import SceneError
from rodgen.scene.explain import explain
from rodgen.scene.expression import Expression
from rodgen.scene.tables import Initial, Integrate, Loads, Rod, Table


class Scene(Table):
    """A whole scene, checked. Raises SceneError where a file or a value cannot be used."""

    name: str
    rod: Rod
    loads: Loads = Loads()
    initial: Initial = Initial()
    integrate: Integrate = Integrate()

    @classmethod
    def from_toml(cls, path: str | Path) -> Scene:
        """Read a scene from a TOML file."""
        try:
            text = Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "not UTF-8 text"
            raise SceneError("scene", str(path), f"a file that can be read ({reason})") from None
        try:
            table = tomllib.loads(text)
        except (ValueError, RecursionError) as error:
            raise SceneError("scene", str(path), f"valid TOML ({error})") from None
        return cls.from_dict(table)

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Scene:
        """Check a scene that is already a dictionary of tables."""
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise explain(error, table, cls) from None

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
        terms = tuple(term for term in st.TERMS if getattr(self.loads, term) is not None)
        force, rod = self._timed_force, self.rod
        expressions = (("follower_force", force.canonical),) if force else ()
        return st.Structure(rod.links, rod.boundary, rod.inertia, terms, expressions)

    @property
    def _timed_force(self) -> Expression | None:
        """The follower force, where it changes with time."""
        follower = self.loads.follower
        if follower is None or not isinstance(follower.force, str):
            return None
        force = Expression(follower.force, "t", "loads.follower.force")
        return None if force.constant else force

    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the parameters of its module, by name."""
        loads, rod = self.loads, self.rod
        values: dict[str, Any] = {
            "mass": rod.mass,
            "length": rod.length,
            "bending_stiffness": rod.bending_stiffness,
            "clamp_angle": rod.clamp_angle or 0.0,
        }
        if loads.follower:
            force = loads.follower.force
            # A text without t is a number like any other.
            number = isinstance(force, str) and self._timed_force is None
            values["follower_force"] = float(Expression(str(force), "t")(0.0)) if number else force
            values["follower_angle"] = loads.follower.angle
        if loads.gravity:
            values["gravity"] = loads.gravity.g
        if loads.internal_damping:
            values["internal_damping"] = loads.internal_damping.coefficient
        if loads.external_damping:
            fins = loads.external_damping.fin_factor
            values["external_damping"] = loads.external_damping.coefficient
            values["fin_factor"] = fins if isinstance(fins, list) else fins.values(rod.links)
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
        """Times inside the span at which a load is not smooth."""
        force = self._timed_force
        start, end = self.integrate.span
        return force.breaks(start, end) if force else []

    def with_integrate(self, **changes: Any) -> Scene:
        """The same scene with other values in [integrate]; those that are None are left."""
        changes = {name: value for name, value in changes.items() if value is not None}
        table = self.model_dump(exclude_none=True)
        table["integrate"] |= changes
        return Scene.from_dict(table)
