"""What differs along a rod, from a scene to numbers of its joints and links.

A joint stands for the rod half a link to either side of it: its spring turns as much as the rod
bends there, 1/k = integral of ds/EI, by five Gauss points over each half. A link has the mass that
lies on it, by five Gauss points, and the bodies that are fixed to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rodgen.arrays import Array
from rodgen.model.rod import STEADY, UNEVEN
from rodgen.scene.expression import Expression, Numbers
from rodgen.scene.law import Along, Law, means, points
from rodgen.scene.link_parts import Part, together
from rodgen.scene.numbers import mass_of
from rodgen.scene.places import point_of
from rodgen.scene.tables import SMALLEST, Body, Rod

STIFFNESS, PER_LENGTH = "rod.bending_stiffness", "rod.mass_per_length"


@dataclass(frozen=True)
class Distribution:
    """How stiffness and mass lie along a rod with its bodies; numbers: those that expressions call
    by names; t: the time whose masses are taken."""

    rod: Rod
    bodies: Sequence[Body] = ()
    numbers: Numbers = ()
    t: float = 0.0

    def check(self, span: Sequence[float]) -> None:
        """Raise InputError for what no rod can be like at some time of the span."""
        links, per_length = self.rod.links, self._per_length
        self._stiffness.check(links, links + 1)
        if per_length is not None:
            per_length.check(links, links, SMALLEST, span)
        for law in self._body_laws:
            law.check(links, 1, SMALLEST, span)

    @property
    def changing(self) -> list[tuple[str, int, Expression]]:
        """The masses that are functions of time: of the links, "" and -1, and of bodies, by their
        names and links."""
        laws = [("", -1, self._per_length)]
        laws += [
            (body.name, point_of(body.at, self.rod.links)[0], law)
            for body, law in zip(self.bodies, self._body_laws, strict=True)
        ]
        return [(name, link, law.expression) for name, link, law in laws if law and law.changes]

    @property
    def _body_laws(self) -> list[Law]:
        fields = (f"bodies[{at}].mass" for at in range(len(self.bodies)))
        pairs = zip(self.bodies, fields, strict=True)
        return [Law(body.mass, field, self.numbers, "t") for body, field in pairs]

    @property
    def body_mass(self) -> list[float]:
        """Mass of every body [kg]."""
        return [float(law.at(np.zeros(1), self.t)[0]) for law in self._body_laws]

    @property
    def _stiffness(self) -> Law:
        return Law(self.rod.bending_stiffness, STIFFNESS, self.numbers)

    @property
    def _per_length(self) -> Law | None:
        value = self.rod.mass_per_length
        return None if value is None else Law(value, PER_LENGTH, self.numbers, "st")

    @property
    def stiffness(self) -> float | None:
        """EI all along the rod [N m^2]; None where it differs."""
        return self._stiffness.even

    @property
    def uneven(self) -> tuple[str, ...]:
        """What differs along the rod, of model.rod.UNEVEN; bodies say more than the mass of
        links."""
        differs = self.differing
        found = ["stiffness"] if "bending_stiffness" in differs else []
        if self.bodies:
            found.append("points" if self.rod.inertia == "lumped" else "bodies")
        elif "mass_per_length" in differs:
            found.append("mass")
        return tuple(found)

    @property
    def differing(self) -> dict[str, Along]:
        """What differs along the rod, by its key."""
        laws = {"bending_stiffness": self._stiffness, "mass_per_length": self._per_length}
        return {key: law.value for key, law in laws.items() if law and law.even is None}

    @cached_property
    def links(self) -> Array:
        """Mass of every link without bodies [kg], (links,)."""
        rod, per_length = self.rod, self._per_length
        if per_length is None:
            assert rod.mass is not None
            return np.full(rod.links, rod.mass / rod.links)
        l = rod.length / rod.links
        if isinstance(per_length.value, list):
            return l * np.array(per_length.value, dtype=float)
        return l * means(per_length.at(points(rod.links), self.t))

    @property
    def links_mass(self) -> float:
        """Mass of all links without bodies [kg]."""
        return float(self.links.sum()) if self.rod.mass is None else self.rod.mass

    @property
    def mass(self) -> float:
        """Mass of the links and of all bodies [kg]."""
        return self.links_mass + sum(self.body_mass)

    @property
    def joint_stiffness(self) -> list[float]:
        """Stiffness of the spring in every joint that has one [N m/rad], from EI; in the root and
        the tail half a link bends."""
        rod, law = self.rod, self._stiffness
        joints, l = rod.hold.springs(rod.links), rod.length / rod.links
        if isinstance(law.value, list):
            size = {0: rod.hold.root, rod.links: rod.hold.tail}
            return [size.get(at, 1) * law.value[at] / l for at in joints]
        with np.errstate(divide="ignore", over="ignore"):
            halves = l / 2 * means(1 / law.at(points(2 * rod.links)))
            bend = np.concatenate(([0.0], halves[1::2])) + np.concatenate((halves[::2], [0.0]))
            return [float(1 / bend[at]) for at in joints]

    @property
    def usual_stiffness(self) -> float:
        """EI [N m^2]; of a rod along which it differs, its mean over the inner joints, of a single
        link that in the root."""
        rod, even = self.rod, self.stiffness
        if even is not None:
            return even
        joints = zip(rod.hold.springs(rod.links), self.joint_stiffness, strict=True)
        inner = [k for at, k in joints if 0 < at < rod.links]
        inner = inner or [k / 2 for k in self.joint_stiffness]  # the root has half a cell
        return rod.length / rod.links * sum(inner) / max(len(inner), 1)

    def of_links(self, steady: bool = False) -> dict[str, list[float]]:
        """Mass of every link with its bodies, its centre and its spread, by parameter; steady: of
        what does not change with time alone."""
        rod = self.rod
        left_out = {name for name, *_ in self.changing} if steady else set()
        spread = 1 / 4 if rod.inertia == "lumped" else 1 / 12
        parts = [[] if "" in left_out else [Part(m, 0.5, 0.0, spread)] for m in self.links]
        for body, (link, part) in zip(self.bodies, self._parts, strict=True):
            if body.name not in left_out:
                parts[link].append(part)
        rows = (STEADY[one.name] if steady else one for one in UNEVEN["bodies"].parameters)
        columns = zip(*map(together, parts), strict=True)
        return dict(zip((one.name for one in rows), map(list, columns), strict=True))

    @property
    def numbers_of_changing(self) -> dict[str, float]:
        """What a module asks of masses that are functions of time: the numbers in their
        expressions, and where bodies sit."""
        values: dict[str, float] = {}
        names = {name: e for name, _, e in self.changing}
        for name, e in names.items():
            values |= e.parametrised(mass_of(name))[1]
        for body, (_, part) in zip(self.bodies, self._parts, strict=True):
            if body.name in names:
                spread = part.mass * part.spread_along
                found = {"along": part.along, "across": part.across, "spread": spread}
                values |= {f"body_{body.name}_{what}": value for what, value in found.items()}
        return values

    @property
    def _parts(self) -> list[tuple[int, Part]]:
        """The links of bodies and what these add to them; their inertia alike in all directions."""
        found, l = [], self.rod.length / self.rod.links
        for body, mass in zip(self.bodies, self.body_mass, strict=True):
            link, share = point_of(body.at, self.rod.links)
            # A live run may come to where a tank is empty.
            spread = body.inertia / (2 * mass * l**2) if mass else 0.0
            along, across = share + body.offset[0] / l, body.offset[1] / l
            found.append((link, Part(mass, along, across, spread, spread)))
        return found

    @property
    def marks(self) -> list[Mark]:
        """Bodies as they are drawn."""
        mass = self.mass if self.bodies else 1.0
        return [
            Mark(body.name, link, part.along, part.across, (part.mass / mass) ** 0.5)
            for body, (link, part) in zip(self.bodies, self._parts, strict=True)
        ]


@dataclass(frozen=True)
class Mark:
    """A body as it is drawn: its name, its link, the place of its centre along and across that,
    over its length, and its size, the root of its share in the mass of the whole."""

    name: str
    link: int
    along: float
    across: float
    size: float

    def places(self, joints: Array) -> Array:
        """Where it is, (..., 2), for joints at (..., links + 1, 2)."""
        start, end = joints[..., self.link, :], joints[..., self.link + 1, :]
        x, y = np.moveaxis(end - start, -1, 0)
        found: Array = start + self.along * (end - start) + self.across * np.stack((-y, x), -1)
        return found
