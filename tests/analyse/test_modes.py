"""Natural frequencies and shapes: against 50 digits, the continuum, hanging chains, runs."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np
import pytest
import scipy

import rodgen
from rodgen.analyse.extrapolation import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references.continuum import chain_frequency, natural_frequency
from rodgen.errors import InputError
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.analyse.rods import LENGTH, SIZES, THRUST, are_among, eigenvalues, exact_rates, rod
from tests.palette import cases
from tests.sets import sets

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
def test_motions_to_eight_digits(boundary: str, inertia: str, loads: str) -> None:
    scene = rod(3, boundary, LOADS[loads], inertia=inertia)
    found, rates = natural_modes(scene, 20), exact_rates(scene)
    # Beside what oscillates, tail fins at rest leave a turning of the rod that grows.
    turning = [s for s in rates if s.real > 1e-6 and abs(s.imag) < 1e-9 * abs(s)]
    expected = turning + sorted((s for s in rates if s.imag > 1e-9 * abs(s)), key=lambda s: s.imag)
    # Two that flutter have one frequency, in either order.
    expected.sort(key=lambda s: (float(abs(s.imag)), float(s.real)))
    places = np.lexsort((found.growth, found.frequencies.round(9)))
    size = np.array([float(abs(s)) for s in expected])
    frequencies = [float(s.imag / 2 / mp.pi) for s in expected]
    np.testing.assert_allclose(found.frequencies, frequencies, rtol=1e-8, atol=1e-20)
    growth = found.growth[places]
    assert (np.abs(growth - [float(s.real) for s in expected]) <= 1e-7 * size).all()
    grows = any(abs(s.real) > 1e-9 * abs(s) for s in expected)  # by damping, or by flutter
    assert found.growth.any() == grows
    assert 2 * len(expected) - len(turning) + found.overdamped == len(rates)


def test_overdamped_motions_take_no_places() -> None:
    for coefficient in (30.0, 300.0, 3000.0):
        scene = rod(40, "clamped", {"internal_damping": {"coefficient": coefficient}})
        s = eigenvalues(scene)
        expected = np.sort(s.imag[s.imag > 1e-6 * np.abs(s)]) / (2 * np.pi)
        found = natural_modes(scene, 5).frequencies
        # All eigenvalues of a matrix with norm 1e8 are right to about 1e-7.
        np.testing.assert_allclose(found, expected[:5], rtol=1e-5)


@pytest.mark.parametrize(("boundary", "count"), sets([("free", 3)], slow=[("clamped", 4)]))
def test_sparse_and_dense_agree(boundary: str, count: int) -> None:
    scene = rod(30, boundary, {"follower": {"force": 10.0}})
    few, all_of = natural_modes(scene, count), natural_modes(scene, 30)
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
        pytest.param("free", "lumped", 2, marks=pytest.mark.slow),
        pytest.param("pinned", "uniform", 4, marks=pytest.mark.slow),
        # Half a link bends at a root spring of 2 EI/l, else the order would be one.
        ("clamped", "uniform", 2),
        pytest.param("clamped", "lumped", 2, marks=pytest.mark.slow),
    ],
)
def test_extrapolated_frequencies_are_those_of_the_continuum(
    boundary: str, inertia: str, order: int
) -> None:
    n = [10, 20, 40]
    rods = [rod(k, boundary, {"follower": {"force": 0.0}}, inertia=inertia) for k in n]
    values = [natural_modes(one, 2).frequencies for one in rods]
    for mode in (0, 1):
        found = richardson(n, [v[mode] for v in values], order=[order, order + 2])
        exact = natural_frequency(boundary, mode + 1, **SIZES)
        # Of the second mode, with terms of fourth and sixth order that are not small at n = 10.
        assert found.orders[-1] == pytest.approx(order, abs=0.4)
        assert abs(found.value - exact) <= found.error < 3e-4 * exact


def test_chains_and_rods_that_hang() -> None:
    """A chain, or springs that are too soft to count, against Bessel's zeros; hard springs, against
    a rigid pendulum: none is taken for a rod that turns freely."""
    chain = [chain_frequency(k, gravity=9.81, length=5.0) for k in (1, 2, 3)]
    pendulum = np.sqrt(1.5 * 9.81 / 5.0) / (2 * np.pi)
    for n, stiffness, expected, accuracy in (
        # Second order in 1/n with a factor of a few squared wave numbers.
        (200, 0.0, chain, 1e-3),
        (30, 1e-10, chain[:1], 1e-2),
        (30, 1e7, [pendulum], 1e-5),
    ):
        hung = rod(n, "pinned", {"gravity": {}}, bending_stiffness=stiffness)
        found = natural_modes(hung, len(expected))
        assert found.rigid == 0
        np.testing.assert_allclose(found.frequencies, expected, rtol=accuracy)


def test_frequency_about_a_bent_equilibrium_is_that_of_a_run() -> None:
    loads = {"gravity": {"g": 2.0}}
    scene = rod(4, "clamped", loads)
    rest = rodgen.static_equilibrium(scene)
    modes = natural_modes(scene, 4)
    shape = modes.phi[0] / np.abs(modes.phi[0]).max()
    period = 1 / modes.frequencies[0]
    moved = {"initial": {"phi": (rest.phi + 1e-5 * shape).tolist()}}
    run = {"span": [0.0, float(period)], "rtol": 1e-11, "atol": 1e-14}
    solution = rodgen.simulate(rod(4, "clamped", loads, **moved, integrate=run), target="numpy")
    # Back after a period, but for what is of second order in an amplitude of 1e-5.
    np.testing.assert_allclose(solution.phi[-1] - rest.phi, 1e-5 * shape, atol=1e-9)


def test_shapes_keep_the_centre_of_gravity() -> None:
    modes = natural_modes(rod(30, "free"), 3)
    assert np.abs(modes.displacements).max(axis=(1, 2)) == pytest.approx(1.0)
    weights = np.ones(31)
    weights[[0, -1]] = 0.5  # of uniform links: the middle of each is the mean of its ends
    np.testing.assert_allclose(weights @ modes.displacements[:, :, 1].T, 0.0, atol=1e-6)


def test_what_grows_is_seen_among_motions_that_die_away() -> None:
    """Strong damping and thrust give dozens of motions that are gone within a period, with
    frequencies next to zero. Growth begins where `critical_load`, by other matrices, finds it."""
    for time in (0.001, 0.1, 1.0):
        damping = {"material_damping": {"time": time}}
        force = rodgen.critical_load(rod(50, "clamped", THRUST | damping)).value
        for factor, grows in ((0.999, False), (1.001, True), (2.0, True)):
            pushed = rod(50, "clamped", {"follower": {"force": factor * force}} | damping)
            assert (natural_modes(pushed, count=1).growth.max() > 0) == grows


@pytest.mark.parametrize(("boundary", "rigid"), [("free", 3), ("pinned", 1)])
def test_one_link_that_turns_freely_has_no_modes(boundary: str, rigid: int) -> None:
    found = natural_modes(rod(1, boundary))
    assert (len(found.frequencies), found.rigid) == (0, rigid)
    assert found.displacements.shape == (0, 2, 2)


# Modes about a shape, as if the rod stood still in it ------------------------------------------


@pytest.mark.parametrize("angle", [-np.pi / 2, 0.6, np.pi / 2])
def test_a_pendulum_held_at_any_angle(angle: float) -> None:
    """Of a uniform link, phi'' = -3 g/(2 L) cos phi: its derivative is what the motion grows by, or
    swings with; gravity, which pulls it away from there, is left out, and that is said."""
    squared = 1.5 * 9.81 / LENGTH * np.sin(angle)
    found = natural_modes(
        rod(1, "pinned", {"gravity": {}}, initial={"phi": angle, "omega": 3.0}), frozen=True
    )
    s = found.growth[0] + 2j * np.pi * found.frequencies[0]
    assert s**2 == pytest.approx(squared, rel=1e-12)
    assert (found.rigid, found.stable) == (0, bool(squared < 0))
    assert any("not at rest" in note.text for note in found.notes) == (abs(np.cos(angle)) > 1e-9)
    size = LENGTH * max(abs(np.sin(angle)), abs(np.cos(angle)))  # the tail moves by that a radian
    assert np.abs(found.phi) == pytest.approx(np.array([[1 / size]]), rel=1e-8)


def test_motions_at_no_rate_are_rounding() -> None:
    """Of a link that is pushed through its pin, and of chains without stiffness, which are bent by
    nothing: more than their rigid motions stand still."""
    pushed = natural_modes(rod(1, "pinned", THRUST, initial={"phi": 0.3}), frozen=True)
    assert (len(pushed.frequencies), pushed.rigid, pushed.notes) == (0, 1, ())
    for boundary, rigid in (("free", 3), ("pinned", 1)):
        chain = rod(3, boundary, initial={"phi": "0.2*s"}, bending_stiffness=0.0)
        found = natural_modes(chain, frozen=True)
        assert (len(found.frequencies), found.rigid) == (0, rigid)
        assert str(rigid) in str(found)
    falling = natural_modes(rod(3, "free", {"gravity": {}}), frozen=True)
    assert not any("not at rest" in note.text for note in falling.notes)


def test_frozen_in_an_equilibrium_modes_are_those_about_it() -> None:
    scene = rod(4, "clamped", {"gravity": {"g": 2.0}} | THRUST)
    rest = rodgen.static_equilibrium(scene)
    found = natural_modes(rodgen.System(scene).at(y0=rest.y), 3, frozen=True)
    wanted = natural_modes(scene, 3)
    assert found.frequencies == pytest.approx(wanted.frequencies, rel=1e-8)
    for one, other in zip(found.displacements, wanted.displacements, strict=True):
        np.testing.assert_allclose(one, np.sign((one * other).sum()) * other, atol=1e-6)


def test_a_pair_that_grows_is_one_mode_about_any_shape() -> None:
    """Beck's column beyond its critical load, upright as at its start."""
    scene = rod(4, "clamped", {"follower": {"force": 120.0}})
    found, wanted = natural_modes(scene, 2, frozen=True), natural_modes(scene, 2)
    assert wanted.growth.max() > 0.1
    assert found.frequencies == pytest.approx(wanted.frequencies, rel=1e-9)
    assert sorted(found.growth) == pytest.approx(sorted(wanted.growth), rel=1e-9)


def test_frozen_after_a_run() -> None:
    """In the shape that the rod has come to, whatever its speed: those of a start in that shape."""
    scene = rod(3, "free", {"gravity": {}}, initial={"phi": "0.3*s", "velocity": [3.0, -1.0]})
    found = natural_modes(scene, 3, after=0.5, frozen=True)
    y = rodgen.simulate(scene, span=[0.0, 0.5], progress=False, target="numpy").y[-1]
    begun = natural_modes(rodgen.System(scene).at(y0=y), 3, frozen=True)
    assert found.rigid == 3  # no load turns it back
    assert found.frequencies == pytest.approx(begun.frequencies, rel=1e-6)  # of two targets
    s = eigenvalues(scene, np.where(np.arange(len(y)) < len(y) // 2, y, 0.0))
    are_among(found, s)
    with pytest.raises(InputError, match="speed"):
        natural_modes(scene, speed=1.0, frozen=True)


def test_a_free_rod_on_one_spring_across_it_slides_and_swings() -> None:
    """Frequencies by matrices of the displacements of the joints, put together by hand; sliding
    along the rod has none."""
    n, mass, stiffness, spring, at = 6, 2.0, 3.0, 40.0, 0.3
    table = {"links": n, "length": 1.0, "mass": mass, "bending_stiffness": stiffness}
    supports = [{"at": at, "stiffness": [0.0, spring]}]
    scene = rodgen.Scene(name="held", rod={**table, "boundary": "free"}, supports=supports)
    K, M = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    for link in range(n):
        M[link : link + 2, link : link + 2] += mass / n / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
    for joint in range(1, n):
        bend = np.zeros(n + 1)
        bend[joint - 1 : joint + 2] = n * np.array([1.0, -2.0, 1.0])
        K += n * stiffness * np.outer(bend, bend)
    place = np.maximum(1 - np.abs(np.arange(n + 1) - at * n), 0.0)
    K += spring * np.outer(place, place)
    squares = scipy.linalg.eigh(K, M, eigvals_only=True)[1:]  # swinging about the spring is free
    found = natural_modes(scene, 5)
    np.testing.assert_allclose(found.frequencies, np.sqrt(squares[:5]) / (2 * np.pi), rtol=1e-11)
