"""Forces in the joints of a moving rod, by derivation 3, and its block-tridiagonal systems.

The equations that keep the joint forces as unknowns (`implicit` of a generated module) are linear
in them and in the angular accelerations, block by block from link to link: in every state both
follow from one solve of O(n).
"""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.arrays import Array

Matrix = NDArray[Any]


def forces_per_mass(model: ModuleType, t: Array, y: Array, p: Array) -> Array:
    """Joint forces over the mass of a link of a uniform rod, (..., n_moving, 2) [m/s^2]: every
    moving link pulls with them at the joint before it. Not-a-number for states that are not finite.

    t: times [s], (...); y: states, (..., states); p: parameters. Loads on a joint act on the link
    before it. Joint 0 of a free rod has none, and the force there is minus the load; `start_loads`
    of a module are the forces of these loads on the link after the joint.
    """
    size = (y.shape[-1] - len(getattr(model, "STATES", ()))) // 2
    n_moving = size - 2 * ("x0" in model.STATE)
    times = np.broadcast_to(t, y.shape[:-1]).ravel()
    found = np.full((len(times), n_moving, 2), np.nan)
    at_rest, free = np.zeros(n_moving), np.zeros((n_moving, 2))
    for row, (at, state) in enumerate(zip(times, y.reshape(len(times), -1), strict=True)):
        residual, _, _, by_unknown, *_ = model.implicit(float(at), state, p, at_rest, free)
        if np.isfinite(residual).all() and np.isfinite(by_unknown).all():
            found[row] = -solve_blocks(by_unknown, residual.ravel()).reshape(n_moving, 3)[:, 1:]
    return found.reshape(*y.shape[:-1], n_moving, 2)


@lru_cache(maxsize=32)
def block_entries(n_moving: int, rows: int, columns: int) -> tuple[Matrix, Matrix, Matrix]:
    """Mask of the entries of blocks (3, n_moving, rows, columns) inside the matrix, their rows and
    columns there; the blocks of a cell are by the one before, itself and the one after."""
    offset, cell, row, column = np.indices((3, n_moving, rows, columns))
    other = cell + offset - 1
    there = (other >= 0) & (other < n_moving)
    return there, (rows * cell + row)[there], (columns * other + column)[there]


def solve_blocks(blocks: Matrix, right: Matrix, transposed: bool = False) -> Matrix:
    """Solve a block-tridiagonal system of square blocks for right, (size,) or (size, k), in O(n).
    Raises numpy.linalg.LinAlgError."""
    _, n_moving, size, _ = blocks.shape
    there, rows, columns = block_entries(n_moving, size, size)
    if transposed:
        rows, columns = columns, rows
    width = 2 * size - 1
    band = np.zeros((2 * width + 1, size * n_moving), dtype=blocks.dtype)
    band[width + rows - columns, columns] = blocks[there]
    return np.asarray(scipy.linalg.solve_banded((width, width), band, right, check_finite=False))
