"""Points on springs against rodgen's rigid links, by two routes each."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from rodgen.analyse.critical import critical_load
from rodgen.analyse.extrapolation import richardson
from rodgen_evidence.thesis import scenes
from rodgen_evidence.thesis.mass_spring import MassSpring, grow, simulated_critical_load
from rodgen_evidence.thesis.mass_spring_table import compliance, rod

FORCE = 300.0  # N


@pytest.fixture
def model() -> MassSpring:
    return MassSpring(6, 50.0, 5.0, 100.0, 1e5)


def test_straight_state_accelerates_as_a_whole(model: MassSpring):
    a = model.accelerations(model.straight(FORCE), FORCE)
    np.testing.assert_allclose(a[:, 0], -FORCE / 50.0, rtol=1e-10)
    np.testing.assert_allclose(a[:, 1], 0.0, atol=1e-14)


def test_inner_forces_have_no_resultant(model: MassSpring):
    r = model.straight(0.0) + 0.1 * np.random.default_rng(1).normal(size=(7, 2))
    force = model.forces(r, 0.0)
    scale = np.abs(force).max()
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12 * scale)
    moment = r[:, 0] * force[:, 1] - r[:, 1] * force[:, 0]
    assert abs(moment.sum()) < 1e-11 * scale * 5.0


def test_forces_are_the_slope_of_the_energy(model: MassSpring):
    rest = model.straight(0.0)
    r = rest + 0.05 * np.random.default_rng(2).normal(size=(7, 2))

    def energy(x: np.ndarray) -> float:
        d = np.diff(x, axis=0)
        lengths = np.hypot(*d.T)
        bend = np.diff(np.unwrap(np.arctan2(d[:, 1], d[:, 0])))
        axial = model.axial_stiffness / model.spacing / 2 * ((lengths - model.spacing) ** 2).sum()
        return float(axial + model.bending_stiffness / model.spacing / 2 * (bend**2).sum())

    h = 1e-6
    slope = np.zeros_like(r)
    for at in np.ndindex(*r.shape):
        up, down = r.copy(), r.copy()
        up[at] += h
        down[at] -= h
        slope[at] = (energy(up) - energy(down)) / (2 * h)
    np.testing.assert_allclose(model.forces(r, 0.0), -slope, atol=1e-6 * np.abs(slope).max())


def test_linearisation_written_down_is_that_of_the_forces(model: MassSpring):
    straight, h = model.straight(FORCE), 1e-6

    def across(w: np.ndarray) -> np.ndarray:
        moved = straight + np.stack((np.zeros_like(w), w), -1)
        return model.accelerations(moved, FORCE)[:, 1]

    columns = [(across(h * e) - across(-h * e)) / (2 * h) for e in np.eye(7)]
    expected = model.across(FORCE)
    np.testing.assert_allclose(np.array(columns).T, expected, atol=1e-8 * np.abs(expected).max())


def test_stiff_springs_give_the_accelerations_of_rigid_links():
    """The pull of stiff springs that hold the motion of rigid links is unknown; Newton's law of
    the points in the directions that rigid links leave open has none of it."""
    n, rng = 6, np.random.default_rng(3)
    phi, omega = 0.4 * rng.normal(size=n), rng.normal(size=n)
    scene = scenes.thrust(n, inertia="lumped", force=FORCE)
    module = rodgen.build(scene, "numpy")
    y = np.concatenate(([0.0, 0.0], phi, [0.3, -0.2], omega))
    rates = module.rhs(0.0, y, module.parameters(**scene.parameters))
    base, alpha = rates[n + 2 : n + 4], rates[n + 4 :]
    tangent, normal = (np.stack(pair, -1) for pair in (
        (np.cos(phi), np.sin(phi)), (-np.sin(phi), np.cos(phi))
    ))  # fmt: skip
    model = MassSpring(n, scenes.MASS, scenes.LENGTH, scenes.STIFFNESS, 1e5)
    l = model.spacing
    a = base + np.vstack(
        ([0.0, 0.0], np.cumsum(l * (alpha[:, None] * normal - omega[:, None] ** 2 * tangent), 0))
    )
    r = np.vstack(([0.0, 0.0], np.cumsum(l * tangent, 0)))
    rest = model.masses[:, None] * a - model.forces(r, FORCE)  # what rigid links must hold
    for j in range(n):  # a turn of link j moves all points behind it
        assert abs((rest[j + 1 :] @ normal[j]).sum()) < 1e-10 * FORCE
    np.testing.assert_allclose(rest.sum(axis=0), 0.0, atol=1e-10 * FORCE)


def test_critical_force_meets_that_of_lumped_links():
    off, order, rest = compliance(10)
    assert 0 < off < 0.01
    assert order == pytest.approx(1.0, abs=0.02)
    assert abs(rest) < 1e-6


def test_order_in_the_number_of_links_is_two():
    n = (10, 20, 40)
    found = richardson(n, [critical_load(scenes.thrust(k, inertia="lumped")).value for k in n])
    stiff = richardson(n, [rod(k, 1e10).critical_load() for k in n])
    assert stiff.orders[-1] == pytest.approx(2.0, abs=0.1)
    assert stiff.value == pytest.approx(found.value, rel=1e-6)


def test_critical_force_by_eigenvalues_and_by_simulation():
    model = rod(5, 1e6)  # softer springs allow longer steps
    exact = model.critical_load()
    found = simulated_critical_load(model, 0.9 * exact, 1.15 * exact, 20.0, 30.0)
    assert found == pytest.approx(exact, rel=0.01)  # what 20 s of growth leave open
    with pytest.raises(ValueError, match="no growth"):
        simulated_critical_load(model, 0.5 * exact, 0.6 * exact, 2.0, 30.0)


def test_growth_is_seen_beyond_the_critical_force_alone():
    model = rod(5, 1e6)
    exact = model.critical_load()
    result = grow(model, np.array([0.8, 1.1]) * exact, 10.0)
    assert result.grown[0] < 5
    assert result.grown[1] > 100


def test_no_flutter_is_said():
    with pytest.raises(ValueError, match="no flutter"):
        MassSpring(1, 50.0, 5.0, 100.0, 1e6).critical_load()
