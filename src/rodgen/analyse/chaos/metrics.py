"""Metrics of changes of a state; an undamped motion keeps volumes in that of kinetic energy.

Liouville's theorem holds for positions and momenta: in positions and velocities the volume that is
kept has the density det M(q). The metric of kinetic energy, with M(q) for changes of positions and
M(q) for those of velocities, has just this density.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np
from scipy.linalg import solve_triangular

from rodgen.arrays import Array
from rodgen.loading.generated_module import call_module


class Metric:
    """Metric of kinetic energy, for tangents V (count, states) at a state y and a time t [s]; added
    states count as they are. Without a model, so does every number of the state."""

    def __init__(self, model: ModuleType | None, p: Array):
        self._model, self._p = model, p

    def _cholesky(self, t: float, y: Array) -> Array:
        """Cholesky factor L of the mass matrix, M = L L^T; empty without a model."""
        if self._model is None:
            return np.zeros((0, 0))
        root: Array = np.linalg.cholesky(call_module(self._model, "mass_matrix", t, y, self._p))
        return root

    def to_components(self, t: float, y: Array, tangents: Array) -> Array:
        """Components (count, states) of tangents in an orthonormal frame."""
        root, found = self._cholesky(t, y), tangents.copy()
        for half in _halves(root):
            found[:, half] = tangents[:, half] @ root
        return found

    def from_components(self, t: float, y: Array, measured: Array) -> Array:
        """Tangents with these components."""
        root, found = self._cholesky(t, y), measured.copy()
        for half in _halves(root):
            found[:, half] = solve_triangular(root, measured[:, half].T, lower=True, trans="T").T
        return found

    def log_density(self, t: float, y: Array) -> float:
        """Logarithm of the volume of a unit cube of numbers of the state."""
        return 2.0 * float(np.log(np.diag(self._cholesky(t, y))).sum())


def _halves(root: Array) -> tuple[slice, ...]:
    """Slices of positions and velocities in a state; none for an empty factor."""
    size = len(root)
    return (slice(size), slice(size, 2 * size)) if size else ()
