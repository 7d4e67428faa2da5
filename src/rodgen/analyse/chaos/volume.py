"""Lengths and volumes of changes of a state, in which a motion without damping keeps volumes.

Liouville's theorem holds for positions and momenta: in positions and velocities the volume that is
kept has the density det M(q). The metric of kinetic energy, with M(q) for changes of positions and
M(q) for those of velocities, has just this density.
"""

from __future__ import annotations

from types import ModuleType
from typing import Protocol

import numpy as np
from scipy.linalg import solve_triangular

from rodgen.arrays import Array
from rodgen.loading.module import asked


class VolumeForm(Protocol):
    """Lengths of tangents V (count, states) at a state y and a time t [s]."""

    def measured(self, t: float, y: Array, tangents: Array) -> Array:
        """Their components (count, states) in an orthonormal frame."""
        ...

    def tangents(self, t: float, y: Array, measured: Array) -> Array:
        """The tangents with such components."""
        ...

    def log_density(self, t: float, y: Array) -> float:
        """Logarithm of the volume of a unit cube of numbers of the state."""
        ...


class Plain:
    """Every number of the state counts alike."""

    def measured(self, t: float, y: Array, tangents: Array) -> Array:
        return tangents

    def tangents(self, t: float, y: Array, measured: Array) -> Array:
        return measured

    def log_density(self, t: float, y: Array) -> float:
        return 0.0


class Kinetic:
    """The metric of kinetic energy; added states count as they are."""

    def __init__(self, model: ModuleType, p: Array):
        self._model, self._p = model, p

    def _root(self, t: float, y: Array) -> Array:
        """L of M = L L^T."""
        root: Array = np.linalg.cholesky(asked(self._model, "mass_matrix", t, y, self._p))
        return root

    def measured(self, t: float, y: Array, tangents: Array) -> Array:
        root, found = self._root(t, y), tangents.copy()
        for half in _halves(root):
            found[:, half] = tangents[:, half] @ root
        return found

    def tangents(self, t: float, y: Array, measured: Array) -> Array:
        root, found = self._root(t, y), measured.copy()
        for half in _halves(root):
            found[:, half] = solve_triangular(root, measured[:, half].T, lower=True, trans="T").T
        return found

    def log_density(self, t: float, y: Array) -> float:
        return 2.0 * float(np.log(np.diag(self._root(t, y))).sum())


def _halves(root: Array) -> tuple[slice, slice]:
    """Positions and velocities in a state."""
    size = len(root)
    return slice(size), slice(size, 2 * size)
