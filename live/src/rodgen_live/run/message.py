"""Messages to the page: their encoding, and their arrays of the rod and of its past.

A message is a header in JSON, then arrays, as static/hub.js reads them.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.couples import couples_of
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.weights import falls_of
from rodgen.loading.generated_module import call_module
from rodgen.system import System
from rodgen_live.sample_store import Chunk, SampleStore

WORD = 8  # bytes to which the arrays are aligned
TYPES = {np.dtype(np.float32): "f4", np.dtype(np.float64): "f8"}

Named = tuple[str, NDArray[Any]]


def encode(header: dict[str, Any], arrays: Iterable[Named]) -> bytes:
    """Encode a message: length of the header (uint32, little-endian), the header with [name, type,
    count] of every array, and the arrays, each from a multiple of 8 bytes on. Raises ValueError for
    what JSON does not have: not-a-number in the header."""
    arrays = [(name, np.ascontiguousarray(array)) for name, array in arrays]
    listed = [[name, TYPES[array.dtype], array.size] for name, array in arrays]
    text = json.dumps({**header, "arrays": listed}, allow_nan=False, ensure_ascii=False)
    head = text.encode()
    head += b" " * (-(4 + len(head)) % WORD)
    parts = [struct.pack("<I", len(head)), head]
    for _, array in arrays:
        content = array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes()
        parts += [content, bytes(-len(content) % WORD)]
    return b"".join(parts)


MOST_SECTIONS = 201  # joints: of longer rods, forces in them cost too much of a frame
LARGEST = 1e30  # of what is drawn: beyond, single precision ends


def rod_arrays(model: ModuleType, system: System, chunk: Chunk) -> tuple[list[float], list[Named]]:
    """Origin [m], and arrays that draw the rod at the last sample: joints relative to the origin,
    rates, moments, axial and shear forces in the joints that have them, forces on the joints by
    load, free fall, couples; "point": centre of gravity there, angles of an axis and the clamp."""
    timed = system.time_dependent_loads
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        piece = MotionSlice(model, chunk.p, chunk.y[-1], chunk.t[-1], timed=timed)
        joints, centre = piece.values("joints"), piece.values("centre_of_gravity")
        origin = np.nan_to_num(joints[0], nan=0.0, posinf=0.0, neginf=0.0)
        axis, clamp = piece.values("principal_angle"), piece.values("clamp_angle")
        angles = [axis, clamp + piece.values("base_angle")]
        arrays: list[Named] = [
            ("joints", single_precision(joints - origin)),
            ("omega", single_precision(piece.values("omega"))),
            ("moment", single_precision(piece.values("bending_moments"))),
            ("point", single_precision(np.array([*(centre - origin), *angles]))),
        ]
        if len(joints) <= MOST_SECTIONS:
            arrays.append(("section", single_precision(piece.values("section_forces"))))
        forces = piece.values("forces") | falls_of(piece, model.TERMS)
        arrays += [(f"forces:{term}", single_precision(force)) for term, force in forces.items()]
        for term, couple in couples_of(piece, model.TERMS).items():
            arrays.append((f"couple:{term}", single_precision(couple - [*origin, 0.0])))
    return origin.tolist(), arrays


def pull_array(model: ModuleType, system: System, chunk: Chunk, origin: Sequence[float]) -> Named:
    """Array that draws the pull at the last sample, empty without one: its link, the share of that
    before its point, its far end from the origin [m], and the force on the rod [N], x and y."""
    t, y, p = chunk.t[-1], chunk.y[-1], chunk.p
    places, pulled = system.structure.slices, []
    if "support_share" in places:  # else no link can be
        acts = np.any([p[places[f"support_{name}"]] for name in ("stiffness_x", "damping_x")], 0)
        held = {tie.link for tie in system.scene.anchors.support_points}
        pulled = [link for link in np.flatnonzero(acts).tolist() if link not in held]
    if not pulled:
        return "pull", np.zeros(0, np.float32)
    link = pulled[0]
    share, *to = (p[places[f"support_{name}"]][link] for name in ("share", "x", "y"))
    with np.errstate(all="ignore"):
        force = MotionSlice(model, p, y, t).values("support_force")[link]
    return "pull", single_precision(np.concatenate(([link, share], to - np.array(origin), force)))


def single_precision(values: np.ndarray) -> np.ndarray:
    """Flatten values to single precision; not-a-number beyond what that holds."""
    values = np.asarray(values, dtype=float).ravel()
    return np.where(np.abs(values) < LARGEST, values, np.nan).astype(np.float32)


TRAIL_AT_FIRST = 2000  # samples that a page is told of when it comes


def trail_points(model: ModuleType, chunk: Chunk) -> Array:
    """Trail of some samples: tail x, y and centre of gravity x, y [m], and the time [s], (K, 5)."""
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        tail = call_module(model, "joints", chunk.t, chunk.y, chunk.p)[:, -1]
        centre = call_module(model, "centre_of_gravity", chunk.t, chunk.y, chunk.p)
    return np.column_stack((tail, centre, chunk.t))


def trail_so_far(model: ModuleType, store: SampleStore) -> Array:
    """Trail of the last samples that are kept, (K, 5)."""
    points = [np.zeros((0, 5))]
    if store.count:
        (since,) = store.nearest(np.inf, -TRAIL_AT_FIRST).t
        points += [trail_points(model, chunk) for chunk in store.chunks(since)]
    return np.concatenate(points)
