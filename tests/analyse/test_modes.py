"""Natural frequencies and shapes: against 50 digits, the continuum, hanging chains, runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import rodgen
from rodgen.analyse.continuum import chain_frequency, natural_frequency
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.extrapolate import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.scene import Scene, SceneError

Rod = Callable[..., Scene]
BOUNDARIES = ("free", "clamped", "cantilever", "pinned")
THRUST = {"follower": {"force": 50.0}}


def _hertz(squares: list[Any]) -> list[Any]:
    return [mp.sqrt(-square) / (2 * mp.pi) for square in squares]


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("inertia", ["uniform", "lumped"])
@pytest.mark.parametrize("force", [0.0, 50.0])
def test_frequencies_to_nine_digits(
    rod: Rod, exact: Any, boundary: str, inertia: str, force: float
) -> None:
    loads = {"follower": {"force": force}}
    found = natural_modes(rod(5, boundary, loads, inertia=inertia), 20)
    expected = _hertz(exact(5, boundary, lumped=inertia == "lumped").squares(mp.mpf(force)))
    assert len(found.frequencies) == len(expected)
    np.testing.assert_allclose(found.frequencies, [float(f.real) for f in expected], rtol=1e-9)
    assert not found.growth.any()


@pytest.mark.parametrize("boundary", ["free", "clamped", "pinned"])
@pytest.mark.parametrize("external", [False, True])
def test_damped_frequencies_to_nine_digits(
    rod: Rod, exact: Any, boundary: str, external: bool
) -> None:
    fins = [1.0, 1.0, 1.0, 2.0, 1.0, 4.0]
    damping = (
        {"external_damping": {"coefficient": 0.4, "fin_factor": fins}}
        if external
        else {"internal_damping": {"coefficient": 0.3}}
    )
    found = natural_modes(rod(5, boundary, THRUST | damping), 20)
    model = exact(5, boundary)
    C = model.external_damping(0.4, fins) if external else model.internal_damping(0.3)
    # Beside what oscillates, tail fins at rest leave a turning of the rod that grows.
    s = [v for v in model.rates(mp.mpf(50), C) if v.imag > 0.1 or v.real > 0.1]
    s.sort(key=lambda v: v.imag)
    np.testing.assert_allclose(
        found.frequencies, [float(v.imag / 2 / mp.pi) for v in s], rtol=1e-9, atol=1e-30
    )
    np.testing.assert_allclose(found.growth, [float(v.real) for v in s], rtol=1e-7)


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("coefficient", [30.0, 1e6])
def test_no_motion_is_lost_to_heavy_damping(
    rod: Rod, exact: Any, boundary: str, coefficient: float
) -> None:
    """Rates of 1e-5 and 1e10 1/s stand beside each other."""
    found = natural_modes(rod(5, boundary, {"internal_damping": {"coefficient": coefficient}}), 20)
    model = exact(5, boundary)
    # Free and pinned rods have zeros, which 50 digits leave at 1e-15.
    rates = [
        s for s in model.rates(mp.mpf(0), model.internal_damping(coefficient)) if abs(s) > 1e-9
    ]
    moving = sorted(s.imag for s in rates if s.imag > 1e-9 * abs(s))
    np.testing.assert_allclose(found.frequencies, [float(w / 2 / mp.pi) for w in moving], rtol=1e-8)
    assert 2 * len(found.frequencies) + found.overdamped == len(rates)


@pytest.mark.parametrize("coefficient", [30.0, 300.0, 3000.0])
def test_overdamped_motions_take_no_places(rod: Rod, coefficient: float) -> None:
    scene = rod(60, "clamped", {"internal_damping": {"coefficient": coefficient}})
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
    scene = rod(40, boundary, THRUST)
    few, all_of = natural_modes(scene, count), natural_modes(scene, 40)
    # The dense route loses the ratio of the largest to the lowest squared frequency, 1e6.
    np.testing.assert_allclose(few.frequencies, all_of.frequencies[:count], rtol=1e-9)
    for one, other in zip(few.displacements, all_of.displacements, strict=False):
        sign = np.sign((one * other).sum())
        np.testing.assert_allclose(one, sign * other, atol=1e-6)


@pytest.mark.parametrize(("boundary", "name"), [("free", "free"), ("clamped", "cantilever")])
def test_extrapolated_frequencies_are_those_of_the_continuum(
    rod: Rod, boundary: str, name: str
) -> None:
    n = [10, 20, 40, 80]
    values = [natural_modes(rod(k, boundary), 2).frequencies for k in n]
    for mode in (0, 1):
        found = richardson(n, [v[mode] for v in values])
        exact = natural_frequency(name, mode + 1, **_sizes())
        assert found.value == pytest.approx(exact, rel=1e-8)
        assert abs(found.value - exact) <= 10 * found.error


def _sizes() -> dict[str, float]:
    return {"mass": 50.0, "length": 5.0, "bending_stiffness": 100.0}


def test_hanging_chain(rod: Rod) -> None:
    scene = rod(400, "pinned", {"gravity": {}}, bending_stiffness=0.0)
    found = natural_modes(scene, 3)
    expected = [chain_frequency(k, gravity=9.81, length=5.0) for k in (1, 2, 3)]
    # Second order in 1/n with a factor of a few squared wave numbers.
    np.testing.assert_allclose(found.frequencies, expected, rtol=1e-3)
    assert found.rigid == 0


def test_pendulum_of_one_link(rod: Rod) -> None:
    found = natural_modes(rod(1, "pinned", {"gravity": {}}), 1)
    # A rod about its end: omega^2 = (3/2) g/L.
    assert found.frequencies[0] == pytest.approx(np.sqrt(1.5 * 9.81 / 5.0) / (2 * np.pi), rel=1e-13)


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


def test_loads_are_those_of_the_asked_time(rod: Rod) -> None:
    scene = rod(5, "clamped", {"follower": {"force": "10*t"}})
    ramped = natural_modes(scene, t=3.0).frequencies
    np.testing.assert_array_equal(
        ramped, natural_modes(rod(5, "clamped", {"follower": {"force": 30.0}})).frequencies
    )
