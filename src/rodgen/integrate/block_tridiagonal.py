"""Block-tridiagonal linear systems, such as those of the implicit form of a generated module."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

Matrix = NDArray[Any]


@lru_cache(maxsize=32)
def block_entries(cells: int, rows: int, columns: int) -> tuple[Matrix, Matrix, Matrix]:
    """Mask of the entries of blocks (3, cells, rows, columns) inside the matrix, and their rows and
    columns there; the blocks of a cell are by the one before, itself and the one after."""
    offset, cell, row, column = np.indices((3, cells, rows, columns))
    other = cell + offset - 1
    there = (other >= 0) & (other < cells)
    return there, (rows * cell + row)[there], (columns * other + column)[there]


def solve_blocks(blocks: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
    """Solve a block-tridiagonal system of square blocks for right, (size,) or (size, k), in O(n).
    Raises numpy.linalg.LinAlgError."""
    _, cells, size, _ = blocks.shape
    there, rows, columns = block_entries(cells, size, size)
    if transposed:
        rows, columns = columns, rows
    width = 2 * size - 1
    band = np.zeros((2 * width + 1, size * cells), dtype=blocks.dtype)
    band[width + rows - columns, columns] = blocks[there]
    return np.asarray(solve_banded((width, width), band, right, check_finite=False))
