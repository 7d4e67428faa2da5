"""Rods that are bent at rest, held against circles, integrals, and laws shifted by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import rodgen
from rodgen import Scene
from rodgen.loading import build
from rodgen.model.rod import BOUNDARIES
from rodgen.scene.time_laws import BENDS
from tests.told import refused

ROD: dict[str, Any] = {"links": 6, "length": 2.0, "mass": 3.0, "bending_stiffness": 40.0}


def _scene(initial: Any = None, loads: Any = None, **rod: Any) -> Scene:
    table = {"name": "rest", "rod": ROD | {"boundary": "clamped"} | rod, "loads": loads or {}}
    return Scene.from_dict(table | {"initial": initial or {"phi": "rest"}})


def _tip(scene: Scene) -> np.ndarray:
    """Where the shape at rest ends [m]."""
    shape = scene.distribution.rest_shape
    ends = np.stack((np.cos(shape), np.sin(shape))).sum(axis=1)
    return np.asarray(scene.rod.length / scene.rod.links * ends)


def test_a_clamped_rod_rests_as_a_circle_to_second_order() -> None:
    """Curvature 2/L: the errors of the tip are known to three digits."""
    circle = np.array([np.sin(2.0), 1 - np.cos(2.0)]) / 2.0
    rods = [_scene(links=n, length=1.0, rest_curvature=2.0) for n in (20, 40, 80)]
    found = [np.linalg.norm(_tip(one) - circle) for one in rods]
    assert found == pytest.approx([3.51e-4, 8.77e-5, 2.19e-5], abs=1e-6 / 2)


@pytest.mark.parametrize("form", ["2*pi", [2 * np.pi] * 21])
def test_a_whole_circle_closes(form: Any) -> None:
    closed = _scene(links=20, length=1.0, rest_curvature=form)
    found = rodgen.static_equilibrium(closed)
    np.testing.assert_allclose(found.tip, [0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_links_turn_by_the_integral_up_to_their_middles(boundary: str) -> None:
    """Of 1 + 3 s^2, over L: s + s^3, which Gauss has exactly."""
    scene = _scene(boundary=boundary, rest_curvature="(1 + 3*s**2)/2")
    middles = (np.arange(6) + 0.5) / 6
    turned = middles + middles**3
    start = 0.0 if BOUNDARIES[boundary].is_clamped else turned[0]
    due = turned - start
    if BOUNDARIES[boundary].first:
        due[0] = 0.0
    np.testing.assert_allclose(scene.distribution.rest_shape, due, atol=1e-15)


def test_values_stand_for_their_joints_and_that_at_the_tail_for_nothing() -> None:
    curvature = [3.0, -1.0, 4.0, 1.0, 5.0, 9.0, 2.0]
    one, two = (_scene(rest_curvature=[*curvature[:-1], last]) for last in (2.0, 70.0))
    l = 2.0 / 6
    due = [3.0 * l / 2, -1.0 * l, 4.0 * l, 1.0 * l, 5.0 * l, 9.0 * l]
    np.testing.assert_allclose(one.parameters["rest_angle"], due, rtol=1e-15)
    assert one.parameters["rest_angle"] == two.parameters["rest_angle"]
    held = _scene(boundary="cantilever", rest_curvature=curvature)
    due = [3.0 * l / 2 - 1.0 * l, *due[2:]]
    np.testing.assert_allclose(held.parameters["rest_angle"], due, rtol=1e-15)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_a_rod_in_its_shape_stays_there_without_energy(boundary: str) -> None:
    clamp = {"clamp_angle": 0.4} if BOUNDARIES[boundary].is_clamped else {}
    start = {"phi": "rest"} | ({} if clamp else {"angle": 0.4})
    scene = _scene(start, boundary=boundary, rest_curvature="2 - 3*s", **clamp)
    sol = rodgen.simulate(scene, span=(0.0, 1.0), target="numpy", method="dop853")
    # Rounding of angles of 1 rad, which grows over some thousand steps.
    assert np.abs(sol.phi - sol.phi[0]).max() < 1e-12
    assert np.abs(sol.energy.spring).max() < 1e-21  # J, of springs bent by 1e-12 rad
    assert sol.phi[0, 0] == pytest.approx(0.4 + scene.distribution.rest_shape[0])


@pytest.mark.parametrize("target", ["numpy", pytest.param("c", marks=pytest.mark.compiler)])
def test_energy_and_work_balance(target: str) -> None:
    loads = {"follower": {"force": 30.0}, "material_damping": {"time": 0.01}, "gravity": {}}
    scene = _scene({"phi": 0.0}, loads, rest_curvature="1 + s", spring="k*(d + 4*d**3)")
    sol = rodgen.simulate(scene, span=(0.0, 1.0), target=target, method="gauss", rtol=1e-10)
    largest = max(np.abs(sol.energy.spring).max(), np.abs(sol.work["follower"]).max())
    assert sol.energy_error < 1e-9 * largest


@pytest.mark.parametrize("law", ["k*{}", "k*({} + 5*({})**3)", "k*{} if {} > 0 else 3*k*({})"])
def test_the_law_of_a_spring_counts_from_its_rest(law: str) -> None:
    """A pinned rod has inner joints alone: there a law that is shifted by hand says the same."""
    pinned = {"boundary": "pinned", "initial": {"phi": "s"}}
    bent = _scene(**pinned, rest_curvature=0.6, spring=law.replace("{}", "d"))
    by_hand = law.replace("{}", f"(d - {0.6 * 2.0 / 6!r})")
    moved = _scene(**pinned, spring=by_hand)
    settings = {"span": (0.0, 0.1), "target": "numpy", "method": "dop853", "rtol": 1e-9}
    one, two = (rodgen.simulate(scene, **settings) for scene in (bent, moved))
    np.testing.assert_allclose(one.phi[-1], two.phi[-1], atol=1e-7)


def test_a_corner_of_the_law_is_where_the_rod_rests() -> None:
    scene = _scene(rest_curvature="1 + s", spring="k*d if d > 0 else 3*k*d")
    rest = np.array(scene.parameters["rest_angle"])
    (switch,) = scene.time_laws.switches()
    low, at, high = (switch.law(np.zeros(()), {BENDS: rest + by}) for by in (-0.1, 0.0, 0.1))
    assert (low < 0).all()
    assert not at.any()
    assert (high > 0).all()


def _stiffness(scene: Scene) -> np.ndarray:
    """Stiffness matrix of the moving links, joint by joint."""
    boundary, n = scene.boundary_condition, scene.rod.links
    matrix = np.zeros((n, n))
    k = scene.distribution.joint_stiffness
    for at, stiffness in zip(boundary.spring_joints(n), k, strict=True):
        opening = np.zeros(n)
        opening[at] = 1.0
        if at:
            opening[at - 1] = -1.0
        matrix += stiffness * np.outer(opening, opening)
    return matrix[boundary.first :, boundary.first :]


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_modes_are_those_about_the_shape_at_rest(boundary: str) -> None:
    """Frequencies of the springs' stiffness and the mass matrix there."""
    scene = _scene(boundary=boundary, rest_curvature="3*s")
    y, model = scene.initial_state(), build(scene, "numpy")
    mass = model.mass_matrix(y, model.parameters(**scene.parameters))
    stiffness = np.zeros_like(mass)
    base = 2 * scene.boundary_condition.translates
    stiffness[base:, base:] = _stiffness(scene)
    squares = eigh(stiffness, mass, eigvals_only=True)
    due = np.sqrt(squares[squares > 1e-9 * squares[-1]]) / (2 * np.pi)
    found = rodgen.natural_modes(scene, 3)
    np.testing.assert_allclose(found.frequencies, due[:3], rtol=1e-9)
    assert "without load" in found.state


def test_a_support_holds_the_point_of_the_rod_without_load() -> None:
    rod = {"boundary": "free", "rest_curvature": 1.0}
    table = _scene({"phi": "rest", "angle": 0.3}, **rod).to_dict()
    table["supports"] = [{"at": at, "stiffness": [100.0, 100.0]} for at in (0.25, 1.0)]
    scene = Scene.from_dict(table)
    model, y = build(scene, "numpy"), scene.initial_state()
    rates = model.rhs(0.0, y, model.parameters(**scene.parameters))
    np.testing.assert_allclose(rates, 0.0, atol=1e-11)  # of some 1e4 rad/s^2 for a radian


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"rod.rest_curvature": [1.0] * 6}, "rod.rest_curvature"),
        ({"rod.rest_curvature": "1/(s - 0.5)"}, "rod.rest_curvature"),
        ({"rod.rest_curvature": "t"}, "rod.rest_curvature"),
        ({"parameters.rest": 1.0}, "parameters.rest"),
        ({"initial.angle": 0.1}, "initial.angle"),
        ({"rod.boundary": "free", "initial.angle": 0.1, "initial.phi": 0.0}, "initial.angle"),
    ],
)
def test_what_no_rod_can_have_is_refused(changes: dict[str, Any], field: str) -> None:
    scene = _scene(rest_curvature=1.0)
    assert refused(scene.replace, changes)[0] == field


def test_another_number_of_links_keeps_the_curvature() -> None:
    assert _scene(rest_curvature="1 + s").with_links(9).rod.rest_curvature == "1 + s"
    listed = _scene(rest_curvature=[1.0] * 7)
    assert refused(listed.with_links, 9)[0] == "rod.rest_curvature"


@pytest.mark.parametrize(
    ("start", "rod", "doubted"),
    [
        ({"phi": "rest"}, {}, []),
        ({"phi": 0.0}, {}, []),
        ({"phi": "rest"}, {"clamp_angle": 90.0}, ["rod.clamp_angle"]),
        ({"phi": 45.0}, {}, ["initial.phi"]),
        ({"phi": "rest", "angle": 45.0}, {"boundary": "free"}, ["initial.angle"]),
    ],
)
def test_a_rod_that_winds_is_not_taken_for_degrees(
    start: dict[str, Any], rod: dict[str, Any], doubted: list[str]
) -> None:
    """Curvature 20/m over 2 m winds six times."""
    told = rodgen.System(_scene(start, rest_curvature=20.0, **rod)).doubts
    assert [note.text.split(" = ")[0] for note in told] == doubted
