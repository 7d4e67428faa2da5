"""The table of the air, and what it is at each of the points that it pushes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator

from rodgen.arrays import Array
from rodgen.errors import InputError, Missing
from rodgen.model.term import BY_HEIGHT, Parameter
from rodgen.model.terms import AIR_ROWS, PARAMETERS, TERMS
from rodgen.scene.expression import Expression, parse_expression
from rodgen.scene.expression_text import Numbers
from rodgen.scene.grammar import names_in, parse, replace_names
from rodgen.scene.number_text import Expressed
from rodgen.scene.plain_tables import get_at
from rodgen.scene.standard_atmosphere import density_text, speed_of_sound
from rodgen.scene.tables import Finite, NotNegative, Positive, Table

AIR, HEIGHT, STANDARD = "air", "y", "isa"
DENSITY, WIND_X, WIND_Y, STALL_ANGLE = AIR_ROWS


class AirTable(Table):
    """The air that pushes fins, noses and points with axial drag."""

    density: NotNegative | str = Field(description=DENSITY.documentation)
    height: Expressed[Finite] | None = Field(
        None, description=f'height of y = 0 above the sea [m], for `"{STANDARD}"`; without it 0'
    )
    speed_of_sound: Expressed[Positive] | None = Field(
        None, description="[m/s], for doubts; without it that of the standard atmosphere"
    )
    wind: list[Finite | str] | None = Field(
        None,
        min_length=2,
        max_length=2,
        description="velocity of the air `[x, y]` [m/s], each a number or an expression, likewise; "
        "without it still",
    )
    stall_angle: Expressed[Positive] = Field(
        STALL_ANGLE.default or 0.0,
        description=f"{STALL_ANGLE.documentation}; without it 15 degrees",
    )

    def sound_speed(self, y: Array) -> Array:
        """Speed of sound at heights y of the scene [m/s]."""
        if self.speed_of_sound is not None:
            return np.full_like(y, self.speed_of_sound)
        return speed_of_sound(y, float(self.height or 0.0))

    @model_validator(mode="after")
    def _check_height(self) -> Self:
        if self.height is not None and not self.is_standard:
            raise InputError("air.height", self.height, f'absent: air.density is not "{STANDARD}"')
        return self

    @property
    def is_standard(self) -> bool:
        """Whether the density is that of the standard atmosphere, or follows from it."""
        tree = parse(self.density, "air.density") if isinstance(self.density, str) else None
        return tree is not None and STANDARD in names_in(tree)


@dataclass(frozen=True)
class Airflow:
    """The air at every point that it pushes.

    table: None where a scene has none; places: s of the points, by the names of their loads;
    numbers: values of the names in expressions; states: that they may follow.
    """

    table: AirTable | None
    places: dict[str, float]
    numbers: Numbers
    states: tuple[str, ...]

    def check(self) -> None:
        """Raise InputError for points that the air pushes without a table of it."""
        if self.places and self.table is None:
            names = ", ".join(f"loads.{TERMS[name].table}" for name in self.places)
            raise InputError(AIR, Missing(), f"a table with `density`, for {names}")

    @cached_property
    def _texts(self) -> dict[str, Expression]:
        """Expressions in time, height and the motion, by shared parameter."""
        found = {}
        for one in AIR_ROWS:
            if isinstance(text := self._shared_value(one), str):
                states = (*self.states, HEIGHT)
                field = ".".join((AIR, *one.key_path))
                found[one.name] = parse_expression(text, "t", field, self.numbers, states)
        return found

    def _shared_value(self, one: Parameter) -> Any:
        """Value of a parameter, as the scene has it; of the standard atmosphere its text."""
        table = self.table
        if table is None or getattr(table, one.key) is None:
            return None
        value = get_at(table, *one.key_path)
        if one is not DENSITY or not table.is_standard:
            return value
        tree = parse(str(value), f"{AIR}.{one.key}")
        assert tree is not None
        return replace_names(tree, {STANDARD: density_text(float(table.height or 0.0))})

    @cached_property
    def options(self) -> tuple[str, ...]:
        """Options of the loads that the air pushes: which of its numbers a module has, and which
        are those at the place of each load."""
        if self.table is None:
            return ()
        high = {one.key for one in AIR_ROWS if self._follows_height(one)}
        keys = (DENSITY.key, *([WIND_X.key] if self.table.wind is not None else []))
        found = (f"{key}{BY_HEIGHT}" if key in high else key for key in keys)
        return tuple(one for one in found if one != DENSITY.key)

    def _follows_height(self, one: Parameter) -> bool:
        e = self._texts.get(one.name)
        return e is not None and HEIGHT in e.signals

    @cached_property
    def key_paths(self) -> dict[str, tuple[str, ...]]:
        """Keys of every parameter of the air in a scene, from the outermost table in."""
        found = {}
        given = "+".join(self.options)
        for name in self.places if self.table is not None else ():
            for one in TERMS[name].parameters_with(given):
                if one.table:
                    found[one.name] = (AIR, *one.key_path)
        return found

    def value(self, name: str) -> Any:
        """Value of a parameter, as the scene has it."""
        return get_at(self.table, *self.key_paths[name][1:])

    def expression(self, name: str) -> Expression | None:
        """Expression of a parameter in time and in the motion; of one at the place of a load, with
        the height of that in place of `y`; None for a number."""
        row = PARAMETERS[name]
        text = self._shared_value(row if row in AIR_ROWS else PARAMETERS[row.prefix])
        if not isinstance(text, str):
            return None
        if row.by_height:
            (load,) = (of for of in self.places if row in TERMS[of].parameters)
            tree = parse(text, AIR)
            assert tree is not None
            text = replace_names(tree, {HEIGHT: f"{HEIGHT}({self.places[load]!r})"})
        field = ".".join(self.key_paths[name])
        return parse_expression(text, "t", field, self.numbers, self.states)
