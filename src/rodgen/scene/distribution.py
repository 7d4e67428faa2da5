"""Stiffness and mass along a rod, lumped into its joints and links; and links with their bodies.

A joint stands for the rod half a link to either side of it: its spring turns as much as the rod
bends there, 1/k = integral of ds/EI, by five Gauss points over each half. A link has the mass that
lies on it, by five Gauss points, and the bodies that are fixed to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.model.rod import NONUNIFORM, STEADY, changing_body_rows
from rodgen.scene.expression import Expression, Numbers
from rodgen.scene.law import GAUSS, Along, Law, cell_means, gauss_points
from rodgen.scene.literals import mass_name
from rodgen.scene.rod_points import link_and_share
from rodgen.scene.structure import Structure
from rodgen.scene.tables import SMALLEST, BodyTable, RodTable

STIFFNESS, PER_LENGTH = "rod.bending_stiffness", "rod.mass_per_length"

STEADY_NAMES = {one.name for one in STEADY.values()}


@dataclass(frozen=True)
class Distribution:
    """Stiffness and mass along a rod with its bodies. numbers: values of the names in expressions;
    t: the time at which masses are taken [s]."""

    rod: RodTable
    bodies: Sequence[BodyTable] = ()
    numbers: Numbers = ()
    t: float = 0.0

    def check(self, span: Sequence[float]) -> None:
        """Raise InputError for a stiffness or mass that is impossible at some time of the span."""
        links, per_length = self.rod.links, self._mass_per_length
        self._stiffness.check(links, links + 1)
        if per_length is not None:
            per_length.check(links, links, SMALLEST, span)
        for law in self._body_laws:
            law.check(links, 1, SMALLEST, span)

    @property
    def changing_masses(self) -> list[tuple[str, int, Expression]]:
        """Masses that are functions of time, with names and links; "" and -1 for those of links."""
        laws = [("", -1, self._mass_per_length)]
        laws += [
            (body.name, link_and_share(body.at, self.rod.links)[0], law)
            for body, law in zip(self.bodies, self._body_laws, strict=True)
        ]
        return [
            (name, link, law.expression)
            for name, link, law in laws
            if law and law.is_time_dependent
        ]

    @property
    def _body_laws(self) -> list[Law]:
        fields = (f"bodies[{at}].mass" for at in range(len(self.bodies)))
        pairs = zip(self.bodies, fields, strict=True)
        return [Law(body.mass, field, self.numbers, "t") for body, field in pairs]

    @property
    def body_masses(self) -> list[float]:
        """Mass of every body [kg]."""
        return [float(law.at(np.zeros(1), self.t)[0]) for law in self._body_laws]

    @property
    def _stiffness(self) -> Law:
        return Law(self.rod.bending_stiffness, STIFFNESS, self.numbers)

    @property
    def _mass_per_length(self) -> Law | None:
        value = self.rod.mass_per_length
        return None if value is None else Law(value, PER_LENGTH, self.numbers, "st")

    @property
    def stiffness(self) -> float | None:
        """Bending stiffness EI [N m^2]; None where it varies along the rod."""
        return self._stiffness.uniform_value

    @property
    def nonuniform(self) -> tuple[str, ...]:
        """Kinds of quantities that vary along the rod, keys of model.rod.NONUNIFORM; that of bodies
        includes the mass of links."""
        differs = self.nonuniform_values
        found = ["stiffness"] if "bending_stiffness" in differs else []
        if self.bodies:
            found.append("points" if self.rod.inertia == "lumped" else "bodies")
        elif "mass_per_length" in differs:
            found.append("mass")
        return tuple(found)

    @property
    def nonuniform_values(self) -> dict[str, Along]:
        """Values in [rod] that vary along the rod, by key."""
        laws = {"bending_stiffness": self._stiffness, "mass_per_length": self._mass_per_length}
        return {key: law.value for key, law in laws.items() if law and law.uniform_value is None}

    @cached_property
    def link_masses(self) -> Array:
        """Mass of every link without bodies [kg], (links,)."""
        rod, per_length = self.rod, self._mass_per_length
        if per_length is None:
            assert rod.mass is not None
            return np.full(rod.links, rod.mass / rod.links)
        l = rod.length / rod.links
        if isinstance(per_length.value, list):
            return l * np.array(per_length.value, dtype=float)
        return l * cell_means(per_length.at(gauss_points(rod.links), self.t))

    @property
    def total_link_mass(self) -> float:
        """Mass of all links without bodies [kg]."""
        return float(self.link_masses.sum()) if self.rod.mass is None else self.rod.mass

    @property
    def mass(self) -> float:
        """Mass of the links and of all bodies [kg]."""
        return self.total_link_mass + sum(self.body_masses)

    @property
    def joint_stiffness(self) -> list[float]:
        """Stiffness of the spring in every joint that has one [N m/rad], from EI; in the root and
        the tail half a link bends."""
        rod, law = self.rod, self._stiffness
        joints, l = rod.boundary_condition.spring_joints(rod.links), rod.length / rod.links
        if isinstance(law.value, list):
            size = {0: rod.boundary_condition.root, rod.links: rod.boundary_condition.tail}
            return [size.get(at, 1) * law.value[at] / l for at in joints]
        with np.errstate(divide="ignore", over="ignore"):
            halves = l / 2 * cell_means(1 / law.at(gauss_points(2 * rod.links)))
            bend = np.concatenate(([0.0], halves[1::2])) + np.concatenate((halves[::2], [0.0]))
            return [float(1 / bend[at]) for at in joints]

    @property
    def mean_stiffness(self) -> float:
        """EI [N m^2]; where it varies along the rod, its mean over the inner joints, or that of the
        root of a single link."""
        rod, even = self.rod, self.stiffness
        if even is not None:
            return even
        joints = zip(
            rod.boundary_condition.spring_joints(rod.links), self.joint_stiffness, strict=True
        )
        inner = [k for at, k in joints if 0 < at < rod.links]
        inner = inner or [k / 2 for k in self.joint_stiffness]  # the root has half a cell
        return rod.length / rod.links * sum(inner) / max(len(inner), 1)

    def link_parameters(self) -> dict[str, list[float]]:
        """Mass, centre and spread of every link with its bodies, by parameter; where masses change
        with time, of the others."""
        rod, left_out = self.rod, {name for name, *_ in self.changing_masses}
        spread = 1 / 4 if rod.inertia == "lumped" else 1 / 12
        parts = [
            [] if "" in left_out else [LinkPart(m, 0.5, 0.0, spread)] for m in self.link_masses
        ]
        for body, (link, part) in zip(self.bodies, self._body_parts, strict=True):
            if body.name not in left_out:
                parts[link].append(part)
        rows = (STEADY[one.name] if left_out else one for one in NONUNIFORM["bodies"].parameters)
        columns = zip(*map(combine, parts), strict=True)
        return dict(zip((one.name for one in rows), map(list, columns), strict=True))

    @property
    def changing_mass_parameters(self) -> dict[str, float]:
        """Numbers in the expressions of masses that are functions of time, and places of bodies."""
        values: dict[str, float] = {}
        names = {name: e for name, _, e in self.changing_masses}
        for name, e in names.items():
            values |= e.with_parameters(mass_name(name))[1]
        for body, (_, part) in zip(self.bodies, self._body_parts, strict=True):
            if body.name in names:
                spread = part.mass * part.spread_along
                found = {"along": part.along, "across": part.across, "spread": spread}
                values |= {f"body_{body.name}_{what}": value for what, value in found.items()}
        return values

    @property
    def _body_parts(self) -> list[tuple[int, LinkPart]]:
        """Link of every body and what it adds there; its inertia is alike in all directions."""
        found, l = [], self.rod.length / self.rod.links
        for body, mass in zip(self.bodies, self.body_masses, strict=True):
            link, share = link_and_share(body.at, self.rod.links)
            # A live run may come to where a tank is empty.
            spread = body.inertia / (2 * mass * l**2) if mass else 0.0
            along, across = share + body.offset[0] / l, body.offset[1] / l
            found.append((link, LinkPart(mass, along, across, spread, spread)))
        return found

    @property
    def body_outlines(self) -> list[BodyOutline]:
        """Bodies, for drawing."""
        mass = self.mass if self.bodies else 1.0
        return [
            BodyOutline(body.name, link, part.along, part.across, (part.mass / mass) ** 0.5)
            for body, (link, part) in zip(self.bodies, self._body_parts, strict=True)
        ]


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
        density = np.broadcast_to(evaluate_mass(mass_name(""), s=gauss_points(n)), (n, GAUSS))
        for link, mass in enumerate(values["length"] / n * cell_means(density)):
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
