"""Matrices with rows and columns at their borders, which are regular where the matrix itself is
not."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_solve
from scipy.linalg.lapack import dgetrf
from scipy.sparse import block_array, csc_array, issparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from rodgen.arrays import Array
from rodgen.errors import AnalysisError

Matrix = Any  # a NumPy array, or a sparse one
SINGULAR = "the bordered equations are singular"
LIGHT = 1e-3  # times which rows at the border of a band are taken: they are no pivots then


class Bordered:
    """L U of [[J, columns], [rows, 0]], dense, or of a sparse J that is a band but for its last
    columns, whose factors stay a band. J: (N, N + k); rows: (m, N + k);
    columns: (N, m - k), none by default. Raises AnalysisError for one that is singular."""

    def __init__(self, J: Matrix, rows: Array, columns: Array | None = None):
        self.sparse, self.rows = issparse(J), len(rows)
        more = 0 if columns is None else columns.shape[1]
        if not self.sparse:
            size, width = J.shape
            whole = np.zeros((size + len(rows), width + more))
            whole[:size, :width], whole[size:, :width] = J, rows
            if columns is not None:
                whole[:size, width:] = columns
            if not np.isfinite(whole).all():
                raise AnalysisError(SINGULAR)
            factors, order, singular = dgetrf(whole)
            if singular:
                raise AnalysisError(SINGULAR)
            self._dense = factors, order
            return
        blocks: list[list[Any]] = [[J], [csc_array(LIGHT * rows)]]
        if columns is not None:
            blocks = [[J, csc_array(columns)], [csc_array(LIGHT * rows), None]]
        try:
            self._factors = splu(csc_array(block_array(blocks)), permc_spec="NATURAL")
        except (RuntimeError, ValueError):
            raise AnalysisError(SINGULAR) from None

    def solve(self, right: NDArray[Any], transposed: bool = False) -> Array:
        """z of (matrix) z = right, or of its transpose."""
        if self.sparse:
            weights = np.ones((len(right), *[1] * (right.ndim - 1)))
            weights[-self.rows :] = LIGHT
            if transposed:
                return np.asarray(self._factors.solve(right, "T")) * weights
            return np.asarray(self._factors.solve(right * weights))
        return np.asarray(lu_solve(self._dense, right, int(transposed), check_finite=False))

    @property
    def sign(self) -> int:
        """The sign of the determinant."""
        if self.sparse:
            return sign_of(self._factors)
        pivoted, order = self._dense
        swaps = int((order != np.arange(len(order))).sum())
        return int(np.sign(np.diagonal(pivoted)).prod()) * (-1 if swaps % 2 else 1)


def sign_of(factors: Any) -> int:
    """The sign of a determinant, from the factors of SuperLU."""
    signs = int(np.sign(factors.U.diagonal()).prod())
    return signs * _parity(factors.perm_r) * _parity(factors.perm_c)


def _parity(order: NDArray[np.int_]) -> int:
    """1 for an even permutation, -1 for an odd one."""
    size = len(order)
    moves = csc_array((np.ones(size), (np.arange(size), order)), shape=(size, size))
    cycles = connected_components(moves)[0]
    return 1 if (size - cycles) % 2 == 0 else -1
