"""The equations with the joint forces kept as unknowns, against rhs and jac of the same module."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built, rarely
from tests.palette import ALONG, ENDS


def _band(blocks: Any, width: int) -> Any:
    """The matrix of blocks by the cell before, own and after."""
    cells, rows = blocks.shape[1], blocks.shape[2]
    matrix = np.zeros((rows * cells, width * cells))
    for cell in range(cells):
        for offset in (-1, 0, 1):
            if 0 <= (other := cell + offset) < cells:
                block = blocks[offset + 1, cell].reshape(rows, width)
                matrix[rows * cell : rows * (cell + 1), width * other : width * (other + 1)] = block
    return matrix


def _joint_velocities(rod: ModuleType, y: Any, length: float) -> Any:
    """Derivatives of the velocities of the joints at both ends of every moving link by the state:
    v_s = v_0 + sum over the links before it of l omega (-sin, cos)(phi)."""
    half = len(y) // 2
    base = 2 * (rod.BOUNDARY == "free")
    cells = half - base
    l = length / rod.N
    phi, omega = y[base:half], y[half + base :]
    by = np.zeros((cells + 1, 2, len(y)))
    for s in range(cells + 1):
        if base:
            by[s, 0, half] = by[s, 1, half + 1] = 1.0
        for q in range(s):
            by[s, :, base + q] = -l * omega[q] * np.array([np.cos(phi[q]), np.sin(phi[q])])
            by[s, :, half + base + q] = l * np.array([-np.sin(phi[q]), np.cos(phi[q])])
    return by


@rarely("boundary, inertia, terms", BOUNDARIES, INERTIAS, (ENDS, ALONG))
def test_cells_give_the_accelerations_and_their_jacobian(
    built: Built, point: type, boundary: str, inertia: str, terms: tuple[str, ...]
) -> None:
    at = point(built(Structure(3, boundary, inertia, terms)))  # of which one is inside
    rod, t, y, p = at.module, at.t, at.y, at.p
    half, base = len(y) // 2, 2 * (boundary == "free")
    cells = half - base
    residual, _, _, by_unknown, *_ = rod.implicit(t, y, p, np.zeros(cells), np.zeros((cells, 2)))
    matrix = _band(by_unknown, 3)
    # The residual is linear in its unknowns: one Newton step from zero solves it.
    unknowns = np.linalg.solve(matrix, -residual.ravel()).reshape(cells, 3)
    rates = rod.rhs(t, y, p)[half + base :]
    scale = np.abs(rates).max() + 1e-3
    # Rounding of two ways to solve a system of condition below 1e4.
    np.testing.assert_allclose(unknowns[:, 0], rates, rtol=0, atol=1e-12 * scale)
    solved = rod.implicit(t, y, p, unknowns[:, 0], unknowns[:, 1:])
    assert np.abs(solved[0]).max() <= 1e-12 * scale
    by_state = np.zeros((3 * cells, len(y)))
    by_state[:, base:half] = _band(solved[1], 1)
    by_state[:, half + base :] = _band(solved[2], 1)
    velocities = _joint_velocities(rod, y, at.values["length"])
    positions = np.zeros_like(velocities)
    positions[..., :half] = velocities[..., half:]  # what rates are to velocities
    for end in (0, 1):
        for cell in range(cells):
            for by_joint, joints in zip(solved[4:], (velocities, positions), strict=False):
                by_state[3 * cell : 3 * cell + 3] += by_joint[end, cell] @ joints[cell + end]
    jacobian = -np.linalg.solve(matrix, by_state)[::3]
    expected = rod.jac(t, y, p)[half + base :]
    np.testing.assert_allclose(
        jacobian, expected, rtol=0, atol=1e-11 * (np.abs(expected).max() + 1)
    )
