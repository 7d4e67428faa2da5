"""Bordered matrices: rows and columns are added, so that they are regular where J is singular."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.errors import AnalysisError

Matrix = Any  # a NumPy array, or a sparse one
SINGULAR = "the bordered equations are singular"
LIGHT = 1e-3  # factor of rows at the border of a band, which keeps them from becoming pivots


@lru_cache(maxsize=2)
def _lapack(dtype: type) -> tuple[Any, Any]:
    """Return LAPACK's functions that factor full matrices and solve with the factors; those of
    SciPy take longer to check a small matrix than to factor it."""
    found = scipy.linalg.lapack.get_lapack_funcs(("getrf", "getrs"), dtype=dtype)
    return found[0], found[1]


class BorderedMatrix:
    """LU factors of a bordered matrix [[J, columns], [rows, 0]], real or complex: dense, or of a
    sparse J that is banded but for its last columns; factors stay banded. J: (N, N + k); rows: (m,
    N + k); columns: (N, m - k), none by default. Raises AnalysisError for a singular one."""

    def __init__(self, J: Matrix, rows: NDArray[Any], columns: NDArray[Any] | None = None):
        self.sparse, self.rows = scipy.sparse.issparse(J), len(rows)
        self.dtype = complex if np.iscomplexobj(J) else float
        if not self.sparse:
            self._dense = self._factor_dense(J, rows, columns)
            return
        blocks: list[list[Any]] = [[J], [scipy.sparse.csc_array(LIGHT * rows)]]
        if columns is not None:
            blocks = [
                [J, scipy.sparse.csc_array(columns)],
                [scipy.sparse.csc_array(LIGHT * rows), None],
            ]
        try:
            self._factors = scipy.sparse.linalg.splu(
                scipy.sparse.csc_array(scipy.sparse.block_array(blocks)), permc_spec="NATURAL"
            )
        except (RuntimeError, ValueError):
            raise AnalysisError(SINGULAR) from None

    def _factor_dense(
        self, J: Matrix, rows: NDArray[Any], columns: NDArray[Any] | None
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Factor the dense matrix; return its LU factors and pivots."""
        (size, width), more = J.shape, 0 if columns is None else columns.shape[1]
        whole = np.zeros((size + len(rows), width + more), dtype=self.dtype)
        whole[:size, :width], whole[size:, :width] = J, rows
        if columns is not None:
            whole[:size, width:] = columns
        if not np.isfinite(whole).all():
            raise AnalysisError(SINGULAR)
        factors, order, singular = _lapack(self.dtype)[0](whole)
        if singular:
            raise AnalysisError(SINGULAR)
        return factors, order

    def solve(self, right: NDArray[Any], transposed: bool = False) -> NDArray[Any]:
        """Solve (matrix) z = right for z, or with the transposed matrix."""
        if not self.sparse:
            made, _ = _lapack(self.dtype)[1](*self._dense, right, trans=int(transposed))
            return np.asarray(made)
        weights = np.ones((len(right), *[1] * (right.ndim - 1)))
        weights[-self.rows :] = LIGHT
        right = right.astype(self.dtype)
        if transposed:
            return np.asarray(self._factors.solve(right, "T")) * weights
        return np.asarray(self._factors.solve(right * weights))

    @property
    def determinant_sign(self) -> int:
        """Sign of the determinant of a real matrix."""
        if self.sparse:
            return determinant_sign(self._factors)
        pivoted, order = self._dense
        swaps = int((order != np.arange(len(order))).sum())
        return int(np.sign(np.diagonal(pivoted)).prod()) * (-1 if swaps % 2 else 1)


def determinant_sign(factors: Any) -> int:
    """Sign of a determinant, from the LU factors of SuperLU."""
    signs = int(np.sign(factors.U.diagonal()).prod())
    return signs * _permutation_sign(factors.perm_r) * _permutation_sign(factors.perm_c)


def _permutation_sign(order: NDArray[np.int_]) -> int:
    """Parity of a permutation: 1 for an even one, -1 for an odd one."""
    size = len(order)
    moves = scipy.sparse.csc_array((np.ones(size), (np.arange(size), order)), shape=(size, size))
    cycles = scipy.sparse.csgraph.connected_components(moves)[0]
    return 1 if (size - cycles) % 2 == 0 else -1
