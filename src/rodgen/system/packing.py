"""Packing of a system's numbers into arrays, and unpacking to keys of its scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.scene import Scene, Structure


def merge_changes(changes: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """Merge changes with others, which come after them."""
    return {key: value for key, value in changes.items() if key not in given} | given


def pack(structure: Structure, given: Mapping[str, Any]) -> Array:
    """Pack parameters, by name, into the array p."""
    p = np.empty(structure.width)
    for name, place in structure.slices.items():
        p[place] = given[name]
    return p


def make_read_only(array: Array) -> Array:
    """Make an array read-only, and return it."""
    array.flags.writeable = False
    return array


def initial_values(scene: Scene, y: Array) -> dict[str, Any]:
    """Values of the keys of a scene that give a state y (states,) at the start."""
    q, v = np.split(y[: len(y) - len(scene.states)], 2)
    base = 2 * scene.boundary_condition.translates
    made: dict[str, Any] = {"initial.phi": q[base:].tolist(), "initial.omega": v[base:].tolist()}
    if base:
        made |= {"initial.position": q[:2].tolist(), "initial.velocity": v[:2].tolist()}
    added = y[len(y) - len(scene.states) :].tolist()
    return made | {
        f"states.{name}.initial": value for name, value in zip(scene.states, added, strict=True)
    }
