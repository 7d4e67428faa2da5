"""The tables of contacts: stops of points and of joints, and walls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.model.rod import Boundary
from rodgen.model.term import Term
from rodgen.model.terms import CONTACTS
from rodgen.scene.load_tables import MOST_PLACED, TermTables, make_term_table
from rodgen.scene.rod_mesh import RodMesh
from rodgen.scene.tables import Table

MANY = 6  # places that are not told one by one
WIDE, FAR = 0.06, 20.0  # of the length: half of a stop that is drawn, and how far a wall goes

if TYPE_CHECKING:

    class StopTable(Table):
        at: float
        direction: float
        gap: float
        to: list[float] | None

    class JointStopTable(Table):
        at: float

    class WallTable(Table):
        normal: float
        point: list[float]
        edge: float | None

else:
    StopTable, JointStopTable, WallTable = map(make_term_table, CONTACTS)


@dataclass(frozen=True)
class ContactTables(TermTables):
    """Contacts of a rod: the tables [[stops]], [[joint_stops]] and [[walls]] of a scene."""

    stops: Sequence[StopTable] = ()
    joint_stops: Sequence[JointStopTable] = ()
    walls: Sequence[WallTable] = ()

    ROWS: ClassVar[Sequence[Term]] = CONTACTS
    PATH: ClassVar[tuple[str, ...]] = ()

    def check(self, mesh: RodMesh, boundary: Boundary) -> None:
        """Raise InputError for contacts that no module can have."""
        for term in CONTACTS:
            tables = getattr(self, term.table)
            if len(tables) > MOST_PLACED:
                raise InputError(term.table, len(tables), f"at most {MOST_PLACED} tables")
            for number, table in enumerate(tables if term.placed else ()):
                allowed = (_joints if term.at_joints else _links)(table.at, mesh, boundary)
                if allowed:
                    raise InputError(f"{term.table}[{number}].at", table.at, allowed)

    def outlines(self, length: float, to: Callable[[Any], Sequence[float]]) -> list[Array]:
        """Lines of what points of the rod run against, each (k, 2) [m], with what pushes to the
        right of them; walls go on far beyond a rod of this length [m].

        to: place from which the way towards a stop is counted [m].
        """
        found = []
        for stop in self.stops:
            ahead = _unit(stop.direction)
            middle = np.array(to(stop)) + stop.gap * ahead
            found.append(middle + np.outer((-WIDE * length, WIDE * length), _left(ahead)))
        for wall in self.walls:
            away, point = _unit(wall.normal), np.array(wall.point, dtype=float)
            along, far = -_left(away), FAR * length
            ends = [point - far * along]
            if wall.edge is None:
                ends.append(point + far * along)
            else:
                ends += [point + wall.edge * along, point + wall.edge * along - far * away]
            found.append(np.array(ends))
        return found


def _links(at: float, mesh: RodMesh, boundary: Boundary) -> str:
    """Words for the places that a stop may have; empty where s is one of them."""
    link, share = mesh.link_and_share(at)
    if link >= boundary.first and (share or link >= boundary.first_joint):
        return ""
    return f"a point that moves, beyond {mesh.places[boundary.first]:.6g}"


def _joints(at: float, mesh: RodMesh, boundary: Boundary) -> str:
    """Words for the joints that may have a stop; empty where s is that of one."""
    (link, share), springs = mesh.link_and_share(at), boundary.spring_joints(mesh.links)
    if link in springs and not share:
        return ""
    places = [f"{s:.9g}" for s in mesh.places[springs.start : springs.stop]]
    if mesh.is_even:
        places = [f"{at}/{mesh.links}" for at in springs]
    few = places if len(places) < MANY else [*places[:2], "...", places[-1]]
    return f"s of a joint with a spring: {', '.join(few)}" if few else "absent: no joint bends"


def _unit(angle: float) -> Array:
    """Unit vector in a direction [rad]."""
    return np.array((cos(angle), sin(angle)))


def _left(ahead: Array) -> Array:
    """Vector to the left of another."""
    return np.array((-ahead[1], ahead[0]))
