"""The text panel of a live run: which rows it has, and what stands in them at present."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import ModuleType

import numpy as np

from rodgen.scene import Scene
from rodgen.view.live.quantities.now import Entry, Now
from rodgen.view.live.quantities.present import Present, Row
from rodgen.view.live.quantities.rows_motion import energies, geometry, integration
from rodgen.view.live.quantities.rows_scene import critical, loads, rod

__all__ = ["Present", "Row", "groups", "texts"]

SECTIONS: dict[str, Callable[[Scene], Iterator[Entry]]] = {
    "Rod": rod,
    "Loads and damping": loads,
    "Critical force": critical,
    "Centre of gravity and inertia": geometry,
    "Energy": energies,
    "Integration": integration,
}


def groups(scene: Scene) -> dict[str, list[Row]]:
    """The rows of the panel by the title of their group: those of loads, springs and settings that
    the scene has. They are fixed by its structure and the kind of its method."""
    made = {title: [row for row, _ in make(scene)] for title, make in SECTIONS.items()}
    return {title: rows for title, rows in made.items() if rows}


def texts(scene: Scene, model: ModuleType, present: Present) -> dict[str, str]:
    """What stands in every row of `groups`, by key: a number as wide as all others, without its
    unit, or words. model: a module of the scene's structure; values of parameters are those of
    the chunk."""
    now = Now(scene, model, present)
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        return {row.key: show(now) for make in SECTIONS.values() for row, show in make(scene)}
