"""Parameters of a rod whose contacts are all pressed, for what depends on their springs."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from types import ModuleType

import numpy as np

from rodgen.arrays import Array
from rodgen.loading.generated_module import structure_of

SHARE = 1e-3  # of the length, or rad, by which they are pressed
BEYOND = 1e3  # lengths, to which edges are moved


def press_contacts(
    model: ModuleType, t: float, y: Array, p: Array, turn: float = 0.0
) -> Array | None:
    """Return parameters with stops and walls so near that all are pressed a little in a state (S,)
    at a time [s], walls at all joints; None of a rod without contacts.

    turn: angle by which stops and walls are turned as well [rad].
    """
    structure = structure_of(model)
    if not structure.contacts:
        return None
    near, places = p.copy(), structure.indices
    length = p[places["length"]]
    names = [contact.name for contact in structure.contacts]
    for key in (f"{name}_{angle}" for name in names for angle in ("direction", "normal")):
        if key in places and not key.startswith("joint_stop"):
            near[places[key]] += turn
    found = model.contacts(t, y, near)
    for name in names:
        size = 1.0 if name.startswith("joint_stop") else length
        nearer = float(np.min(found[f"depth_{name}"])) - SHARE * size
        if f"{name}_gap" in places:
            near[places[f"{name}_gap"]] += nearer
            continue
        normal = near[places[f"{name}_normal"]]
        near[places[f"{name}_x"]] -= nearer * np.cos(normal)
        near[places[f"{name}_y"]] -= nearer * np.sin(normal)
        if f"{name}_edge" in places:
            near[places[f"{name}_edge"]] += BEYOND * length
    return near


def all_presses(model: ModuleType, t: float, y: Array, p: Array) -> Iterator[Array]:
    """Yield parameters with all contacts pressed as they are, and turned by a right angle: along a
    link a spring is not felt."""
    for turn in (0.0, pi / 2):
        if (near := press_contacts(model, t, y, p, turn)) is not None:
            yield near
