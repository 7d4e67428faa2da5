"""The numbers of a system in arrays, and changes of them by keys of its scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.scene import Scene, Structure
from rodgen.scene.plain import plain


def as_plain(value: Any, place: str) -> Any:
    """A value as a file has it; most are numbers already."""
    return value if type(value) is float else plain(value, place)


def merge(changes: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    """Changes with others after them, which are the last to be made."""
    return {key: value for key, value in changes.items() if key not in given} | given


def pack(structure: Structure, given: Mapping[str, Any]) -> Array:
    """p of parameters by name."""
    p = np.empty(structure.width)
    for name, place in structure.places.items():
        p[place] = given[name]
    return p


def fixed(array: Array) -> Array:
    """An array that cannot be written to."""
    array.flags.writeable = False
    return array


def initial_values(scene: Scene, y: Array) -> dict[str, Any]:
    """Keys of a scene and their values for a state y (states,) at the start."""
    q, v = np.split(y[: len(y) - len(scene.states)], 2)
    base = 2 * scene.hold.translates
    made: dict[str, Any] = {"initial.phi": q[base:].tolist(), "initial.omega": v[base:].tolist()}
    if base:
        made |= {"initial.position": q[:2].tolist(), "initial.velocity": v[:2].tolist()}
    added = y[len(y) - len(scene.states) :].tolist()
    return made | {
        f"states.{name}.initial": value for name, value in zip(scene.states, added, strict=True)
    }
