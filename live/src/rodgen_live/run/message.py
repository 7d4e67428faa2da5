"""Messages to the page: their encoding, and their arrays of the rod and of its past.

A message is a header in JSON, then arrays, as static/hub.js reads them.
"""

from __future__ import annotations

import itertools
import json
import struct
from collections.abc import Iterable, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import MotionSlice, principal_axes
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


def rod_arrays(model: ModuleType, chunk: Chunk) -> tuple[list[float], list[Named]]:
    """Origin [m], and arrays that draw the rod at the last sample: joints and centre of gravity
    relative to the origin, rates, angle of the principal axis, gravity, moments, axial and shear
    forces in the joints that have them, forces on the joints by load."""
    t, y, p = chunk.t[-1], chunk.y[-1], chunk.p
    gravity = _gravity(model, p)
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        joints, centre = model.joints(y, p), call_module(model, "centre_of_gravity", t, y, p)
        origin = np.nan_to_num(joints[0], nan=0.0, posinf=0.0, neginf=0.0)
        angle = float(principal_axes(*call_module(model, "inertia", t, y, p)).angle)
        piece = MotionSlice(model, p, y, t)
        arrays: list[Named] = [
            ("joints", _single_precision(joints - origin)),
            ("omega", _single_precision(piece.values("omega"))),
            ("moment", _single_precision(model.bending_moments(y, p))),
            ("point", _single_precision(np.concatenate((centre - origin, [angle, gravity])))),
        ]
        if len(joints) <= MOST_SECTIONS:
            arrays.append(("section", _single_precision(piece.values("section_forces"))))
        forces = model.forces(t, y, p)
        arrays += [(f"forces:{term}", _single_precision(force)) for term, force in forces.items()]
    return origin.tolist(), arrays


NEAR = 1.0  # m, by which an end of a spring is moved: its energy is quadratic, any size is exact


def pull_array(model: ModuleType, system: System, chunk: Chunk, origin: Sequence[float]) -> Named:
    """Array that draws the pull at the last sample, empty without one: its link, the share of that
    before its point, its far end from the origin [m], and the force on the rod [N], x and y, by
    which the energy grows with the place of the far end."""
    t, y, p = chunk.t[-1], chunk.y[-1], chunk.p
    link = pulled_link(system, p)
    if link is None:
        return "pull", _single_precision(np.zeros(0))
    places, force = system.structure.slices, []
    share, x, y0 = (p[places[f"support_{name}"]][link] for name in ("share", "x", "y"))
    for axis in "xy":
        sides = []
        for sign in (1, -1):
            moved = p.copy()
            moved[places[f"support_{axis}"].start + link] += sign * NEAR
            with np.errstate(all="ignore"):
                sides.append(np.array(call_module(model, "energy", t, y, moved)))
        force.append(float(np.sum(sides[0] - sides[1])) / (2 * NEAR))
    return "pull", _single_precision(np.array([link, share, x - origin[0], y0 - origin[1], *force]))


def pulled_link(system: System, p: Array) -> int | None:
    """Link that is pulled with these parameters of a module, or None: one that has a support which
    the system does not have."""
    places = system.structure.slices
    if "support_share" not in places:
        return None
    parts = [p[places[f"support_{name}"]] for name in ("stiffness_x", "damping_x")]
    held = {tie.link for tie in system.scene.anchors.support_points}
    found = [int(link) for link in np.flatnonzero(np.any(parts, axis=0)) if int(link) not in held]
    return found[0] if found else None


def ghost_array(joints: Array, origin: Sequence[float]) -> Named:
    """Array that draws a ghost: its joints (joints, 2) [m], from the origin of the run's own."""
    return "ghost", _single_precision(joints - np.array(origin))


def _gravity(model: ModuleType, p: Array) -> float:
    """Acceleration of gravity [m/s^2], 0 where there is none."""
    names = model.PARAMETERS
    return float(p[names.index("gravity")]) if "gravity" in names else 0.0


def _single_precision(values: np.ndarray) -> np.ndarray:
    """Flatten values to single precision; not-a-number beyond what that holds."""
    values = np.asarray(values, dtype=float).ravel()
    return np.where(np.abs(values) < LARGEST, values, np.nan).astype(np.float32)


LONGEST_TRAIL = 300  # samples that wait: more between two pictures cannot be told apart
TRAIL_AT_FIRST = 2000  # samples that a page is told of when it comes


class Trail:
    """Samples whose trail is still to be sent to a page. `anew`: the trail is to be taken from all
    that are kept, not from these alone. To be used from one thread at a time."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin anew: the trail on the page is to be replaced."""
        self._waiting: list[Chunk] = []
        self.anew = True

    def add(self, chunk: Chunk) -> None:
        """Add samples that wait; of too many, every other one is dropped."""
        self._waiting.append(chunk.select(slice(None, None, max(1, len(chunk) // LONGEST_TRAIL))))
        while sum(map(len, self._waiting)) > LONGEST_TRAIL:
            self._waiting = _halve(self._waiting)

    def pop(self, model: ModuleType, store: SampleStore) -> Array:
        """Take the trail to be sent: tail x, y and centre of gravity x, y [m], and the time [s],
        (K, 5); nothing waits from then on."""
        chunks = _last_samples(store.chunks(), TRAIL_AT_FIRST) if self.anew else self._waiting
        self._waiting, self.anew = [], False
        return _trail_points(model, chunks)


def _trail_points(model: ModuleType, chunks: Sequence[Chunk]) -> Array:
    found = [np.zeros((0, 5))]
    # In as few calls as there are sets of parameters: most chunks have a sample or two.
    for _, group in itertools.groupby(chunks, lambda chunk: id(chunk.p)):
        same = list(group)
        t, y = (np.concatenate(parts) for parts in zip(*((c.t, c.y) for c in same), strict=True))
        p = same[0].p
        with np.errstate(all="ignore"):  # a state may have stopped being finite
            tail = model.joints(y, p)[:, -1]
            centre = call_module(model, "centre_of_gravity", t, y, p)
        found.append(np.column_stack((tail, centre, t)))
    return np.concatenate(found)


def _halve(chunks: Iterable[Chunk]) -> list[Chunk]:
    """Drop every other sample of some chunks."""
    kept, before = [], 0
    for chunk in chunks:
        kept.append(chunk.select(slice(before % 2, None, 2)))
        before += len(chunk)
    return [chunk for chunk in kept if len(chunk)]


def _last_samples(chunks: Iterable[Chunk], most: int) -> list[Chunk]:
    """The last `most` samples of some chunks."""
    found: list[Chunk] = []
    for chunk in reversed(list(chunks)):
        if most <= 0:
            break
        found.append(chunk.select(slice(-most, None)))
        most -= len(chunk)
    return found[::-1]
