"""Block-tridiagonal matrices of cells, as the implicit form of a generated module gives them."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

Matrix = NDArray[Any]


@lru_cache(maxsize=32)
def places(cells: int, rows: int, columns: int) -> tuple[Matrix, Matrix, Matrix]:
    """Which entries of blocks (3, cells, rows, columns) exist, and their rows and columns in the
    matrix; the blocks of a cell are by the cell before, own and after."""
    offset, cell, row, column = np.indices((3, cells, rows, columns))
    other = cell + offset - 1
    there = (other >= 0) & (other < cells)
    return there, (rows * cell + row)[there], (columns * other + column)[there]


def solve(blocks: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
    """z of (matrix of square blocks) z = right, (size,) or (size, k); O(n). Raises
    numpy.linalg.LinAlgError."""
    _, cells, size, _ = blocks.shape
    there, rows, columns = places(cells, size, size)
    if transposed:
        rows, columns = columns, rows
    width = 2 * size - 1
    band = np.zeros((2 * width + 1, size * cells), dtype=blocks.dtype)
    band[width + rows - columns, columns] = blocks[there]
    return np.asarray(solve_banded((width, width), band, right, check_finite=False))
