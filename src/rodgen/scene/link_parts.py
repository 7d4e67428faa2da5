"""What lies on one link: its own mass and the bodies fixed to it, as one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.model.rod import STEADY, TANK, UNEVEN
from rodgen.scene.law import GAUSS, means, points
from rodgen.scene.numbers import mass_of
from rodgen.scene.structure import Structure

STEADY_NAMES = {one.name for one in STEADY.values()}


@dataclass(frozen=True)
class Part:
    """A mass [kg] at a place along a link and across it, and its mean squares about that, all over
    the length of the link."""

    mass: float
    along: float
    across: float = 0.0
    spread_along: float = 0.0
    spread_across: float = 0.0
    spread_mixed: float = 0.0


def together(parts: Sequence[Part]) -> tuple[float, ...]:
    """Parts of a link as one: mass, centre along and across, mean squares along and across and
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


def present(
    structure: Structure, values: Mapping[str, Any], t: float, rates: bool = False
) -> dict[str, list[float]]:
    """What the parameters of links are at a time, by those of a module with masses that are
    functions of it; rates: of the masses that they gain in a second instead."""
    n, lumped = structure.links, structure.inertia == "lumped"
    masses = {name: e.with_values(values) for name, e in structure.open_masses.items()}

    def at(name: str, **places: Array) -> Any:
        return masses[name].slope(t, places) if rates else masses[name].value(t, places)

    parts: list[list[Part]] = [[] for _ in range(n)]
    if "steady_mass" in values and not rates:
        columns = (values[name] for name in structure.spans if name in STEADY_NAMES)
        for link, row in enumerate(zip(*columns, strict=True)):
            parts[link].append(Part(*row))
    if mass_of("") in masses:
        density = np.broadcast_to(at(mass_of(""), s=points(n)), (n, GAUSS))
        for link, mass in enumerate(values["length"] / n * means(density)):
            parts[link].append(Part(mass, 0.5, 0.0, 1 / 4 if lumped else 1 / 12))
    for name, link in structure.tanks.items():
        along, across, spread = (values[f"{name}_{what}"] for what in TANK)
        mass = float(at(f"{name}_mass"))
        own = 0.0 if rates else spread / mass
        parts[link].append(Part(mass, along, across, own, own))
    names = [one.name for one in UNEVEN["bodies"].parameters]
    known = {one.name for what in structure.uneven for one in UNEVEN[what].parameters}
    found = zip(names, zip(*map(together, parts), strict=True), strict=True)
    return {name: list(column) for name, column in found if name in known}
