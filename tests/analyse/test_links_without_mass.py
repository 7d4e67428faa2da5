"""Rods whose links have no mass, or little: published critical loads, matrices put together by
hand, eigenvalues by QZ, and limits as the mass goes to zero."""

from __future__ import annotations

import re
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import scipy

import rodgen
from rodgen import Scene
from rodgen.analyse.massless import regular_pencil
from rodgen.analyse.pencil import DensePencil
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import find_steady_state, pencil_about
from rodgen.errors import AnalysisError, InputError

PUSHED = {"follower": {"force": 1.0}}
TWO = [(0.5, 1.0), (1.0, 1.0)]


def _rod(
    mass: float, bodies: list[tuple[float, float]], links: int = 4, loads: Any = None, **tables: Any
) -> Scene:
    """Rod of unit length and stiffness with bodies (s, mass)."""
    table = {"links": links, "length": 1.0, "bending_stiffness": 1.0, "boundary": "clamped"}
    return Scene(
        name="light",
        rod=table | {"mass": mass} | tables.pop("rod", {}),
        bodies=[{"name": f"body{i}", "at": s, "mass": m} for i, (s, m) in enumerate(bodies)],
        loads=PUSHED if loads is None else loads,
        **tables,
    )


@pytest.mark.parametrize(("first", "due"), [(1.0, 14.384872), (0.1, 17.335564)])
def test_a_column_without_mass_flutters_at_the_published_load(first: float, due: float) -> None:
    """Two masses on a column under a follower force, extrapolated twice in 1/n^2."""
    bodies = [(0.5, first), (1.0, 1.0)]
    found = np.array([rodgen.critical_load(_rod(0.0, bodies, n)).value for n in (20, 40, 80)])
    once = (4 * found[1:] - found[:-1]) / 3
    assert (16 * once[1] - once[0]) / 15 == pytest.approx(due, abs=1e-6)
    for mass in (1e-12, 1e-9, 1e-6):
        near = rodgen.critical_load(_rod(mass, bodies, 20))
        assert near.kind == "flutter"
        assert near.value == pytest.approx(found[0], abs=1e-8 + 10 * mass)


def test_modes_are_those_of_the_masses_alone() -> None:
    """By the stiffness of the joints across the rod, put together by hand, of which those without
    mass are in equilibrium."""
    n = 4
    bend = np.zeros((n, n + 2))  # of joints 0 to 3, by y at the clamp, at its image, and at 1 to 4
    for joint in range(n):
        row = np.zeros(n + 2)
        row[joint : joint + 3] = n * np.array([1.0, -2.0, 1.0])
        bend[joint] = row
    bend[0] = 0.0
    bend[0, 2] = n  # the first link turns against the clamp
    stiffness = n * np.array([2.0, 1.0, 1.0, 1.0])
    K = (bend[:, 2:].T * stiffness) @ bend[:, 2:]
    heavy, still = [1, 3], [0, 2]
    lean = np.linalg.solve(K[np.ix_(still, still)], K[np.ix_(still, heavy)])
    squares, shapes = np.linalg.eigh(K[np.ix_(heavy, heavy)] - K[np.ix_(heavy, still)] @ lean)
    found = rodgen.natural_modes(_rod(0.0, TWO, n, loads={}), 5)
    np.testing.assert_allclose(found.frequencies, np.sqrt(squares) / (2 * np.pi), rtol=1e-11)
    across = np.zeros((2, n))
    across[:, heavy], across[:, still] = shapes.T, -shapes.T @ lean.T
    turned = np.diff(across, prepend=0.0)
    for due, shown in zip(turned, np.real(found.phi), strict=True):
        at = np.abs(due).argmax()
        np.testing.assert_allclose(shown / shown[at], due / due[at], atol=1e-10)


@pytest.mark.parametrize("damped", [0, 1, 3])
def test_reduced_equations_have_the_finite_eigenvalues_of_the_whole(damped: int) -> None:
    """Six coordinates, three of them without inertia, some of these damped, against QZ."""
    draw = np.random.default_rng(5)
    turn = np.linalg.qr(draw.normal(size=(6, 6)))[0]
    sizes = np.array([2.0, 1.0, 3.0, 0.0, 0.0, 0.0])
    M = turn.T @ np.diag(sizes) @ turn
    K = draw.normal(size=(6, 6)) + 6 * np.eye(6)
    felt = turn[: 3 + damped]
    C = felt.T @ np.diag(draw.uniform(0.5, 1.0, 3 + damped)) @ felt
    whole = DensePencil(K, C, M)
    one, nothing = np.eye(6), np.zeros((6, 6))
    A, B = np.block([[nothing, one], [-K, -C]]), np.block([[one, nothing], [nothing, M]])
    pairs = scipy.linalg.eig(A, B, right=False, homogeneous_eigvals=True)
    finite = np.abs(pairs[1]) > 1e-12 * np.abs(pairs[0])
    due = pairs[0][finite] / pairs[1][finite]
    reduced = regular_pencil(whole)
    K, C, M = reduced.pencil.parts
    own, size = reduced.pencil.size - reduced.pencil.added, reduced.pencil.size
    assert (own, reduced.pencil.added) == (3, damped)
    first = np.zeros((own + size, own + size))
    first[:own, size:] = np.eye(own)
    first[own:size, :size], first[own:size, size:] = -K[own:], -C[own:, :own]
    rates = np.hstack((-K[:own], -C[:own, :own]))
    first[size:] = np.linalg.solve(M[:own, :own], rates)
    found = np.linalg.eigvals(first)
    assert len(found) == len(due)
    apart = np.abs(found[:, None] - due)
    assert (apart.min(axis=0) <= 1e-9 * np.abs(due)).all()
    assert (apart.min(axis=1) <= 1e-9 * np.abs(found)).all()


def test_links_without_mass_buckle_between_what_has_some() -> None:
    """With one body at the tail they do so where, with little mass, a motion as fast as that lets
    it be begins to grow."""
    with pytest.raises(AnalysisError, match="without mass buckle") as told:
        rodgen.critical_load(_rod(0.0, [(1.0, 1.0)], 3))
    where = float(re.search(r"at ([\d.]+) N", str(told.value)).group(1))  # type: ignore[union-attr]
    near = [rodgen.critical_load(_rod(mass, [(1.0, 1.0)], 3)).value for mass in (1e-7, 1e-9)]
    limit = near[1] + (near[1] - near[0]) / 9  # of an error that falls with the root of the mass
    assert where == pytest.approx(limit, rel=1e-5)


CASES: dict[str, dict[str, Any]] = {
    "damped": {"loads": PUSHED | {"material_damping": {"time": 0.05}}},
    "viscous": {"loads": PUSHED | {"viscous_drag": {"normal": 0.3, "tangential": 0.1}}},
    "held": {"supports": [{"at": 0.6, "stiffness": [0.0, 3.0], "damping": [0.0, 0.2]}]},
    "founded": {"foundation": {"stiffness": 2.0, "damping": 0.3}},
    "steered": {
        "loads": {"follower": {"force": 1.0, "angle": "g"}},
        "states": {"g": {"rate": "(-0.1*phi(1)-g)/0.2"}},
    },
    "hangs": {
        "loads": PUSHED | {"gravity": {"g": 0.3}},
        "rod": {"boundary": "pinned", "inertia": "lumped"},
        "initial": {"phi": "-pi/2"},
    },
}


@pytest.mark.parametrize("case", CASES)
def test_critical_loads_and_modes_are_limits(case: str) -> None:
    """What lacks mass changes by its mass alone."""
    found = [_rod(mass, TWO, **CASES[case]) for mass in (0.0, 1e-9)]
    one, two = (rodgen.natural_modes(scene, 2) for scene in found)
    np.testing.assert_allclose(one.frequencies, two.frequencies, rtol=1e-7)
    np.testing.assert_allclose(one.growth, two.growth, rtol=1e-6, atol=1e-8)
    loads = [rodgen.critical_load(scene, bounds=(None, 40.0)).value for scene in found]
    assert loads[0] == pytest.approx(loads[1], rel=1e-6)


@pytest.mark.parametrize("tail", [1.07, 3.0])
def test_free_rods_in_a_wind_turn_from_some_thrust_on(tail: float) -> None:
    loads = PUSHED | {"viscous_drag": {"normal": 0.3, "tangential": 0.1}}
    bodies = [(0.0, 1.0), (0.5, 0.7), (1.0, tail)]
    one, two, even = (
        rodgen.critical_load(_rod(mass, bodies, 4, loads, rod={"boundary": "free"})).value
        for mass in (0.0, 1e-9, 1e-2)
    )
    assert one == pytest.approx(two, rel=1e-8, abs=0)
    assert one == pytest.approx(even, rel=0.02, abs=0)


def test_slow_motions_beside_fast_ones_to_50_digits() -> None:
    """Of links of 1e-9 kg between masses of 1 kg, whose rates are 1e4 times as large."""
    scene = _rod(1e-9, TWO, 4, PUSHED | {"material_damping": {"time": 0.05}})
    found = rodgen.natural_modes(scene, 2)
    whole = pencil_about(find_steady_state(SteadyRod.of(rodgen.System(scene)))).to_dense()
    K, C, M = whole.parts
    with mp.workdps(50):
        inverse = mp.matrix(M) ** -1
        first = mp.zeros(8)
        first[:4, 4:], first[4:, :4] = mp.eye(4), -inverse * mp.matrix(K)
        first[4:, 4:] = -inverse * mp.matrix(C)
        exact = np.array([complex(s) for s in mp.eig(first, left=False, right=False)])
    slow = sorted(exact[exact.imag > 0], key=abs)[:2]
    np.testing.assert_allclose(found.growth + 2j * np.pi * found.frequencies, slow, rtol=1e-9)


@pytest.mark.parametrize("gravity", [{}, {"gravity": {}}])
def test_equilibria_have_no_need_of_mass(gravity: dict[str, Any]) -> None:
    loads = {"tip": {"y": -1.0}} | gravity
    one, two = (rodgen.static_equilibrium(_rod(mass, TWO, 8, loads)) for mass in (0.0, 1e-9))
    np.testing.assert_allclose(one.phi, two.phi, rtol=0, atol=1e-8 if gravity else 1e-12)
    assert one.stable
    assert two.stable


def test_a_branch_of_a_rod_without_mass_finds_where_it_buckles() -> None:
    scene = _rod(0.0, TWO, 8, {"tip": {"x": -1.0}})
    branch = rodgen.continue_equilibria(scene, "loads.tip.x", (0.0, -8.0))
    due = rodgen.critical_load(_rod(1.0, [], 8, {"tip": {"x": -1.0}}), load="tip").value
    assert branch.special_value.item() == pytest.approx(-due, rel=1e-9)


def test_runs_that_lack_a_mass_name_the_joint() -> None:
    scene = _rod(0.0, [(1.0, 1.0)])
    for run in (
        lambda: rodgen.simulate(scene, progress=False),
        lambda: rodgen.natural_modes(scene, 2, frozen=True),
        lambda: rodgen.simulate_many(scene, {"loads.follower.force": [1.0, 2.0]}),
        lambda: rodgen.critical_load(_rod(0.0, TWO), simulate=1.0),
    ):
        with pytest.raises(InputError, match="joint 1 has no mass") as told:
            run()
        assert told.value.field == "rod.mass"
    with pytest.warns(rodgen.DoubtWarning, match="joint 1"):
        assert rodgen.describe(scene).choice is None


def test_links_without_mass_between_bodies_in_every_joint_run() -> None:
    """Lumped links with all their mass in bodies, against links that have it themselves."""
    own = _rod(1.0, [], 2, {}, rod={"inertia": "lumped"}, initial={"phi": [0.1, 0.3]})
    bodies = [(0.5, 0.5), (1.0, 0.25)]
    bare = _rod(0.0, bodies, 2, {}, rod={"inertia": "lumped"}, initial={"phi": [0.1, 0.3]})
    one, two = (rodgen.natural_modes(scene, 2).frequencies for scene in (own, bare))
    np.testing.assert_allclose(one, two, rtol=1e-12)
    settings = {"span": (0.0, 0.1), "target": "numpy", "progress": False}
    runs = [rodgen.simulate(scene, **settings) for scene in (own, bare)]
    np.testing.assert_allclose(runs[0].phi[-1], runs[1].phi[-1], rtol=1e-7)


def test_damping_by_the_mass_of_links_is_told_to_damp_nothing() -> None:
    scene = _rod(0.0, TWO, loads=PUSHED | {"internal_damping": {"coefficient": 0.3}})
    found = rodgen.critical_load(scene)
    assert found.value == rodgen.critical_load(_rod(0.0, TWO)).value
    assert any("damps nothing" in str(note) for note in found.notes)


@pytest.mark.parametrize("key", ["mass", "mass_per_length"])
def test_a_rod_without_any_mass_is_refused(key: str) -> None:
    with pytest.raises(InputError, match="above 0"):
        Scene(
            name="nothing",
            rod={"links": 2, "length": 1.0, "bending_stiffness": 1.0, key: 0.0},
            loads=PUSHED,
        )
