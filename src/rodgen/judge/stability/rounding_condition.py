"""Condition numbers of the linear systems behind the two forms.

That of the mass matrix with its diagonal scaled to one: elimination by Cholesky's method does not
see the scale of an unknown, so neither does the number. The joint forces need none: their system
has no units.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig_banded, solveh_banded

Array = NDArray[np.float64]
BAND = 3  # of the joint forces: a joint and the next, x and y of each
DENSE = 400  # unknowns up to which all eigenvalues are looked for


def dense_condition(model: ModuleType, y: Array, p: Array) -> float | None:
    """Of the mass matrix; None where it is too large to be looked at."""
    if len(y) // 2 > DENSE:
        return None
    M = model.mass_matrix(y, p)
    diagonal = np.sqrt(np.diag(M))
    values = np.linalg.eigvalsh(M / np.outer(diagonal, diagonal))
    return float(values[-1] / values[0]) if values[0] > 0 else float("inf")


def chain_condition(model: ModuleType, y: Array) -> float | None:
    """Of the system of the joint forces (uniform mass) or tensions (lumped mass); None where there
    is none, as for one free link.

    It is G W G^T, with the constraints' Jacobian G and the inverse W of the masses of free links,
    or of free joints, here over the mass of a link.
    """
    n, held = model.N, model.BOUNDARY != "free"
    phi = y[2 * (not held) :][: n if model.BOUNDARY != "cantilever" else n - 1]
    band = _tensions(phi, held) if model.INERTIA == "lumped" else _joints(phi, held)
    return _condition(band) if band.shape[1] else None


def _joints(phi: Array, held: bool) -> Array:
    """Upper band of the blocks 2 + 3 (n n + n n) of the joints, and -(1 - 3 n n) between them."""
    n = np.column_stack((-np.sin(phi), np.cos(phi)))
    own = np.eye(2) + 3 * n[:, :, None] * n[:, None, :]
    pairs = own[:-1] + own[1:]
    between = own[1:-1] - 2 * np.eye(2)
    if held:  # the joint at which link 0 is held has a force as well
        pairs = np.concatenate((own[:1], pairs))
        between = own[:-1] - 2 * np.eye(2)
    size = 2 * len(pairs)
    A = np.zeros((BAND + 1, size))
    for at, block in enumerate(pairs):
        A[BAND, 2 * at], A[BAND, 2 * at + 1] = block[0, 0], block[1, 1]
        A[BAND - 1, 2 * at + 1] = block[0, 1]
    for at, block in enumerate(between):
        right = 2 * at + 2
        A[BAND - 2, right], A[BAND - 1, right] = block[0, 0], block[1, 0]
        A[BAND - 3, right + 1], A[BAND - 2, right + 1] = block[0, 1], block[1, 1]
    return A


def _tensions(phi: Array, held: bool) -> Array:
    """Of links between joints with masses of one, of half of that at the ends of the rod."""
    inverse = np.ones(len(phi) + 1)
    inverse[-1] = 2.0
    inverse[0] = 0.0 if held else 2.0
    A = np.zeros((2, len(phi)))
    A[1] = inverse[:-1] + inverse[1:]
    A[0, 1:] = -inverse[1:-1] * np.cos(np.diff(phi))
    return A


def _condition(band: Array) -> float:
    """Of a symmetric positive definite matrix given by its upper band."""
    if band.shape[1] > DENSE:
        return _by_iteration(band)
    values = eig_banded(band, eigvals_only=True)
    return float(values[-1] / values[0]) if values[0] > 0 else float("inf")


def _by_iteration(band: Array) -> float:
    """From the largest eigenvalue of the matrix and of its inverse, by powers."""
    draw = np.random.default_rng(1).standard_normal(band.shape[1])
    up: Array = np.asarray(draw / np.linalg.norm(draw))
    down, most, least = up, 1.0, 1.0
    for _ in range(300):
        up, down = _times(band, up), solveh_banded(band, down)
        most, least = float(np.linalg.norm(up)), float(np.linalg.norm(down))
        up, down = np.asarray(up / most), np.asarray(down / least)
    return most * least


def _times(band: Array, x: Array) -> Array:
    width, size = band.shape
    y = band[-1] * x
    for above in range(1, width):
        row = band[width - 1 - above, above:]
        y[: size - above] += row * x[above:]
        y[above:] += row * x[: size - above]
    return np.asarray(y)
