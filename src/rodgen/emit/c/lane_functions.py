"""Functions of the C target for rods side by side, each at its own time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rodgen.emit.c.loop_writer import SCENE, Code, LoopWriter
from rodgen.emit.masses import Masses
from rodgen.emit.outputs import Functions
from rodgen.emit.statements import Domain, Outputs

# How the time, and where in p the parameters of a rod begin, are written for rods side by side.
CLOCK, BY_ROD = "t[w]", "w * stride + "
SIDE_BY_SIDE = "lanes", "observed"
# What is observed, by the names that its numbers have everywhere.
OBSERVED = {
    "kinetic": "kinetic_energy",
    "spring": "spring_energy",
    "load_energy": "gravity_energy",
    "joint_x": "joint_{}_x",
    "joint_y": "joint_{}_y",
    "centre_x": "centre_of_gravity_x",
    "centre_y": "centre_of_gravity_y",
    "bending": "bending_moment_{}",
}


def lane_codes(
    functions: Functions, links: Mapping[str, Domain], solved: Mapping[str, Domain]
) -> dict[str, Code]:
    """Code of rates and powers, and of observed quantities; links: arrays that are given, with a
    number for every link; solved: arrays that the solution fills."""
    given = functions.parameter_domains | dict(links)
    rates = functions.chain_outputs | functions.power
    system = [*functions.matrix, *functions.right]
    return {
        "lanes": _code(functions, rates, given | dict(solved), system),
        "observed": _code(functions, _observed_outputs(functions), given, []),
    }


def _code(
    functions: Functions, outputs: Outputs, given: Mapping[str, Domain], system: list[str]
) -> Code:
    program = functions.compiler.analyse(outputs)
    phases = program.phases[:2]
    return LoopWriter(
        program.analysis, phases, given, lambda _: True, outputs, system=system, clock=CLOCK
    ).write()


def lane_context(functions: Functions) -> dict[str, Any]:
    """Template context of lanes: observed quantities, and code of loads in time."""
    structure, masses = functions.structure, Masses(functions.structure)
    timed = {
        name: e.source(SCENE, structure.slices, BY_ROD, {"t": CLOCK})
        for name, e in structure.open_expressions.items()
        if not e.signals
    }
    return {
        "timed_in_lanes": timed | masses.number_codes(SCENE, BY_ROD, CLOCK),
        "observed": _observed_places(functions),
        "observed_names": _observed_names(functions),
    }


def _observed_outputs(functions: Functions) -> Outputs:
    return {name: of for group in functions.observables.values() for name, of in group.items()}


def _observed_places(functions: Functions) -> list[tuple[str, int, int]]:
    """Names of observed quantities, their places among all numbers and lengths, 0 for a number."""
    found, at = [], 0
    for name, (domain, _) in _observed_outputs(functions).items():
        count = domain.count if domain.along else 0
        found.append((name, at, count))
        at += count or 1
    return found


def _observed_names(functions: Functions) -> list[str]:
    """Names of all numbers that are observed, in their order."""
    places = _observed_places(functions)
    return [OBSERVED[name].format(at) for name, _, count in places for at in range(count or 1)]
