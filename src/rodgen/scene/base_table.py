"""The table of what holds the start of a rod and moves, and which motions it can have."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, model_validator

from rodgen.errors import InputError, Missing
from rodgen.model.rod import Boundary
from rodgen.model.terms import BASE_ROWS
from rodgen.scene.tables import Finite, Table
from rodgen.scene.term_texts import base_keys


class BaseTable(Table):
    """Motion of the pivot or the clamp that holds the start of the rod: functions of time, which
    are differentiated twice."""

    x: Finite | str | None = Field(
        None, description="of joint 0 [m], a number or an expression in t; without it 0"
    )
    y: Finite | str | None = Field(
        None, description="of joint 0 [m], a number or an expression in t; without it 0"
    )
    angle: Finite | str | None = Field(
        None,
        description="of the clamp [rad], a number or an expression in t, added to `clamp_angle`, "
        "of `cantilever` and `clamped` alone; without it 0",
    )

    @model_validator(mode="after")
    def _check_given(self) -> Self:
        if not self.values:
            raise InputError("base", Missing(), "given: at least one of x, y and angle")
        return self

    @property
    def values(self) -> dict[str, Any]:
        """Values by the names of their parameters, without those that are left out."""
        found = {one.name: getattr(self, one.key) for one in BASE_ROWS}
        return {name: value for name, value in found.items() if value is not None}

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys that are given."""
        return tuple(one.key for one in BASE_ROWS if getattr(self, one.key) is not None)

    def check_boundary(self, boundary: Boundary, name: str) -> None:
        """Raise InputError for a motion that a rod of this boundary cannot have; name: of it."""
        keys = base_keys(boundary)
        if not keys:
            raise InputError("base", "a table", f"absent: nothing holds a rod of boundary {name}")
        for key in self.keys:
            if key not in keys:
                allowed = f"absent: boundary {name} has no clamp"
                raise InputError(f"base.{key}", getattr(self, key), allowed)
