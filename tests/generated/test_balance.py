"""What acts on a rod at rest: mass matrix times rates, without the mass."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.check.module_check import _draw_parameters
from rodgen.model.rod import BOUNDARIES
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built
from tests.palette import LAWS, STATES, TABLES, short

# Loads that are smooth at rest, among them all that know positions and velocities.
SMOOTH = ("follower", "gravity", "tip_load", "distributed_follower", "viscous_drag", "moment@0")
HELD = ("supports", "foundation", "material_damping", "internal_damping")
UNLIKE = ("gravity", "supports", "viscous_drag", "follower@1+1/3")
STRUCTURES = [
    *(Structure(3, of, terms=SMOOTH) for of in BOUNDARIES),
    *(Structure(3, of, "lumped", terms=HELD) for of in ("free", "cantilever")),
    Structure(3, "free", terms=UNLIKE, nonuniform=("stiffness", "bodies", "rest", "lengths")),
    Structure(2, "pinned", "lumped", (), nonuniform=("stiffness", "points", "lengths")),
    Structure(
        3, "free", terms=("follower", "tip_load"), expressions=LAWS, states=STATES, tables=TABLES
    ),
    Structure(1, "free", terms=()),
]
STEP = 1e-6  # of central differences, whose errors are 1e-12 of third derivatives, and rounding


@pytest.mark.parametrize("structure", STRUCTURES, ids=short)
def test_forces_are_mass_times_rates_without_the_mass(built: Built, structure: Structure) -> None:
    """And in a frame that accelerates, less the mass times that; derivatives by differences."""
    module, draw = built(structure, "numpy"), np.random.default_rng(4)
    p = module.parameters(**_draw_parameters(module, 0.4, draw))
    y = 0.5 * draw.standard_normal(len(module.STATE))
    added, base = len(structure.state_names), 2 * structure.boundary_condition.translates
    half = (len(y) - added) // 2
    y[half + base : 2 * half] = 0.0  # links do not turn
    frame = draw.standard_normal(base)

    def rates(at: np.ndarray) -> np.ndarray:
        M, v = module.mass_matrix(at, p), module.rhs(0.4, at, p)[half:]
        return np.concatenate((M @ v[:half] - M[:, :base] @ frame, v[half:]))

    force, slope = module.balance(0.4, y, p, *([frame] if base else []))
    np.testing.assert_allclose(force, rates(y), rtol=0, atol=1e-12 * np.abs(force).max())
    by = [(rates(y + STEP * e) - rates(y - STEP * e)) / (2 * STEP) for e in np.eye(len(y))]
    np.testing.assert_allclose(slope, np.transpose(by), rtol=0, atol=1e-7 * np.abs(slope).max())
