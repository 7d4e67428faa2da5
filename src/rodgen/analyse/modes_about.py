"""Small motions about any state of a rod, as if it stood still there."""

from __future__ import annotations

from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array

STILL = 1e-7  # of the largest modulus: an imaginary part below it is rounding
NUDGE = 1e-6  # rad, of the differences by which shapes are drawn: errors are its square


class ModesAbout(NamedTuple):
    """frequencies: (k,) [Hz], ascending; growth: (k,) [1/s]; displacements: (k, n+1, 2) of the
    joints, complex, the largest of each 1."""

    frequencies: Array
    growth: Array
    displacements: NDArray[np.complex128]


def modes_about(model: ModuleType, t: float, y: Array, p: Array, count: int) -> ModesAbout:
    """The motions of lowest frequency that oscillate, up to ``count``, of the equations linearised
    at the positions of a state, with rates of zero: y' = J y, J the module's Jacobian at time t.
    What drives the rod away from there is left out."""
    half = (len(y) - len(getattr(model, "STATES", ()))) // 2
    at = y.copy()
    at[half : 2 * half] = 0.0
    s, vectors = np.linalg.eig(np.asarray(model.jac(t, at, p)))
    moving = np.flatnonzero(s.imag > STILL * np.abs(s).max(initial=0.0))
    kept = moving[np.argsort(s[moving].imag, kind="stable")][:count]
    moved = np.array([_displaced(model, at, p, vectors[:half, k]) for k in kept])
    moved = moved.reshape(len(kept), len(model.joints(at, p)), 2)
    return ModesAbout(s[kept].imag / (2 * np.pi), s[kept].real, moved)


def _displaced(
    model: ModuleType, y: Array, p: Array, shape: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Displacements of the joints, (n+1, 2), that go with a change of the positions; its largest
    component is 1, and real."""
    shape = shape / np.abs(shape).max()

    def moved(part: Array) -> Array:
        change = np.concatenate((NUDGE * part, np.zeros(len(y) - len(part))))
        found: Array = (model.joints(y + change, p) - model.joints(y - change, p)) / (2 * NUDGE)
        return found

    found = moved(shape.real) + 1j * moved(shape.imag)
    return np.asarray(found / found.flat[np.abs(found).argmax()])
