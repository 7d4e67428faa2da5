"""Contacts among the loads of a rod: their numbers, events and switches."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from rodgen.errors import InputError
from rodgen.model.quantities import CONTACTS, JOINT_CONTACTS
from rodgen.model.rod import Boundary
from rodgen.model.term import CONTACT, Term
from rodgen.model.terms import TERMS
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import OF_STOPS, Sensor
from rodgen.scene.integration import EventTable

TOUCHES, LEAVES = "touches", "leaves"
DEPTH, PUSH = "depth", "push"
OPENING, CORNER = "opening", "corner"  # where the push of what is pressed is not smooth


@dataclass(frozen=True)
class ContactTerm:
    """Contact of a rod. name: of its term; joints: those that may touch a wall, none of a
    stop; switches: what else is zero where its push is not smooth."""

    name: str
    joints: range
    switches: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """How many points may touch it."""
        return len(self.joints) or 1

    @property
    def kind(self) -> str:
        """Kind of its quantities, which are metres and newtons or angles and moments."""
        return JOINT_CONTACTS if TERMS[self.name].at_joints else CONTACTS

    @property
    def places(self) -> dict[str, str]:
        """Words for itself, and for where the single joints touch it, by the ends of the names of
        their numbers."""
        words = TERMS[self.name].words
        single = {f"{self.name}_{at}": f"{words} at joint {at}" for at in self.joints}
        return {self.name: words, **single}

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of its numbers."""
        return tuple(f"{what}_{place}" for what in (DEPTH, PUSH) for place in self.places)

    @property
    def events(self) -> Iterator[EventTable]:
        """Events of touching and of leaving."""
        words = TERMS[self.name].words
        for place in [f"{self.name}_{at}" for at in self.joints] or [self.name]:
            where = self.places[place].removeprefix(words)
            for what, direction in ((TOUCHES, "rising"), (LEAVES, "falling")):
                how = {"quantity": f"{DEPTH}_{place}", "value": 0.0, "direction": direction}
                yield EventTable(**how, name=f"{words} {what}{where}")


def contact_terms(
    rows: Mapping[str, Term], boundary: Boundary, links: int
) -> tuple[ContactTerm, ...]:
    """Contacts of a rod with loads of these rows."""
    along = range(boundary.first_joint, links + 1)
    by_key = {"damping": OPENING, "edge": CORNER}
    found = []
    for name, row in rows.items():
        if row.kind == CONTACT:
            switches = (by_key[one.key] for one in row.parameters if one.key in by_key)
            found.append(ContactTerm(name, range(0) if row.placed else along, tuple(switches)))
    return tuple(found)


def count_name(event: str) -> str:
    """Name by which a study counts an event: of a wall, at whatever joint it touches."""
    return event.partition(" at joint ")[0]


def event_names(events: Iterable[EventTable]) -> list[str]:
    """Names of events, and those by which all of a wall are counted."""
    names = [event.name for event in events]
    return [*dict.fromkeys([*names, *map(count_name, names)])]


def check_stops(e: Expression, loads: Collection[str]) -> None:
    """Raise InputError for a law that reads a stop which a rod with these loads does not have."""
    for of in e.sensors:
        if of.what in OF_STOPS and stop_name(of) not in loads:
            count = sum(TERMS[name].base_name == of.what for name in loads)
            there = f"{of.what}(0) to {of.what}({count - 1}) alone" if count else "without it"
            allowed = f"{there}, not {of.what}({of.at:g}): there are {count} [[{of.what}s]]"
            raise InputError(e.field, e.text, allowed)


def stop_name(sensor: Sensor) -> str:
    """Name among the loads of the stop that a sensor reads."""
    number = int(sensor.at) + 1
    return sensor.what if number == 1 else f"{sensor.what}_{number}"
