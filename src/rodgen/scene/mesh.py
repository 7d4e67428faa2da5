"""What of a scene belongs to its number of links: damping, and lists of a value for every link."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from rodgen.errors import InputError
from rodgen.model.parameter import JOINTS
from rodgen.model.terms import PARAMETERS, TERMS
from rodgen.scene import spring
from rodgen.scene import structure as st
from rodgen.scene.load_tables import FinFactor
from rodgen.scene.plain import put
from rodgen.scene.scene_tables import SceneTables

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


def per_link(scene: SceneTables, everything: bool = False) -> Iterator[PerLink]:
    """The damping of a scene that its number of links is part of.

    A joint has the moment c_int M/n times the difference of two rates, which is l = L/n times the
    rate of curvature; its spring EI/l times that of the angles: c_int grows as n^2. A fin acts on
    the mass M/2n of an end: what it has beyond the body's factor, which is spread, grows as n.
    """
    for term in map(TERMS.__getitem__, scene.loads.terms):
        if not (everything or scene.loads.value(term.parameters[0].name)):
            continue  # the load does nothing
        for one in term.parameters:
            value, key = scene.loads.value(one.name), scene.place(one.name)
            if not one.links_power:
                continue
            if not one.several:
                yield PerLink(one.label, key, value, 0.0, one.links_power)
            elif isinstance(value, FinFactor):
                for end in ("nose", "tail") if scene.hold.translates else ("tail",):
                    if (factor := getattr(value, end)) > value.body:
                        what, at = f"the {one.label} at the {end}", (*key, end)
                        yield PerLink(what, at, factor, value.body, one.links_power)


def mesh_notes(scene: SceneTables) -> tuple[str, ...]:
    """Sentences on damping that another number of links would change, with its equivalent."""
    n = scene.rod.links
    sprung = (
        f"{spring.FIELD} is that of a joint, whose angle belongs to the number of links "
        "(Scene.with_links converts)",
    )
    laws = {1: "its part above fin_factor.body grows as n", 2: "it grows as n^2"}
    return sprung * (scene.spring_law is not None) + tuple(
        f"{one.what} belongs to the number of links: for the same rod, {one.field} = "
        f"{one.value:.6g} at n = {n} is {one.times(2):.6g} at n = {2 * n} ({laws[one.power]}; "
        "Scene.with_links converts)"
        for one in per_link(scene)
    )


def with_links(scene: SceneTables, links: int) -> dict[str, Any]:
    """Tables of the same rod with another number of links, its damping converted."""
    st.check_links(links, scene.rod.boundary, "links")
    _check_spread(scene)
    tables: dict[str, Any] = scene.model_dump(exclude_none=True)
    tables["rod"]["links"] = links
    if scene.rod.spring is not None:
        tables["rod"]["spring"] = spring.remeshed(scene.rod.spring, links / scene.rod.links)
    for one in per_link(scene):
        put(tables, one.key, one.times(links / scene.rod.links))
    return tables


def _check_spread(scene: SceneTables) -> None:
    """Raise InputError for what is given link by link."""
    form = "a number or an expression in s"
    lists = {f"initial.{key}": (getattr(scene.initial, key), form) for key in ("phi", "omega")}
    for name in scene.loads.parameters:
        words = "nose, body and tail" if PARAMETERS[name].each == JOINTS else form
        lists[scene.field(name)] = scene.loads.value(name), words
    for key in ("bending_stiffness", "mass_per_length"):
        lists[f"rod.{key}"] = getattr(scene.rod, key), form
    why = "to be had with another number of links"
    for field, (value, allowed) in lists.items():
        if isinstance(value, list):
            raise InputError(field, value, f"{allowed}, {why}")
    for at, event in enumerate(scene.events):
        if re.match(r"(phi|omega|joint)_[0-9]", event.quantity):
            allowed = f"of the tail or of the whole rod, {why}"
            raise InputError(f"events[{at}].quantity", event.quantity, allowed)


def unlike_damping(scenes: Sequence[SceneTables]) -> list[str]:
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
