"""Natural frequencies and shapes: against 50 digits, the continuum, hanging chains, runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import rodgen
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.extrapolate import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references.continuum import chain_frequency, natural_frequency
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.scene import Scene, SceneError
from tests.palette import cases

Rod = Callable[..., Scene]
THRUST = {"follower": {"force": 50.0}}


FINS = [1.0, 1.0, 2.0, 4.0]
LOADS: dict[str, dict[str, Any]] = {
    "none": {},
    "thrust": THRUST,
    "damped": THRUST | {"internal_damping": {"coefficient": 0.3}},
    "with fins": THRUST | {"external_damping": {"coefficient": 0.4, "fin_factor": FINS}},
    # Rates of 1e-5 and 1e10 1/s stand beside each other.
    "beyond measure": {"internal_damping": {"coefficient": 1e6}},
}


@cases("boundary, inertia, loads", BOUNDARIES, INERTIAS, LOADS)
def test_motions_to_eight_digits(
    rod: Rod, exact_rates: Any, boundary: str, inertia: str, loads: str
) -> None:
    scene = rod(3, boundary, LOADS[loads], inertia=inertia)
    found, rates = natural_modes(scene, 20), exact_rates(scene)
    # Beside what oscillates, tail fins at rest leave a turning of the rod that grows.
    turning = [s for s in rates if s.real > 1e-6 and abs(s.imag) < 1e-9 * abs(s)]
    expected = turning + sorted((s for s in rates if s.imag > 1e-9 * abs(s)), key=_imaginary)
    size = np.array([float(abs(s)) for s in expected])
    frequencies = [float(s.imag / 2 / mp.pi) for s in expected]
    np.testing.assert_allclose(found.frequencies, frequencies, rtol=1e-8, atol=1e-20)
    assert (np.abs(found.growth - [float(s.real) for s in expected]) <= 1e-7 * size).all()
    grows = any(abs(s.real) > 1e-9 * abs(s) for s in expected)  # by damping, or by flutter
    assert found.growth.any() == grows
    assert 2 * len(expected) - len(turning) + found.overdamped == len(rates)


def _imaginary(s: Any) -> Any:
    return s.imag


@pytest.mark.parametrize("coefficient", [30.0, 300.0, 3000.0])
def test_overdamped_motions_take_no_places(rod: Rod, coefficient: float) -> None:
    scene = rod(40, "clamped", {"internal_damping": {"coefficient": coefficient}})
    model = rodgen.build(scene)
    s = np.linalg.eigvals(
        model.jac(0.0, scene.initial_state(), model.parameters(**scene.parameters))
    )
    expected = np.sort(s.imag[s.imag > 1e-6 * np.abs(s)]) / (2 * np.pi)
    found = natural_modes(scene, 5).frequencies
    # All eigenvalues of a matrix with norm 1e8 are right to about 1e-7.
    np.testing.assert_allclose(found, expected[:5], rtol=1e-5)


@pytest.mark.parametrize(("boundary", "count"), [("free", 3), ("clamped", 4), ("pinned", 2)])
def test_sparse_and_dense_agree(rod: Rod, boundary: str, count: int) -> None:
    scene = rod(20, boundary, THRUST)
    few, all_of = natural_modes(scene, count), natural_modes(scene, 20)
    # The dense route loses the ratio of the largest to the lowest squared frequency, 1e6.
    np.testing.assert_allclose(few.frequencies, all_of.frequencies[:count], rtol=1e-9)
    for one, other in zip(few.displacements, all_of.displacements, strict=False):
        sign = np.sign((one * other).sum())
        np.testing.assert_allclose(one, sign * other, atol=1e-6)


@pytest.mark.parametrize(
    ("boundary", "inertia", "order"),
    [
        # For uniform links without a clamp the errors of stiffness and of rotary inertia cancel.
        ("free", "uniform", 4),
        ("free", "lumped", 2),
        ("pinned", "uniform", 4),
        # Half a link bends at a root spring of 2 EI/l, else the order would be one.
        ("clamped", "uniform", 2),
        ("clamped", "lumped", 2),
    ],
)
def test_extrapolated_frequencies_are_those_of_the_continuum(
    rod: Rod, boundary: str, inertia: str, order: int
) -> None:
    n = [10, 20, 40]
    rods = [rod(k, boundary, {"follower": {"force": 0.0}}, inertia=inertia) for k in n]
    values = [natural_modes(one, 2).frequencies for one in rods]
    for mode in (0, 1):
        found = richardson(n, [v[mode] for v in values], order=[order, order + 2])
        exact = natural_frequency(boundary, mode + 1, **_sizes())
        # Of the second mode, with terms of fourth and sixth order that are not small at n = 10.
        assert found.orders[-1] == pytest.approx(order, abs=0.4)
        assert abs(found.value - exact) <= found.error < 3e-4 * exact


def _sizes() -> dict[str, float]:
    return {"mass": 50.0, "length": 5.0, "bending_stiffness": 100.0}


def test_hanging_chain(rod: Rod) -> None:
    scene = rod(200, "pinned", {"gravity": {}}, bending_stiffness=0.0)
    found = natural_modes(scene, 3)
    expected = [chain_frequency(k, gravity=9.81, length=5.0) for k in (1, 2, 3)]
    # Second order in 1/n with a factor of a few squared wave numbers.
    np.testing.assert_allclose(found.frequencies, expected, rtol=1e-3)
    assert found.rigid == 0


def test_frequency_about_a_bent_equilibrium_is_that_of_a_run(rod: Rod) -> None:
    scene = rod(6, "clamped", {"gravity": {"g": 2.0}})
    rest = rodgen.static_equilibrium(scene)
    modes = natural_modes(scene, 6)
    shape = modes.phi[0] / np.abs(modes.phi[0]).max()
    period = 1 / modes.frequencies[0]
    moved = scene.model_dump(exclude_none=True)
    moved["initial"] = {"phi": (rest.phi + 1e-5 * shape).tolist()}
    moved["integrate"] = {"span": [0.0, float(period)], "rtol": 1e-11, "atol": 1e-14}
    solution = rodgen.simulate(Scene.from_dict(moved), target="numpy")
    # Back after a period, but for what is of second order in an amplitude of 1e-5.
    np.testing.assert_allclose(solution.phi[-1] - rest.phi, 1e-5 * shape, atol=1e-9)


def test_shapes_keep_the_centre_of_gravity(rod: Rod) -> None:
    modes = natural_modes(rod(30, "free"), 3)
    assert np.abs(modes.displacements).max(axis=(1, 2)) == pytest.approx(1.0)
    weights = np.ones(31)
    weights[[0, -1]] = 0.5  # of uniform links: the middle of each is the mean of its ends
    np.testing.assert_allclose(weights @ modes.displacements[:, :, 1].T, 0.0, atol=1e-6)


def test_a_rod_beyond_its_critical_force_grows(rod: Rod) -> None:
    found = natural_modes(rod(10, "clamped", {"follower": {"force": 90.0}}), 3)
    assert found.growth.max() > 0
    assert found.growth[0] == pytest.approx(-found.growth[1])
    assert found.frequencies[0] == pytest.approx(found.frequencies[1])


@pytest.mark.parametrize("time", [0.001, 0.1, 1.0])
def test_what_grows_is_seen_among_motions_that_die_away(rod: Rod, time: float) -> None:
    """Strong damping and thrust give dozens of motions that are gone within a period, with
    frequencies next to zero. Growth begins where `critical_force`, by other matrices, finds it."""
    scene = rod(50, "clamped", THRUST | {"material_damping": {"time": time}})
    force = rodgen.critical_force(scene).force
    for factor, grows in ((0.999, False), (1.001, True), (2.0, True)):
        pushed = rod(
            50,
            "clamped",
            {"follower": {"force": factor * force}, "material_damping": {"time": time}},
        )
        assert (natural_modes(pushed, count=1).growth.max() > 0) == grows


@pytest.mark.parametrize("loads", [{"follower": {"force": 5.0, "angle": 0.1}}, {"tip": {"y": 1.0}}])
def test_a_free_rod_that_turns_has_no_steady_state(rod: Rod, loads: dict[str, Any]) -> None:
    with pytest.raises(AnalysisError, match="no steady state"):
        natural_modes(rod(4, "free", loads))


def test_external_damping_about_a_bent_state_is_refused(rod: Rod) -> None:
    loads = {"gravity": {}, "external_damping": {"coefficient": 0.3}}
    with pytest.raises(AnalysisError, match="external damping has no linear part"):
        natural_modes(rod(4, "clamped", loads))


@pytest.mark.parametrize(("boundary", "rigid"), [("free", 3), ("pinned", 1)])
def test_one_link_that_turns_freely_has_no_modes(rod: Rod, boundary: str, rigid: int) -> None:
    found = natural_modes(rod(1, boundary))
    assert (len(found.frequencies), found.rigid) == (0, rigid)
    assert found.displacements.shape == (0, 2, 2)


@pytest.mark.parametrize("stiffness", [1e-10, 1e7])
def test_soft_and_hard_springs_beside_gravity(rod: Rod, stiffness: float) -> None:
    """Hard, a rigid pendulum; soft, a chain: neither is taken for a rod that turns freely."""
    found = natural_modes(rod(30, "pinned", {"gravity": {}}, bending_stiffness=stiffness), 1)
    assert found.rigid == 0
    if stiffness > 1:
        expected, accuracy = np.sqrt(1.5 * 9.81 / 5.0) / (2 * np.pi), 1e-5
    else:
        expected, accuracy = chain_frequency(1, gravity=9.81, length=5.0), 1e-2
    assert found.frequencies[0] == pytest.approx(expected, rel=accuracy)


def test_no_modes_asked_for(rod: Rod) -> None:
    with pytest.raises(SceneError, match="count = 0"):
        natural_modes(rod(4, "free"), 0)
