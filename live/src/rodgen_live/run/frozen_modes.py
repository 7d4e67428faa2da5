"""Small motions about any state of a rod, as though it were at rest there."""

from __future__ import annotations

from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array

STILL = 1e-7  # of the largest modulus: an imaginary part below it is rounding
NUDGE = 1e-6  # rad, of the differences by which shapes are drawn: errors are its square


class FrozenModes(NamedTuple):
    """Modes about a state. frequencies: (k,) [Hz], ascending; growth: (k,) [1/s]; displacements:
    (k, n+1, 2) of the joints, complex, the largest of each 1."""

    frequencies: Array
    growth: Array
    displacements: NDArray[np.complex128]


def frozen_modes(model: ModuleType, t: float, y: Array, p: Array, count: int) -> FrozenModes:
    """Compute the oscillating motions of lowest frequency, up to ``count``, by the eigenvalues of
    the module's Jacobian J in y' = J y, at time t, the positions of y and rates of zero. Forces
    that drive the rod away from there are left out."""
    half = (len(y) - len(getattr(model, "STATES", ()))) // 2
    at = y.copy()
    at[half : 2 * half] = 0.0
    s, vectors = np.linalg.eig(np.asarray(model.jac(t, at, p)))
    moving = np.flatnonzero(s.imag > STILL * np.abs(s).max(initial=0.0))
    kept = moving[np.argsort(s[moving].imag, kind="stable")][:count]
    moved = np.array([_joint_displacements(model, at, p, vectors[:half, k]) for k in kept])
    moved = moved.reshape(len(kept), len(model.joints(at, p)), 2)
    return FrozenModes(s[kept].imag / (2 * np.pi), s[kept].real, moved)


def _joint_displacements(
    model: ModuleType, y: Array, p: Array, shape: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Displacements of the joints (n+1, 2) for a change of the positions, scaled to a largest
    component of 1."""
    shape = shape / np.abs(shape).max()

    def displacements(part: Array) -> Array:
        change = np.concatenate((NUDGE * part, np.zeros(len(y) - len(part))))
        found: Array = (model.joints(y + change, p) - model.joints(y - change, p)) / (2 * NUDGE)
        return found

    found = displacements(shape.real) + 1j * displacements(shape.imag)
    return np.asarray(found / found.flat[np.abs(found).argmax()])
