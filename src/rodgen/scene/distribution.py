"""Stiffness and mass along a rod, lumped into its joints and links; and links with their bodies.

A joint stands for the rod half a link to either side of it: its spring turns as much as the rod
bends there, 1/k = integral of ds/EI, by five Gauss points over each half. Before a body that
resists turning, the half link at the end of a rod bends as well. A link has the mass that lies on
it, by five Gauss points, and the bodies that are fixed to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.model.rod import (
    BENT_LENGTH,
    JOINT_STIFFNESS,
    LINK_LENGTH,
    NONUNIFORM,
    REST_ANGLE,
    REST_CURVATURE,
    STEADY,
    Boundary,
)
from rodgen.scene.expression import Expression
from rodgen.scene.expression_text import Numbers
from rodgen.scene.law import Along, Law
from rodgen.scene.link_parts import BodyOutline, LinkPart, combine
from rodgen.scene.literals import mass_name
from rodgen.scene.rod_mesh import POINTS, RodMesh, cell_means
from rodgen.scene.structure import Structure
from rodgen.scene.tables import SMALLEST, BodyTable, RodTable

STIFFNESS, PER_LENGTH = "rod.bending_stiffness", "rod.mass_per_length"
CURVATURE = f"rod.{REST_CURVATURE.key}"


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
        mesh, links, per_length = self.mesh, self.rod.links, self._mass_per_length
        self._stiffness.check(mesh, links + 1)
        if self._rest_curvature is not None:
            self._rest_curvature.check(mesh, links + 1, -np.inf)
        if per_length is not None:
            least = SMALLEST if per_length.is_time_dependent else 0.0
            per_length.check(mesh, links, least, span)
        if not self.mass:
            field = "rod.mass" if per_length is None else PER_LENGTH
            value = self.rod.mass if per_length is None else per_length.value
            raise InputError(field, value, "above 0, somewhere, without bodies that have a mass")
        for law in self._body_laws:
            law.check(mesh, 1, SMALLEST, span)

    @cached_property
    def mesh(self) -> RodMesh:
        """Where the joints are."""
        return self.rod.mesh(self.numbers)

    @property
    def changing_masses(self) -> list[tuple[str, int, Expression]]:
        """Masses that are functions of time, with names and links; "" and -1 for those of links."""
        laws = [("", -1, self._mass_per_length)]
        laws += [
            (body.name, self.mesh.link_and_share(body.at)[0], law)
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
    def _rest_curvature(self) -> Law | None:
        value = self.rod.rest_curvature
        return None if value is None else Law(value, CURVATURE, self.numbers)

    @property
    def stiffness(self) -> float | None:
        """Bending stiffness EI [N m^2]; None where it varies along the rod."""
        return self._stiffness.uniform_value

    @property
    def nonuniform(self) -> tuple[str, ...]:
        """Kinds of quantities that vary along the rod, keys of model.rod.NONUNIFORM; that of bodies
        includes the mass of links."""
        differs, found = self.nonuniform_values, list[str]()
        uneven, ends = not self.mesh.is_even, bool(self._bent_ends)
        if "bending_stiffness" in differs or uneven or ends:
            found.append("stiffness")
        if self.bodies:
            found.append("points" if self.rod.inertia == "lumped" else "bodies")
        elif "mass_per_length" in differs or uneven or self.rod.stations is not None:
            found.append("mass")
        found += ["rest"] * (self.rod.rest_curvature is not None)
        found += ["lengths"] if uneven else ["ends"] * ends
        return tuple(found)

    @property
    def nonuniform_values(self) -> dict[str, Along]:
        """Values in [rod] that vary along the rod, by key."""
        laws = {
            "bending_stiffness": self._stiffness,
            "mass_per_length": self._mass_per_length,
            REST_CURVATURE.key: self._rest_curvature,
        }
        return {key: law.value for key, law in laws.items() if law and law.uniform_value is None}

    @cached_property
    def link_masses(self) -> Array:
        """Mass of every link without bodies [kg], (links,)."""
        rod, per_length = self.rod, self._mass_per_length
        if rod.stations is not None:
            ends, masses = _spread_stations(rod.stations, rod.length)
            return np.diff(np.interp(rod.length * self.mesh.places, ends, np.cumsum(masses)))
        if per_length is None:
            assert rod.mass is not None
            return self.mesh.lengths(rod.mass)
        lengths = self.mesh.lengths(rod.length)
        return np.asarray(lengths * per_length.link_values(self.mesh, self.t))

    @property
    def total_link_mass(self) -> float:
        """Mass of all links without bodies [kg]."""
        if self.rod.stations is not None:
            return math.fsum(mass for _, mass in self.rod.stations)
        return float(self.link_masses.sum()) if self.rod.mass is None else self.rod.mass

    @property
    def unit_mass(self) -> float:
        """Mass of all links or, where they have none, of the bodies [kg]: a module counts joint
        forces by its share of a link."""
        return self.total_link_mass or self.mass

    @property
    def mass(self) -> float:
        """Mass of the links and of all bodies [kg]."""
        return self.total_link_mass + sum(self.body_masses)

    @property
    def joint_stiffness(self) -> list[float]:
        """Stiffness of the spring in every joint that has one [N m/rad], from EI; in the root and
        the tail half a link bends."""
        law, joints = self._stiffness, self._spring_joints
        if isinstance(law.value, list):
            return [law.value[at] / self._cell_lengths[at] for at in joints]
        with np.errstate(divide="ignore", over="ignore"):
            bend = self._integrals(lambda s: 1 / law.at(s))
            return [float(1 / bend[at]) for at in joints]

    @property
    def _spring_joints(self) -> range:
        """Joints with a spring."""
        return self.rod.boundary_condition.spring_joints(self.rod.links)

    @cached_property
    def _bent_ends(self) -> list[tuple[int, float, float]]:
        """Parts of the first and the last link that bend in the joint at its other end, beside the
        half that always does: from its middle to a body there that resists turning. Of each the
        joint, and both ends as numbers of the mesh."""
        boundary, joints = self.rod.boundary_condition, self._spring_joints
        last = self.rod.links - 1
        turning = [body for body in self.bodies if body.inertia or any(body.offset)]
        places = [self.mesh.link_and_share(body.at) for body in turning]
        found = []
        start = min((share for link, share in places if link == 0), default=0.5)
        if start < 0.5 and 1 in joints and not boundary.root and not boundary.first:
            found.append((1, start, 0.5))
        end = max((share for link, share in places if link == last), default=0.5)
        if end > 0.5 and last in joints and not boundary.tail:
            found.append((last, last + 0.5, last + end))
        return found

    @cached_property
    def _cell_lengths(self) -> Array:
        """Length of the rod that bends in every joint [m], (links + 1,)."""
        found = self.mesh.lengths_at_joints(self.rod.length)
        for joint, *ends in self._bent_ends:
            found[joint] += self.rod.length * np.ptp(self.mesh.at(ends))
        return found

    def _integrals(self, of: Callable[[Array], Array]) -> Array:
        """Integrals of a function of s over the rod that bends in every joint, (links + 1,)."""
        mesh, lengths = self.mesh, self.mesh.lengths(self.rod.length)
        halves = np.repeat(lengths / 2, 2) * cell_means(of(mesh.gauss_points_of_halves()))
        found = np.concatenate(([0.0], halves[1::2])) + np.concatenate((halves[::2], [0.0]))
        for joint, *ends in self._bent_ends:
            low, high = mesh.at(ends)
            mean = cell_means(of(low + (high - low) * POINTS))
            found[joint] += self.rod.length * (high - low) * mean
        return found

    @property
    def joint_parameters(self) -> dict[str, list[float]]:
        """Numbers of the joints with a spring, by parameter, where they differ."""
        found: dict[str, list[float]] = {}
        if "stiffness" in self.nonuniform:
            found[JOINT_STIFFNESS.name] = self.joint_stiffness
        if not {"lengths", "ends"}.isdisjoint(self.nonuniform):
            found[BENT_LENGTH.name] = [float(self._cell_lengths[at]) for at in self._spring_joints]
        if self.rod.rest_curvature is not None:
            found[REST_ANGLE.name] = self.rest_angles
        return found

    @property
    def rest_angles(self) -> list[float]:
        """Rest angle of the spring in every joint that has one [rad]: the integral of the rest
        curvature over the rod between the middles of the links, from the clamp on."""
        law, first = self._rest_curvature, self.rod.boundary_condition.first
        if law is None:
            return [0.0] * len(self._spring_joints)
        if isinstance(law.value, list):
            turned = self._cell_lengths * law.value
        else:
            turned = self._integrals(law.at)
        if first:  # a held link bends in the joint that ends it
            turned[first] = turned[: first + 1].sum()
        return [float(turned[at]) for at in self._spring_joints]

    @property
    def rest_shape(self) -> Array:
        """Angles of all links at rest (links,) [rad], over that of the clamp or, without one, of
        link 0."""
        return rest_shape(self.rod.boundary_condition, self.rod.links, self.rest_angles)

    @property
    def mean_stiffness(self) -> float:
        """EI [N m^2]; where it varies along the rod, its mean over the inner joints, or that of the
        root of a single link."""
        if (even := self.stiffness) is not None:
            return even
        joints = list(zip(self._spring_joints, self.joint_stiffness, strict=True))
        inner = [(at, k) for at, k in joints if 0 < at < self.rod.links] or joints
        return float(sum(self._cell_lengths[at] * k for at, k in inner) / max(len(inner), 1))

    def link_parameters(self) -> dict[str, list[float]]:
        """Length of every link, and its mass, centre and spread with its bodies, by parameter; of
        masses that do not change with time, where some do."""
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
        found = dict(zip((one.name for one in rows), map(list, columns), strict=True))
        return found | {LINK_LENGTH.name: self.mesh.lengths(rod.length).tolist()}

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
        found, lengths = [], self.mesh.lengths(self.rod.length)
        for body, mass in zip(self.bodies, self.body_masses, strict=True):
            link, share = self.mesh.link_and_share(body.at)
            l = lengths[link]
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


def _spread_stations(stations: Sequence[Sequence[float]], length: float) -> tuple[Array, Array]:
    """Ends of the parts of a rod [m] over which its stations are spread, from 0 to its length, with
    the masses of the parts before them [kg]."""
    places, masses = np.array(stations, dtype=float).T
    ends = np.concatenate(([0.0], (places[1:] + places[:-1]) / 2, [length]))
    return ends, np.concatenate(([0.0], masses))


def rest_shape(boundary: Boundary, links: int, rest_angles: ArrayLike) -> Array:
    """Angles of all links (..., links) [rad] over that of the clamp or, without one, of link 0,
    where every joint with a spring opens by its rest angle (..., springs)."""
    angles = np.asarray(rest_angles, float)
    bends = np.zeros((*angles.shape[:-1], links + 1))
    bends[..., boundary.spring_joints(links)] = angles
    turned: Array = np.cumsum(bends[..., :-1], axis=-1)
    return turned


def shape_without_load(structure: Structure, p: Array) -> Array:
    """Angles of the moving links (..., links) [rad] of the rod without load, over that of the clamp
    or, without one, of link 0. p: parameters (..., width)."""
    place = structure.slices.get(REST_ANGLE.name)
    boundary = structure.boundary_condition
    if place is None:
        return np.zeros((*p.shape[:-1], structure.n_links - boundary.first))
    return rest_shape(boundary, structure.n_links, p[..., place])[..., boundary.first :]
