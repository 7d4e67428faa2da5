"""What the module of a scene holds, piece by piece, with the reason."""

from __future__ import annotations

from dataclasses import dataclass

from rodgen.scene.scene import Scene
from rodgen.scene.structure import TERM_PARAMETERS, TERMS
from rodgen.scene.tables import PLACES, TABLES


@dataclass(frozen=True)
class Piece:
    """A piece of the model: whether the module has it, and why."""

    piece: str
    present: bool
    reason: str


ROOTLESS = "no spring at joint 0"
MASSES = {
    "uniform": "inertia uniform: mass spread along each link",
    "lumped": "inertia lumped: massless links, m at inner joints, m/2 at joints 0 and n",
}


def contents(scene: Scene) -> list[Piece]:
    """All pieces that a module can have, for this scene."""
    rod, held = scene.rod, scene.held
    moving = rod.links - held
    free = scene.hold.translates
    pieces = [
        Piece(
            "translation x0, y0",
            free,
            "boundary free" if free else f"boundary {rod.boundary}: joint 0 is fixed",
        ),
        Piece(
            f"{moving} moving link{'s' * (moving > 1)}",
            True,
            f"links {held} to {rod.links - 1}"
            + ("; link 0 is held at clamp_angle" if held else ""),
        ),
        Piece(
            "coupling of links in M and Q",
            moving > 1,
            "every pair of moving links" if moving > 1 else "a single link moves",
        ),
        Piece(
            "rotary springs",
            rod.links > 1,
            f"{rod.links - 1} inner joints" if rod.links > 1 else "one link has no inner joint",
        ),
        Piece(
            "root spring",
            scene.hold.root_spring,
            f"boundary {rod.boundary}: "
            + ("2 EI/l at joint 0, against clamp_angle" if scene.hold.root_spring else ROOTLESS),
        ),
        Piece("rotary inertia of links", rod.inertia == "uniform", MASSES[rod.inertia]),
    ]
    return pieces + [_term(scene, term) for term in TERMS]


def _term(scene: Scene, term: str) -> Piece:
    name, table = term.replace("_", " "), f"table [loads.{TABLES[term]}]"
    if term not in scene.structure.terms:
        return Piece(name, False, f"no {table}")
    if term == "internal_damping" and scene.rod.links == 1 and not scene.hold.root_spring:
        return Piece(name, False, "one link has no inner joint; the parameter is taken, not used")
    timed = scene.timed
    functions = [
        f"{PLACES[known][1]} is a function of t, part of the code: {timed[known].canonical}"
        for known in TERM_PARAMETERS[term]
        if known in timed
    ]
    return Piece(name, True, "; ".join(functions) or table)
