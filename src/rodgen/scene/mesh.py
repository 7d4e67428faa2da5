"""What of a scene belongs to its number of links: damping, and lists of a value for every link."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from rodgen.scene import structure as st
from rodgen.scene.errors import SceneError
from rodgen.scene.tables import FinFactor

if TYPE_CHECKING:
    from rodgen.scene.scene import Scene

SAME = 1e-9  # relative: what two ways to write one and the same damping differ by


@dataclass(frozen=True)
class PerLink:
    """A number of a scene of n links that another number of links would change.

    what: it is of; key: tables and key; of ``value`` the part above ``even`` stands for the same
    rod where it grows as n^power.
    """

    what: str
    key: tuple[str, ...]
    value: float
    even: float
    power: int

    def times(self, ratio: float) -> float:
        """What stands for the same rod with so many times as many links."""
        return self.even + (self.value - self.even) * ratio**self.power

    @property
    def field(self) -> str:
        return ".".join(self.key)


def per_link(scene: Scene) -> Iterator[PerLink]:
    """The damping of a scene that its number of links is part of.

    A joint has the moment c_int M/n times the difference of two rates, which is l = L/n times the
    rate of curvature; its spring EI/l times that of the angles: c_int grows as n^2. A fin acts on
    the mass M/2n of an end: what it has beyond the body's factor, which is spread, grows as n.
    """
    internal, external = scene.loads.internal_damping, scene.loads.external_damping
    if internal and internal.coefficient:
        inside = ("loads", "internal_damping", "coefficient")
        yield PerLink("internal damping", inside, internal.coefficient, 0.0, 2)
    if external and external.coefficient and isinstance(fins := external.fin_factor, FinFactor):
        for end in ("nose", "tail") if scene.hold.translates else ("tail",):
            if (value := getattr(fins, end)) > fins.body:
                key = ("loads", "external_damping", "fin_factor", end)
                yield PerLink(f"the fin at the {end}", key, value, fins.body, 1)


def mesh_notes(scene: Scene) -> tuple[str, ...]:
    """Sentences on damping that another number of links would change, with its equivalent."""
    n = scene.rod.links
    laws = {1: "its part above fin_factor.body grows as n", 2: "it grows as n^2"}
    return tuple(
        f"{one.what} belongs to the number of links: for the same rod, {one.field} = "
        f"{one.value:.6g} at n = {n} is {one.times(2):.6g} at n = {2 * n} ({laws[one.power]}; "
        "Scene.with_links converts)"
        for one in per_link(scene)
    )


def with_links(scene: Scene, links: int) -> dict[str, Any]:
    """Tables of the same rod with another number of links, its damping converted."""
    st.check_links(links, scene.rod.boundary, "links")
    _check_spread(scene)
    tables: dict[str, Any] = scene.model_dump(exclude_none=True)
    tables["rod"]["links"] = links
    for one in per_link(scene):
        table = tables
        for key in one.key[:-1]:
            table = table[key]
        table[one.key[-1]] = one.times(links / scene.rod.links)
    return tables


def _check_spread(scene: Scene) -> None:
    """Raise SceneError for what is given link by link."""
    external = scene.loads.external_damping
    lists = {
        "initial.phi": scene.initial.phi,
        "initial.omega": scene.initial.omega,
        "loads.external_damping.fin_factor": external.fin_factor if external else None,
    }
    why = "to be had with another number of links"
    for field, value in lists.items():
        if isinstance(value, list):
            allowed = "nose, body and tail" if "fin" in field else "a number or an expression in s"
            raise SceneError(field, value, f"{allowed}, {why}")
    for at, event in enumerate(scene.events):
        if re.match(r"(phi|omega|joint)_[0-9]", event.quantity):
            allowed = f"of the tail or of the whole rod, {why}"
            raise SceneError(f"events[{at}].quantity", event.quantity, allowed)


def unlike_damping(scenes: Sequence[Scene]) -> list[str]:
    """Fields with which scenes of several numbers of links do not stand for one and the same
    damping of a rod."""
    known = [
        {one.field: one.times(1 / s.rod.links) - one.even for one in per_link(s)} for s in scenes
    ]
    fields = dict.fromkeys(field for values in known for field in values)
    return [
        field
        for field in fields
        if any(
            not math.isclose(a.get(field, 0.0), b.get(field, 0.0), rel_tol=SAME)
            for a, b in pairwise(known)
        )
    ]
