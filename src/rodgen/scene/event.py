"""Events: what is watched in a run, and what is done then."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Self

from pydantic import Field, model_validator

from rodgen.errors import InputError, did_you_mean
from rodgen.model.quantities import parse_number, watchable_names
from rodgen.model.rod import BOUNDARIES
from rodgen.scene import structure as st
from rodgen.scene.tables import Finite, RodTable, Table

DIRECTIONS, ACTIONS = ("rising", "falling", "either"), ("record", "stop")


class EventTable(Table):
    """A state or a derived quantity that crosses a value: the run stops, or it is recorded."""

    quantity: str = Field(description="a state or a derived quantity, by name")
    value: Finite = Field(description="what it crosses, in the unit of the quantity")
    direction: str = Field(default="either", description='`"rising"`, `"falling"` or `"either"`')
    action: str = Field(
        default="record", description='`"record"` the crossing, or `"stop"` the run there'
    )
    name: str = Field(
        default_factory=lambda it: f"{it.get('quantity')} = {it.get('value')!r}",
        description="up to 64 characters, each event its own; without it `quantity = value`",
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        st.check_choice("direction", self.direction, DIRECTIONS)
        st.check_choice("action", self.action, ACTIONS)
        return self


def check_events(events: list[EventTable], rod: RodTable, states: Iterable[str]) -> None:
    """Raise InputError for an event whose quantity this rod lacks, or whose name is not its own;
    states: names of the added states."""
    known = [
        *watchable_names(BOUNDARIES[rod.boundary], rod.links),
        *((name, range(1)) for name in states),
    ]
    first: dict[str, int] = {}
    for i, event in enumerate(events):
        if not any(parse_number(event.quantity, name) in span for name, span in known):
            ends = [(name.format(span[0]), name.format(span[-1])) for name, span in known]
            shown = ", ".join(" to ".join(dict.fromkeys(pair)) for pair in ends)
            allowed = f"one of {shown}{did_you_mean(event.quantity, sum(ends, ()))}"
            raise InputError(f"events[{i}].quantity", event.quantity, allowed)
        name, place = event.name, f"events[{i}].name"
        if not (0 < len(name) <= 64 and name.isprintable() and name.strip()):
            raise InputError(place, name, "1 to 64 printable characters")
        if first.setdefault(name, i) != i:
            raise InputError(place, name, f"unlike that of events[{first[name]}]")
