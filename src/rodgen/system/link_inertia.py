"""Inertia of a rod where its joints move: links without mass, or with little of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.model.rod import MASS_WAYS
from rodgen.scene.link_parts import link_parameters_at
from rodgen.scene.tables import MASS_KEYS

if TYPE_CHECKING:
    from rodgen.model.rod import Boundary
    from rodgen.scene import Scene
    from rodgen.scene.integration import IntegrationTable
    from rodgen.scene.structure import Structure

# Of the mean inertia of a joint: less makes equations with joint forces lose digits. Up to so many
# links that full matrices do not cost much, and beyond.
LITTLE, MOST_FULL, SCARCE = 1e-3, 200, 1e-7


class RodWithMasses(Protocol):
    """A system, of which the masses are read."""

    structure: Structure
    settings: IntegrationTable

    @property
    def scene(self) -> Scene: ...

    @property
    def parameters(self) -> dict[str, Any]: ...

    @property
    def boundary_condition(self) -> Boundary: ...


def least_inertia(system: RodWithMasses) -> tuple[float, int]:
    """Least inertia by which the equations of motion divide, over that of an even rod, and the
    number of the joint that lacks it.

    With mass along the links, it is the moment of inertia of a link, of which the joint at its end
    is named; with mass at their ends, the mass at a joint.
    """
    masses, centres, spreads = _link_masses(system)
    boundary, mean = system.boundary_condition, masses.mean()
    if system.structure.inertia != "lumped":
        turning = (masses * spreads)[boundary.first :]
        where = int(turning.argmin())
        return float(12 * turning[where] / mean), where + boundary.first + 1
    at_joints = np.append(masses * (1 - centres), 0.0) + np.append(0.0, masses * centres)
    first = 0 if boundary.translates else boundary.first + 1
    where = int(at_joints[first:].argmin())
    return float(at_joints[first:][where] / mean), where + first


def is_light(system: RodWithMasses) -> bool:
    """Whether links have no mass, or so little that joint forces over it lose their digits."""
    masses = _link_masses(system)[0]
    least = min(least_inertia(system)[0], float(masses.min() / masses.mean()))
    return least < (LITTLE if len(masses) <= MOST_FULL else SCARCE)


def _link_masses(system: RodWithMasses) -> tuple[Array, Array, Array]:
    """Mass of every link [kg], its centre along the link, and its mean square distance from the
    point of the link beside that centre, about which it turns, in lengths of the link."""
    structure, links = system.structure, np.ones(system.structure.n_links)
    spread = 1 / 4 if structure.inertia == "lumped" else 1 / 12
    if MASS_WAYS.isdisjoint(structure.nonuniform):
        return links, links / 2, links * spread
    values: dict[str, Any] = system.parameters
    if structure.masses:
        values |= link_parameters_at(structure, values, system.settings.span[0])
    masses = np.asarray(values["link_mass"], dtype=float)
    if "link_centre_along" not in values:
        return masses, links / 2, links * spread
    centres = np.asarray(values["link_centre_along"])
    if "link_spread_along" not in values:  # at both ends of the link
        return masses, centres, centres * (1 - centres)
    along, across = (np.asarray(values[f"link_spread_{way}"]) for way in ("along", "across"))
    return masses, centres, along + across + np.asarray(values["link_centre_across"]) ** 2


def check_masses(system: RodWithMasses) -> None:
    """Raise InputError for a rod that can move without kinetic energy: no run of it exists."""
    if (error := missing_mass(system)) is not None:
        raise error


def missing_mass(system: RodWithMasses) -> InputError | None:
    """Error of a run of a rod that can move without kinetic energy; None for others."""
    least, joint = least_inertia(system)
    if least:
        return None
    rod = system.scene.rod
    key = next(key for key in MASS_KEYS if getattr(rod, key) is not None)
    allowed = f"above 0 for a run: joint {joint} has no mass of its own (modes, critical loads "
    return InputError(f"rod.{key}", getattr(rod, key), f"{allowed}and equilibria need none)")
