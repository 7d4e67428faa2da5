"""Parts of a link, its own mass and that of bodies on it, as one mass with centre and spread."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.model.rod import LINK_LENGTH, NONUNIFORM, STEADY, changing_body_rows
from rodgen.scene.literals import mass_name
from rodgen.scene.rod_mesh import GAUSS, RodMesh, cell_means
from rodgen.scene.structure import Structure

STEADY_NAMES = {one.name for one in STEADY.values()}


@dataclass(frozen=True)
class BodyOutline:
    """A body, for drawing: its name, its link, its centre along and across the link over the link's
    length, and its size, the root of its share in the total mass."""

    name: str
    link: int
    along: float
    across: float
    size: float

    def positions(self, joints: Array) -> Array:
        """Positions of its centre (..., 2), for joints at (..., links + 1, 2)."""
        start, end = joints[..., self.link, :], joints[..., self.link + 1, :]
        x, y = np.moveaxis(end - start, -1, 0)
        found: Array = start + self.along * (end - start) + self.across * np.stack((-y, x), -1)
        return found


@dataclass(frozen=True)
class LinkPart:
    """A mass [kg] at a place along and across a link, and its mean squares about that, all over the
    length of the link."""

    mass: float
    along: float
    across: float = 0.0
    spread_along: float = 0.0
    spread_across: float = 0.0
    spread_mixed: float = 0.0


def combine(parts: Sequence[LinkPart]) -> tuple[float, ...]:
    """Combine parts of a link: mass, centre along and across, mean squares along and across and
    mean product about that centre."""
    masses = np.array([part.mass for part in parts])
    mass = float(masses.sum())
    if not mass:
        return (0.0,) * 6

    def mean(values: Iterable[float]) -> float:
        return float(masses @ np.array([*values]) / mass)

    a, b = mean(part.along for part in parts), mean(part.across for part in parts)
    return (
        *(mass, a, b),
        mean(part.spread_along + (part.along - a) ** 2 for part in parts),
        mean(part.spread_across + (part.across - b) ** 2 for part in parts),
        mean(part.spread_mixed + (part.along - a) * (part.across - b) for part in parts),
    )


def mesh_of(structure: Structure, values: Mapping[str, Any]) -> RodMesh:
    """Mesh of a rod by the parameters of its module."""
    lengths = values.get(LINK_LENGTH.name)
    return RodMesh(structure.n_links) if lengths is None else RodMesh.of_lengths(lengths)


def link_parameters_at(
    structure: Structure, values: Mapping[str, Any], t: float, rates: bool = False
) -> dict[str, list[float]]:
    """Parameters of the links at a time, from those of a module with masses that are functions of
    it; rates: of the masses that the links gain in a second instead."""
    n, lumped = structure.n_links, structure.inertia == "lumped"
    masses = {name: e.with_values(values) for name, e in structure.open_masses.items()}

    def evaluate_mass(name: str, **places: Array) -> Any:
        return masses[name].derivative(t, places) if rates else masses[name].evaluate(t, places)

    parts: list[list[LinkPart]] = [[] for _ in range(n)]
    if "steady_mass" in values and not rates:
        columns = (values[name] for name in structure.index_ranges if name in STEADY_NAMES)
        for link, row in enumerate(zip(*columns, strict=True)):
            parts[link].append(LinkPart(*row))
    if mass_name("") in masses:
        mesh, lengths = mesh_of(structure, values), np.full(n, values["length"] / n)
        lengths = np.asarray(values.get(LINK_LENGTH.name, lengths))
        density = evaluate_mass(mass_name(""), s=mesh.gauss_points())
        means = cell_means(np.broadcast_to(density, (n, GAUSS)))
        for link, mass in enumerate(lengths * means):
            parts[link].append(LinkPart(mass, 0.5, 0.0, 1 / 4 if lumped else 1 / 12))
    for name, link in structure.changing_bodies.items():
        along, across, spread = (values[row.name] for row in changing_body_rows(name))
        mass = float(evaluate_mass(f"{name}_mass"))
        own = 0.0 if rates else spread / mass
        parts[link].append(LinkPart(mass, along, across, own, own))
    names = [one.name for one in NONUNIFORM["bodies"].parameters]
    known = {one.name for what in structure.nonuniform for one in NONUNIFORM[what].parameters}
    found = zip(names, zip(*map(combine, parts), strict=True), strict=True)
    return {name: list(column) for name, column in found if name in known}
