"""The equations with the joint forces kept as unknowns, against rhs and jac of the same module."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.scene.structure import Structure
from tests.palette import SHORT_RODS

Built = Callable[..., ModuleType]

VALUES = {"mass": 2.0, "length": 1.5, "bending_stiffness": 3.0}
LOADS = {
    "follower_force": 2.0,
    "follower_angle": 0.3,
    "internal_damping": 0.2,
    "material_damping_time": 0.02,
    "external_damping": 0.4,
    "clamp_angle": 0.5,
    "tip_force_x": 1.0,
    "tip_force_y": -2.0,
    "drag_normal": 0.6,
    "drag_tangential": 0.1,
    "wind_x": 0.7,
    "wind_y": -0.4,
}


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


@SHORT_RODS
def test_cells_give_the_accelerations_and_their_jacobian(
    built: Built, boundary: str, links: int, inertia: str, terms: tuple[str, ...]
) -> None:
    structure = Structure(links, boundary, inertia, terms)
    rod = built(structure)
    given = VALUES | {name: v for name, v in LOADS.items() if name in rod.PARAMETERS}
    given |= {name: np.linspace(0.2, 0.9, len(span)) for name, span in structure.spans.items()}
    p = rod.parameters(**given)
    y = np.random.default_rng(links).normal(size=len(rod.STATE))
    half, base = len(y) // 2, 2 * (boundary == "free")
    cells = half - base
    residual, _, _, by_unknown, *_ = rod.implicit(0.0, y, p, np.zeros(cells), np.zeros((cells, 2)))
    matrix = _band(by_unknown, 3)
    # The residual is linear in its unknowns: one Newton step from zero solves it.
    unknowns = np.linalg.solve(matrix, -residual.ravel()).reshape(cells, 3)
    rates = rod.rhs(0.0, y, p)[half + base :]
    scale = np.abs(rates).max() + 1e-3
    # Rounding of two ways to solve a system of condition below 1e4.
    np.testing.assert_allclose(unknowns[:, 0], rates, rtol=0, atol=1e-12 * scale)
    solved = rod.implicit(0.0, y, p, unknowns[:, 0], unknowns[:, 1:])
    assert np.abs(solved[0]).max() <= 1e-12 * scale
    by_state = np.zeros((3 * cells, len(y)))
    by_state[:, base:half] = _band(solved[1], 1)
    by_state[:, half + base :] = _band(solved[2], 1)
    velocities = _joint_velocities(rod, y, VALUES["length"])
    positions = np.zeros_like(velocities)
    positions[..., :half] = velocities[..., half:]  # what rates are to velocities
    for at in (0, 1):
        for cell in range(cells):
            for by_joint, joints in zip(solved[4:], (velocities, positions), strict=False):
                by_state[3 * cell : 3 * cell + 3] += by_joint[at, cell] @ joints[cell + at]
    jacobian = -np.linalg.solve(matrix, by_state)[::3]
    expected = rod.jac(0.0, y, p)[half + base :]
    np.testing.assert_allclose(
        jacobian, expected, rtol=0, atol=1e-11 * (np.abs(expected).max() + 1)
    )
