"""What the page draws of a state: joints, moments, loads, as the module gives them."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from rodgen.integrate.solution import principal_axes
from rodgen.integrate.stepper import Array
from rodgen.view.live.chunk import Chunk
from rodgen.view.live.frames import Named

LARGEST = 1e30  # of what is drawn: beyond, single precision ends


def drawn(model: ModuleType, chunk: Chunk) -> tuple[list[float], list[Named]]:
    """The origin [m], and arrays for the message, of the last sample: joints and centre of gravity
    from there on, angle of the principal axis, gravity, moments, forces on the joints by load."""
    t, y, p = chunk.t[-1], chunk.y[-1], chunk.p
    gravity = _gravity(model, p)
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        joints, centre = model.joints(y, p), model.centre_of_gravity(y, p)
        origin = np.nan_to_num(joints[0], nan=0.0, posinf=0.0, neginf=0.0)
        angle = float(principal_axes(*model.inertia(y, p)).angle)
        arrays: list[Named] = [
            ("joints", _single(joints - origin)),
            ("moment", _single(model.bending_moments(y, p))),
            ("point", _single(np.concatenate((centre - origin, [angle, gravity])))),
        ]
        forces = model.forces(t, y, p)
        arrays += [(f"forces:{term}", _single(force)) for term, force in forces.items()]
    return origin.tolist(), arrays


def _gravity(model: ModuleType, p: Array) -> float:
    """Acceleration of gravity [m/s^2], 0 where there is none."""
    names = model.PARAMETERS
    return float(p[names.index("gravity")]) if "gravity" in names else 0.0


def _single(values: np.ndarray) -> np.ndarray:
    """In single precision, one after the other; not-a-number beyond what that holds."""
    values = np.asarray(values, dtype=float).ravel()
    return np.where(np.abs(values) < LARGEST, values, np.nan).astype(np.float32)
