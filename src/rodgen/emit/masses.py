"""Code of numbers that are functions of time beside loads: masses of bodies, derivatives of what
moves the base, and masses of links in a function of their own, by Gauss points; likewise of loads
that are functions of time and place."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.derive.base_motion import ORDERS
from rodgen.scene.grammar import Language
from rodgen.scene.literals import mass_name
from rodgen.scene.rod_mesh import POINTS, WEIGHTS
from rodgen.scene.structure import Structure

OWN, RATE = "own_mass", "_rate"
WEIGHT = {"np.": "_weight", "": "weight"}  # a mass that is above zero, by the prefix of a language
WORDS = {OWN: "Mass of every link [kg]", OWN + RATE: "What every link gains of mass [kg/s]"}
# Functions of a module that need the time where masses are functions of it, and those that do as
# well where the base is moved.
IN_TIME = (
    *("mass_matrix", "energy", "centre_of_gravity", "inertia"),
    *("momentum", "angular_momentum"),
)
IN_TIME_AS_WELL = "joints", "velocities", "bending_moments", "support_forces", "curvatures"


def functions_in_time(structure: Structure) -> tuple[str, ...]:
    """Names of the functions of a module that ask for the time beside the state."""
    if structure.has_moving_base:
        return (*IN_TIME, *IN_TIME_AS_WELL)
    return IN_TIME if structure.masses else ()


@dataclass(frozen=True)
class Masses:
    """The masses of a structure that are functions of time."""

    structure: Structure

    def number_codes(self, language: Language, start: str = "", clock: str = "t") -> dict[str, str]:
        """Code of masses of bodies and of their rates, and of the derivatives of what moves the
        base, by name; start: of p; clock: of the time."""
        return self._body_codes(language, start, clock) | self._base_codes(language, start, clock)

    def _base_codes(self, language: Language, start: str, clock: str) -> dict[str, str]:
        of = self.structure
        found = dict[str, str]()
        for name in of.base_parameters:
            e = of.open_expressions.get(name)
            for order, word in enumerate(ORDERS[1:], start=1):
                given = "t", language, of.slices, start, {"t": clock}, order
                code = e.derivative_source(*given) if e else "0.0"
                # Of NumPy, a number of which there may be many: one that takes an axis.
                plain = language.prefix and re.fullmatch(r"[\d.e+-]+", code)
                found[f"{name}{word}"] = f"np.float64({code})" if plain else code
        return found

    def _body_codes(self, language: Language, start: str, clock: str) -> dict[str, str]:
        masses = self.structure.open_masses.items()
        bodies = {name: e for name, e in masses if name != mass_name("")}
        places, found = self.structure.slices, dict[str, str]()
        for name, e in bodies.items():
            at = {"t": clock}
            found[name] = f"{WEIGHT[language.prefix]}({e.source(language, places, start, at)})"
            found[name + RATE] = e.derivative_source("t", language, places, start, at)
        return found

    def link_codes(self, language: Language) -> dict[str, str]:
        """Code of the mass per length, its rate and loads at s, by the names of what links have."""
        place, places = {"s": "s"}, self.structure.slices
        loads = self.structure.open_along.items()
        found = {name: e.source(language, places, "", place) for name, e in loads}
        e = self.structure.open_masses.get(mass_name(""))
        if e is not None:
            found[OWN] = e.source(language, places, "", place)
            found[OWN + RATE] = e.derivative_source("t", language, places, "", place)
        return found

    def context(self, language: Language) -> dict[str, Any]:
        """Template context of masses, and of loads along the rod."""
        numbers, links = self.number_codes(language), self.link_codes(language)
        return {
            "timed_numbers": numbers,
            "link_masses": links,
            "clocked": [*numbers, *links],
            "link_words": {
                name: WORDS.get(name, f"Mean of {name} over every link") for name in links
            },
            "own_masses": [name for name in links if name in WORDS],
            "gauss": np.stack((POINTS, WEIGHTS), axis=1).tolist(),
            "masses": self.structure.masses,
        }
