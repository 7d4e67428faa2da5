"""What the module of a scene holds, piece by piece, with the reason."""

from __future__ import annotations

from dataclasses import dataclass

from rodgen.scene.scene import Scene
from rodgen.scene.structure import TERMS


@dataclass(frozen=True)
class Piece:
    """A piece of the model: whether the module has it, and why."""

    piece: str
    present: bool
    reason: str


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
    ]
    return pieces + [_term(scene, term) for term in TERMS]


def _term(scene: Scene, term: str) -> Piece:
    name = term.replace("_", " ")
    if getattr(scene.loads, term) is None:
        return Piece(name, False, f"no table [loads.{term}]")
    if term == "internal_damping" and scene.rod.links == 1:
        return Piece(name, False, "one link has no inner joint; the parameter is taken, not used")
    known = dict(scene.structure.expressions)
    if term == "follower" and "follower_force" in known:
        return Piece(
            name, True, f"force is a function of t, part of the code: {known['follower_force']}"
        )
    return Piece(name, True, f"table [loads.{term}]")
