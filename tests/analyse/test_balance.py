"""Equations of rest of rods whose loads follow the motion, beside differences and the Jacobian."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigvals

from rodgen.analyse.equilibrium_equations import DenseBalance
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.scene import Scene
from tests.analyse.rods import eigenvalues

pytestmark = pytest.mark.slow  # its structures are none of the others'
STEERED: dict[str, Any] = {
    "name": "steered",
    "rod": {"links": 2, "length": 2.0, "mass": 4.0, "bending_stiffness": 20.0},
    "loads": {
        "follower": {"force": 5.0, "angle": "0.3*z - 0.2*phi(0.5)"},
        "tip": {"x": "-2*x(1)", "y": "-3*y(0.4)"},
    },
    "states": {
        "z": {"rate": "(phi(1) - 2*omega(0.5) - z)/0.4 + 0.5*w"},
        "w": {"rate": "y(0) - 3*w"},
    },
}


@pytest.fixture(params=["free", "clamped", "driven"])
def system(request: pytest.FixtureRequest) -> SteadyRod:
    """A driven rod is a free one of which no load follows the place."""
    rod = STEERED["rod"] | {"boundary": "free" if request.param == "driven" else request.param}
    table = STEERED | {"rod": rod}
    if request.param == "driven":
        table = table | {"loads": {"follower": {"force": 5.0, "angle": "-0.2*phi(0.5)"}}}
        table.pop("states")
    return SteadyRod.of(Scene.from_dict(table))


def test_slope_of_what_is_out_of_balance(system: SteadyRod) -> None:
    """With a bend that is to remain, the mass that multiplies the rates turns with the rod."""
    draw = np.random.default_rng(3)
    p = system.model.parameters(**system.scene.parameters)
    half = system.n_base + system.n_moving
    y = np.zeros(len(system.model.STATE))
    at_rest = np.r_[:half, 2 * half : len(y)]
    y[at_rest] = draw.normal(size=len(at_rest))
    bend = draw.normal(size=len(at_rest))
    here, h = DenseBalance(system, y, p, bend), 1e-5
    assert np.abs(here.rates[:half]).max() > 1
    columns = []
    for at in at_rest:
        off = np.zeros(len(y))
        off[at] = h
        there = (DenseBalance(system, y + side * off, p, bend).residual for side in (1, -1))
        columns.append(np.subtract(*there) / (2 * h))
    slope = np.stack(columns, axis=1)
    # Differences over 1e-5 rad.
    np.testing.assert_allclose(here.residual_jacobian, slope, atol=1e-6 * np.abs(slope).max())


def test_small_motions_are_those_of_the_jacobian(system: SteadyRod) -> None:
    """All eigenvalues of K, C and M with the states' own: those of the module's Jacobian, but for
    the zeros of motions that nothing holds."""
    p = system.model.parameters(**system.scene.parameters)
    y = np.zeros(len(system.model.STATE))
    if system.n_base and system.n_added_states:
        y[0] = -4.5  # where the load at the tail, -2 x, holds the straight rod against its thrust
        assert np.abs(system.model.rhs(0.0, y, p)).max() < 1e-14
    here = DenseBalance(system, y, p, 0.0)
    dense = here.dense_pencil()
    size = dense.size
    K, C, M = dense.parts
    # M u'' + C u' + K u = 0, where rows of added states are of first order: M is zero there.
    A = np.block([[np.eye(size), np.zeros((size, size))], [C, M]])
    B = np.block([[np.zeros((size, size)), np.eye(size)], [-K, np.zeros((size, size))]])
    found = eigvals(B, A)
    due = eigenvalues(system.scene, y)
    due = due[np.argsort(np.abs(due))][2 * len(here.free_directions) :]
    finite = found[np.abs(found) < 1e6]
    for value in due:
        assert np.abs(finite - value).min() < 1e-6 * max(1.0, abs(value)), value
