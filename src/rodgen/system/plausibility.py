"""Numbers of a rod that its author may not have meant: angles that look like degrees."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import shorten
from rodgen.model.rod import CLAMP_ANGLE
from rodgen.result import Note, doubt
from rodgen.scene.distribution import shape_without_load
from rodgen.scene.structure import Structure

TURN = 2 * math.pi
RADIANS = "angles are in radians, deg(90) is one in degrees"


def angle_doubts(structure: Structure, p: Array, field: Callable[[str], str]) -> Iterator[Note]:
    """Yield doubts about angles of loads and of the clamp of more than a turn; field: dotted name
    in the scene of a parameter."""
    angles = structure.angle_indices
    sizes = np.abs(p[[*angles.values()]]) / TURN
    if sizes.max(initial=0.0) <= 1:
        return
    for (name, place), turns in zip(angles.items(), sizes.tolist(), strict=True):
        if turns > 1:
            given = f"{field(name)} = {p[place]:g}"
            yield doubt(f"{given} is {turns:.3g} turns: {RADIANS}", turns=turns)


def initial_angle_doubts(
    structure: Structure, p: Array, y0: Array, given: Callable[[], tuple[str, Any]]
) -> Iterator[Note]:
    """Yield the doubt about an initial angle of more than a turn; given: the key of the scene that
    says the angles, and its value."""
    turns = float(_turned_at_start(structure, p, y0)) / TURN
    if turns > 1:
        key, value = given()
        words = f"{key} = {shorten(value)} turns a link by {turns:.3g} turns"
        yield doubt(f"{words}: {RADIANS}", turns=turns)


def _turned_at_start(structure: Structure, p: Array, y0: Array) -> Array:
    """Largest angle by which a link is turned at the start (...,) [rad], out of the shape without
    load, which may wind, and out of the x axis, whichever is less."""
    angles, unloaded = y0[..., structure.angle_slice], shape_without_load(structure, p)
    if CLAMP_ANGLE.name in structure.slices:  # of which there is a doubt of its own
        unloaded = unloaded + p[..., structure.slices[CLAMP_ANGLE.name]]
    least = np.minimum(np.abs(angles), np.abs(angles - unloaded))
    return np.asarray(least.max(axis=-1, initial=0.0))


def count_doubts(structure: Structure, p: Array, y0: Array) -> NDArray[np.intp]:
    """Number of these doubts about each of many rods, (rods,), with parameters p (rods, width) and
    states y0 (rods, states) at the start."""
    angles = np.abs(p[:, [*structure.angle_indices.values()]]) > TURN
    starts = _turned_at_start(structure, p, y0) > TURN
    return np.asarray(angles.sum(axis=1) + starts)
