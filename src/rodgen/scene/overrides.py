"""Values given for one run instead of those of its scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rodgen.scene.errors import SceneError
from rodgen.scene.tables import Integrate


def check_used(settings: Integrate, given: Mapping[str, Any], prefix: str = "") -> None:
    """Raise SceneError for a value that the method has no use for.

    settings: all that holds for the run; given: of it, what was asked for beside the scene, None
    where it was not; prefix: of the names in messages. In a scene itself both a step and
    tolerances may stand, so that its method can be changed alone.
    """
    useless = ("rtol", "atol") if settings.fixed else ("step",)
    why = "has a fixed step" if settings.fixed else "chooses its own steps"
    for name in useless:
        if given.get(name) is not None:
            raise SceneError(f"{prefix}{name}", given[name], f"absent: {settings.method} {why}")
