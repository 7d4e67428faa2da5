"""Values given for one run instead of those of its scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.scene.errors import SceneError
from rodgen.scene.plain import plain
from rodgen.scene.scene import Scene
from rodgen.scene.structure import BOUNDARY_PARAMETERS, ROD_PARAMETERS
from rodgen.scene.tables import PLACES, Integrate


def check_used(settings: Integrate, given: Mapping[str, Any], prefix: str = "") -> None:
    """Raise SceneError for a value that the method has no use for.

    settings: all that holds for the run; given: of it, what was asked for beside the scene, None
    where it was not; prefix: of the names in messages. In a scene itself both a step and
    tolerances may stand, so that its method can be changed alone.
    """
    useless = ("rtol", "atol") if settings.fixed else ("step",)
    why = "has a fixed step" if settings.fixed else "chooses its own steps"
    if given.get("t_eval") is not None and given.get("output_every") is not None:
        allowed = "absent: t_eval has the times of the samples"
        raise SceneError(f"{prefix}output_every", given["output_every"], allowed)
    for name in useless:
        if given.get(name) is not None:
            raise SceneError(f"{prefix}{name}", given[name], f"absent: {settings.method} {why}")


def with_parameters(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """The scene with other values of parameters of its module, by name, checked as in its file.

    A load that was a function of time may become a number, and the reverse; then it has another
    module. Raises SceneError for names that the scene has no place for.
    """
    if not isinstance(values, Mapping):
        raise SceneError("parameters", values, "a dictionary of values by name")
    rod = (*ROD_PARAMETERS, *BOUNDARY_PARAMETERS[scene.rod.boundary])
    table = scene.model_dump(exclude_none=True)
    places = {name: (table["rod"], name) for name in rod}
    for name in scene.loads.parameters:
        load, key = PLACES[name]
        places[name] = table["loads"][load], key
    for name, value in values.items():
        if name not in places:
            raise SceneError("parameters", name, f"one of {', '.join(places)}")
        of, key = places[name]
        of[key] = value
    return Scene.from_dict(table)


def with_state(scene: Scene, y: Any, name: str = "y0") -> Scene:
    """The scene that starts in a state y (states,), in the order of the module's STATE; name: what
    it is called in messages. Raises SceneError for what is no such state."""
    states = len(scene.initial_state())
    state = np.asarray(plain(y, name))
    if state.dtype.kind not in "iuf" or state.shape != (states,) or not np.isfinite(state).all():
        raise SceneError(name, y, f"{states} finite numbers, as the module's STATE has them")
    table = scene.model_dump(exclude_none=True)
    return Scene.from_dict(table | {"initial": initial_table(scene, state.astype(float))})


def initial_table(scene: Scene, y: NDArray[np.float64]) -> dict[str, Any]:
    """The table [initial] of a state y (states,)."""
    q, v = np.split(y, 2)
    base = 2 * scene.hold.translates
    table = {"phi": q[base:].tolist(), "omega": v[base:].tolist()}
    return table | ({"position": q[:2].tolist(), "velocity": v[:2].tolist()} if base else {})
