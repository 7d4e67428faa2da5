"""What the laws of mechanics keep, whatever the equations look like."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import rodgen
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.palette import ALONG, ENDS
from tests.sets import Make, sets

EVERY = pytest.mark.parametrize("inertia", sets(["lumped"], slow=["uniform"]))
# Loads that may give energy; drag by its wind.
DRIVING = {"follower", "tip_load", "distributed_follower", "drag", "viscous_drag"}
DRIVING |= {"fins", "nose", "axial_drag"}  # in a wind, as drag is


@EVERY
def test_conservative_rod_keeps_energy_and_momenta(make_scene: Make, inertia: str) -> None:
    initial = {"velocity": [0.3, -0.2], "position": [1.0, 2.0]}
    scene = make_scene(3, initial=initial, rod={"inertia": inertia})
    sol = rodgen.simulate(scene, rtol=1e-12, atol=1e-13)
    assert sol.work == {}
    # Tolerance 1e-12 a step, some 500 steps.
    energy = sol.energy.total
    assert np.ptp(energy) < 1e-9 * energy[0]
    linear, angular = sol.values("momentum"), sol.values("angular_momentum")
    assert np.ptp(linear, axis=0).max() < 1e-9 * np.abs(linear).max()
    assert np.ptp(angular) < 1e-9 * np.abs(angular).max()


@pytest.mark.parametrize(
    ("boundary", "inertia"),
    sets([("cantilever", "uniform")], slow=[("clamped", "lumped"), ("pinned", "uniform")]),
)
def test_held_rod_keeps_its_energy(make_scene: Make, boundary: str, inertia: str) -> None:
    """Gravity and a root spring have potentials, a support does no work."""
    scene = make_scene(3, boundary, ("gravity",), {"inertia": inertia})
    sol = rodgen.simulate(scene, target="numpy", rtol=1e-12, atol=1e-13)
    moved = np.ptp(sol.energy.kinetic)
    # Tolerance 1e-12 a step, some 500 steps.
    assert np.ptp(sol.energy.total) < 1e-9 * moved


@pytest.mark.parametrize(
    ("boundary", "inertia", "terms"),
    sets(
        [("free", "uniform", ENDS), ("cantilever", "lumped", ENDS), ("clamped", "uniform", ALONG)],
        slow=[("pinned", "lumped", ENDS), ("clamped", "lumped", ENDS)],
        nightly=product(BOUNDARIES, INERTIAS, (ENDS, ALONG)),
    ),
)
def test_energy_balances_the_work_of_the_loads(
    make_scene: Make, boundary: str, inertia: str, terms: tuple[str, ...]
) -> None:
    sol = rodgen.simulate(make_scene(3, boundary, terms, {"inertia": inertia}), target="numpy")
    moved = np.ptp(sol.energy.kinetic) + np.ptp(sol.energy.spring)
    # rtol 1e-10; external damping is not smooth where a velocity turns, which costs digits.
    limit = 1e-6 if "external_damping" in terms else 1e-8
    assert np.abs(sol.energy_balance).max() < limit * moved
    assert set(sol.work) == set(terms) - {"gravity", "moment"}
    for term in set(sol.work) - DRIVING:
        assert np.all(np.diff(sol.work[term]) <= 1e-12 * moved), f"{term} gives energy"
    for term in {"follower", "tip_load"} & set(terms):
        assert np.abs(sol.work[term]).max() > 0.01 * moved


def test_energy_balance_does_not_depend_on_the_samples(make_scene: Make) -> None:
    """Work is integrated over the steps, not over the samples."""
    scene = make_scene(3, "free", ENDS)
    coarse, fine = (rodgen.simulate(scene, output_every=every) for every in (1.0, 0.001))
    for term in coarse.work:
        # Both use the same steps; only the stretches of the quadrature differ.
        assert coarse.work[term][-1] == pytest.approx(fine.work[term][-1], rel=1e-6)


@EVERY
def test_centre_of_gravity_moves_by_the_outer_forces(make_scene: Make, inertia: str) -> None:
    """Newton's second law twice integrated: weight, and the force (6, -4 cos 3t) at the tail."""
    initial = {"velocity": [0.3, -0.2], "position": [1.0, 2.0]}
    terms, rod = ("gravity", "internal_damping", "tip_load"), {"inertia": inertia}
    sol = rodgen.simulate(make_scene(3, "free", terms, rod, initial))
    start = sol.values("momentum")[0]
    t, mass = sol.t, sol.scene.rod.mass
    way = np.stack((3.0 * t**2, 4.0 / 9.0 * (np.cos(3 * t) - 1.0)), axis=1) / mass
    way[:, 1] -= 9.81 / 2 * t**2
    path = sol.centre_of_gravity[0] + start / mass * t[:, None] + way
    np.testing.assert_allclose(sol.centre_of_gravity, path, atol=1e-8)
