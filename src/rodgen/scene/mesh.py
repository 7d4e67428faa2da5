"""Values of a scene that depend on its number of links: damping, and lists link by link."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.errors import InputError
from rodgen.model.rod import REST_CURVATURE
from rodgen.model.term import JOINTS
from rodgen.model.terms import PARAMETERS, TERMS
from rodgen.scene import spring_law
from rodgen.scene.load_tables import FinFactor
from rodgen.scene.plain_tables import set_at
from rodgen.scene.scene_tables import SceneTables
from rodgen.scene.term_texts import check_links


@dataclass(frozen=True)
class MeshDependentValue:
    """A number of a scene of n links that another number of links would change.

    what: its label; key: tables and key; the part of ``value`` above ``even`` is that of the same
    rod where it grows as n^power.
    """

    what: str
    key: tuple[str, ...]
    value: float
    even: float
    power: int

    def after_refinement(self, ratio: float) -> float:
        """Value for the same rod after refining the mesh by `ratio`."""
        return self.even + (self.value - self.even) * ratio**self.power

    @property
    def field(self) -> str:
        return ".".join(self.key)


def mesh_dependent_values(
    scene: SceneTables, everything: bool = False
) -> Iterator[MeshDependentValue]:
    """Yield the damping of a scene that depends on its number of links.

    A joint has the moment c_int M/n times the difference of two rates, which is l = L/n times the
    rate of curvature; its spring EI/l times that of the angles: c_int grows as n^2. A fin acts on
    the mass M/2n of an end: what it has beyond the body's factor, which is spread, grows as n.
    """
    for term in map(TERMS.__getitem__, scene.loads.terms):
        rows = [row for row in term.parameters if row.links_power]
        if not rows or not (everything or scene.loads.value(term.parameters[0].name)):
            continue  # or the load does nothing
        for one in rows:
            value, key = scene.loads.value(one.name), scene.key_path(one.name)
            if not one.is_array:
                yield MeshDependentValue(one.label, key, value, 0.0, one.links_power)
            elif isinstance(value, FinFactor):
                for end in ("nose", "tail") if scene.boundary_condition.translates else ("tail",):
                    if (factor := getattr(value, end)) > value.body:
                        what, at = f"the {one.label} at the {end}", (*key, end)
                        yield MeshDependentValue(what, at, factor, value.body, one.links_power)


def mesh_notes(scene: SceneTables) -> tuple[str, ...]:
    """Sentences on damping that another number of links would change, with its equivalent."""
    n = scene.rod.links
    if not scene.distribution.total_link_mass:
        names = [name for name in scene.loads.parameters if PARAMETERS[name].by_mass]
        fields = [scene.key_of(name) for name in names if scene.loads.value(name)]
        return tuple(f"{field} damps nothing: the links have no mass" for field in fields)
    sprung = (
        f"{spring_law.FIELD} is that of a joint, whose angle belongs to the number of links "
        "(Scene.with_links converts)",
    )
    laws = {1: "its part above fin_factor.body grows as n", 2: "it grows as n^2"}
    return sprung * (scene.spring_law is not None) + tuple(
        f"{one.what} belongs to the number of links: for the same rod, {one.field} = "
        f"{one.value:.6g} at n = {n} is {one.after_refinement(2):.6g} at n = {2 * n} "
        f"({laws[one.power]}; Scene.with_links converts)"
        for one in mesh_dependent_values(scene)
    )


def with_links(scene: SceneTables, links: int) -> dict[str, Any]:
    """Tables of the same rod with another number of links and its damping converted."""
    check_links(links, scene.rod.boundary, "links")
    _check_no_lists(scene)
    return refined_tables(scene, links)


def refined_tables(scene: SceneTables, links: int) -> dict[str, Any]:
    """Tables with another number of links and damping converted; values that are given link by link
    are left as they are."""
    tables: dict[str, Any] = scene.model_dump(exclude_none=True)
    tables["rod"]["links"] = links
    if isinstance(scene.rod.joints, list):
        tables["rod"]["joints"] = _refined_joints(scene.rod.joints, links)
    if scene.rod.spring is not None:
        tables["rod"]["spring"] = spring_law.refine(scene.rod.spring, links / scene.rod.links)
    for one in mesh_dependent_values(scene):
        set_at(tables, one.key, one.after_refinement(links / scene.rod.links))
    return tables


def _refined_joints(joints: list[float], links: int) -> list[float]:
    """Joints of a rod whose links are each cut in as many equal parts. Raises InputError."""
    known = len(joints) - 1
    if links % known:
        allowed = (
            f"an expression in i and n for {links} links: a list is cut into multiples of its "
        )
        raise InputError("rod.joints", joints, f"{allowed}{known} alone")
    every = np.arange(links + 1) * (known / links)
    return [float(s) for s in np.interp(every, np.arange(known + 1), joints)]


def _check_no_lists(scene: SceneTables) -> None:
    """Raise InputError for values that are given link by link."""
    form = "a number or an expression in s"
    lists = {f"initial.{key}": (getattr(scene.initial, key), form) for key in ("phi", "omega")}
    for name in scene.loads.parameters:
        words = "nose, body and tail" if PARAMETERS[name].each == JOINTS else form
        lists[scene.key_of(name)] = scene.loads.value(name), words
    for key in ("bending_stiffness", "mass_per_length", REST_CURVATURE.key):
        lists[f"rod.{key}"] = getattr(scene.rod, key), form
    why = "to be had with another number of links"
    for field, (value, allowed) in lists.items():
        if isinstance(value, list):
            raise InputError(field, value, f"{allowed}, {why}")
    for at, event in enumerate(scene.events):
        if re.match(r"(phi|omega|joint)_[0-9]", event.quantity):
            allowed = f"of the tail or of the whole rod, {why}"
            raise InputError(f"events[{at}].quantity", event.quantity, allowed)
