"""A scene with other links, another boundary or other terms: what no longer fits is left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rodgen.scene import Scene
from rodgen.scene.structure import BOUNDARIES, BOUNDARY_PARAMETERS, TERMS
from rodgen.scene.tables import TABLES

# What a load begins with that the scene did not have.
FIRST: dict[str, dict[str, Any]] = {
    "follower": {"force": 0.0},
    "gravity": {"g": 9.81},
    "internal_damping": {"coefficient": 0.01},
    "external_damping": {"coefficient": 0.5},
    "tip_load": {"x": 0.0, "y": -1.0},
}


@dataclass(frozen=True)
class Form:
    """What the module of a scene is specialised to, as a user chooses it; terms: of TERMS."""

    links: int
    boundary: str
    inertia: str
    terms: tuple[str, ...]


def form_of(scene: Scene) -> Form:
    """That of a scene."""
    rod = scene.rod
    return Form(rod.links, rod.boundary, rod.inertia, scene.loads.terms)


def restructured(scene: Scene, form: Form, initial: dict[str, Any]) -> Scene:
    """The scene in another form, with other initial values (None: left out). Raises SceneError.

    Left out are values that the form has no place for: the clamp's angle, the position of a rod
    that is held, lists of as many values as the links were.
    """
    table = scene.model_dump(exclude_none=True)
    rod, loads = table["rod"], table["loads"]
    rod |= {"links": form.links, "boundary": form.boundary, "inertia": form.inertia}
    if "clamp_angle" not in BOUNDARY_PARAMETERS.get(form.boundary, ("clamp_angle",)):
        rod.pop("clamp_angle", None)
    for term in TERMS:
        if term not in form.terms:
            loads.pop(TABLES[term], None)
        elif TABLES[term] not in loads:
            loads[TABLES[term]] = dict(FIRST[term])
    other = (form.links, form.boundary) != (scene.rod.links, scene.rod.boundary)
    damping = loads.get("external_damping", {})
    if other and isinstance(damping.get("fin_factor"), list):
        damping.pop("fin_factor")
    table["initial"] = {
        key: value
        for key, value in {**table["initial"], **initial}.items()
        if value is not None and not (other and isinstance(value, list) and key in SHAPES)
    }
    hold = BOUNDARIES.get(form.boundary)
    if hold is not None and not hold.translates:
        for key in ("position", "velocity"):
            table["initial"].pop(key, None)
    table["events"] = [] if other else table.get("events", [])
    return Scene.from_dict(table)


SHAPES = ("phi", "omega")  # initial values of which each link may have its own
