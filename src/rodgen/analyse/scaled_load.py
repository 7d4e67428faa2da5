"""Numbers that an analysis varies: the load whose size is sought at an onset, its parameters and
units; and a rod as a function of one parameter, a number of its scene or the share of its loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rodgen.analyse.steady_rod import SteadyRod
from rodgen.errors import InputError, Missing
from rodgen.model.term import COUPLE, WEIGHT, Term
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.system import ParameterLine, ParameterRange, System
from rodgen.system.freezing import base_acceleration

FOLLOWER, FOLLOWERS, ALL = "follower", "followers", "all"
# Several loads that are scaled by one factor.
GROUPS = {FOLLOWERS: "factor of all follower forces", ALL: "factor of all loads"}
# What a critical load is asked for by: the table of a load, of several the name, or a group.
SCALABLE = (*(term.table for term in TERMS.values() if term.size_parameters), *GROUPS)

LOADS = "loads.", "foundation.", "supports.", "rod.bending_stiffness"


def find_term(load: str) -> Term | None:
    """Look up a load by name; None for a group. Raises InputError for one that cannot be scaled."""
    if load in GROUPS:
        return None
    tables = {term.table: term for term in TERMS.values()}
    term = TERMS[load] if load in TERMS else tables.get(load)
    if term is None or not term.size_parameters:
        raise InputError("load", load, f"one of {', '.join(SCALABLE)}")
    return term


def unit_of(load: str) -> str:
    """Unit of the size of a load."""
    term = find_term(load)
    return (
        "times the loads"
        if term is None
        else "N"
        if term.is_distributed
        else term.size_parameters[0].unit
    )


def label_of(load: str) -> str:
    """Label of a load, or of a group."""
    term = find_term(load)
    return GROUPS[load] if term is None else term.label


def symbol_of(load: str) -> str:
    """Symbol of the load parameter, such as P L^2/EI, or the label of a group."""
    term = find_term(load)
    if term is None:
        return GROUPS[load]
    return f"{term.symbol} {'L' if term.kind == COUPLE else 'L^2'}/EI"


def default_load(system: System) -> str:
    """Name of the first load of a system that follows the rod; the follower force without one."""
    return next((name for name in system.load_terms if TERMS[name].follows), FOLLOWER)


@dataclass(frozen=True)
class ScaledLoad:
    """A load with one variable size. parts: its parameters at the size one; unit: a typical size,
    by which a search steps; reference: the size whose multiple is the factor of a critical load;
    applied: the size that the scene itself has."""

    name: str
    parts: dict[str, Any]
    unit: float
    reference: float
    applied: float

    @classmethod
    def of(cls, name: str, rod: SteadyRod) -> ScaledLoad:
        """Set up a load of a rod. One with a single size, such as a follower force [N] or gravity
        [m/s^2], may have any size in the scene; one of several components, such as a dead force
        [N] or a vector of gravity, keeps the scene's direction; one with a number for every link
        becomes a force [N] on the whole rod, distributed as in the scene; a group becomes a
        multiple of the scene's loads. Raises InputError for a load that the scene lacks."""
        scene, term = rod.scene, find_term(name)
        along = scene.distribution
        if along.mean_stiffness == 0:
            raise InputError("rod.bending_stiffness", 0.0, "positive: a chain bears no thrust")
        if scene.has_no_tangent_stiffness:
            allowed = "of a slope above 0 at d = 0: a straight rod bears no thrust"
            raise InputError("rod.spring", scene.rod.spring, allowed)
        every = [scene.structure.load_rows[one] for one in scene.loads.terms]
        terms = [row for row in every if row.name == term.name] if term else every
        if name == FOLLOWERS:
            terms = [row for row in every if row.follows]
        _check_base_is_even(rod, terms)
        laws = rod.system.expressions
        here: dict[str, tuple[Any, float]] = {}
        for row in terms:
            for one in (part.name for part in row.size_parameters):
                if one in laws and laws[one].signals:
                    allowed = "a number or an expression in t, to be scaled with others"
                    raise InputError(rod.system.key_of(one), laws[one].text, allowed)
                here[one] = np.asarray(rod.system.parameter(one)), _force_per_size(row, scene)
        place = f"loads.{name}" if term else "loads"
        if not here:
            found = ", ".join((*(row.name for row in every if row.size_parameters), *GROUPS))
            raise InputError(place, Missing(), f"given: its size is asked for (there is {found})")
        force = along.mean_stiffness / scene.rod.length**2
        per_size = _force_per_size(term, scene) if term and not term.is_distributed else 1.0
        unit = force / per_size
        if term and terms[0].has_size:
            (own,) = (float(value) for value, _ in here.values())
            return cls(name, dict.fromkeys(here, 1.0), unit, unit, own)
        forces = [np.abs(value).sum() * per_size for value, per_size in here.values()]
        if not any(forces):
            raise InputError(place, 0.0, "not zero: its direction is that of the scene")
        parts = {key: value for key, (value, _) in here.items()}
        if term:
            size = float(np.hypot.reduce(forces)) / per_size
            parts = {key: value / size for key, value in parts.items()}
            return cls(name, parts, unit, unit, size)
        return cls(name, parts, force / float(sum(forces)), 1.0, 1.0)


def _check_base_is_even(rod: SteadyRod, terms: Sequence[Term]) -> None:
    """Raise InputError for a gravity that is to be scaled, where the acceleration of the base is
    part of it: that of a frame does not grow with gravity."""
    source = rod.system.source
    if any(row.kind == WEIGHT for row in terms) and any(base_acceleration(source, rod.t)):
        assert source.base is not None
        allowed = "without acceleration then, where gravity is scaled: that of a frame is not"
        raise InputError("base", source.base.model_dump(exclude_none=True), allowed)


def _force_per_size(term: Term, scene: Scene) -> float:
    """Force [N] of a load of size one on the rod, or on a link of it."""
    if term.is_distributed:
        return scene.rod.length / scene.rod.links
    if term.kind == COUPLE:
        return 1 / scene.rod.length  # of a pair of forces, a length of the rod apart
    return scene.mass if term.kind == WEIGHT else 1.0


@dataclass(frozen=True)
class RodRange:
    """Rod along a range of numbers; base: at one of the values, or under all of its loads."""

    base: SteadyRod
    numbers: ParameterRange | ParameterLine

    @classmethod
    def of_load(cls, rod: SteadyRod) -> RodRange:
        """Range of the share of its loads that a rod bears, from none to all."""
        system = rod.system
        terms = [TERMS[name] for name in system.structure.loads]
        names = {one.name for term in terms for one in term.scaling_parameters}
        parts = {name: system.parameter(name) for name in names & system.structure.slices.keys()}
        return cls(rod, ParameterLine.of(system, parts))

    def rod(self, value: float) -> SteadyRod:
        """Rod at a value. Raises AnalysisError where there is none."""
        numbers = self.numbers
        if isinstance(numbers, ParameterLine):
            return self.base
        if numbers.affects_only_p and numbers.key.startswith(LOADS):
            return self.base  # its straight shape, and all else that is not in p, stays
        return replace(self.base, system=numbers.at(value))
