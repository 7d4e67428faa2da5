"""Steady motions of rods that nothing holds in place: against exact solutions, and runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import root

import rodgen
from rodgen.analyse.branches import equilibrium_data
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.curves import curve_datasets
from rodgen.errors import AnalysisError, InputError
from rodgen.scene import Scene
from tests.analyse.rods import AXIAL, FORCE, ONES, jacobian, rod

DRAG = {"normal": 0.8, "tangential": 0.05}
G = 9.81
STIFFNESS = "rod.bending_stiffness"


def _scene(n: int, boundary: str, loads: dict[str, Any], **tables: Any) -> Scene:
    return rod(n, boundary, loads, **ONES, **tables)


def _keeps_its_shape(found: Any, at: int, span: float) -> None:
    """A run from the state of a point: no angle changes against the others, and all turn with the
    rate of the branch. 1e-8 is what the run's own errors leave, times how unstable it is."""
    scene = equilibrium_data.scene_at(found, at)
    run = rodgen.simulate(scene, target="numpy", span=[0.0, span], rtol=1e-11, atol=1e-12)
    base = 2 * scene.boundary_condition.translates
    phi = run.y[:, base : base + scene.rod.links]
    turned = phi[0] + np.multiply.outer(run.t, np.full(scene.rod.links, found["turning"][at]))
    np.testing.assert_allclose(phi, turned, atol=1e-8)


@pytest.mark.slow
def test_terminal_velocity_of_a_falling_rod() -> None:
    """Nose first: sqrt(M g / (c_t L)), with a payload that makes its direction one of its own."""
    start = {"phi": np.pi / 2, "velocity": [0.0, -20.0]}
    payload = [{"name": "payload", "at": 0.0, "mass": 0.5}]
    loads = {"gravity": {"g": G}, "drag": DRAG}
    scene = _scene(4, "free", loads, bodies=payload, initial=start)
    along = ("loads.drag.tangential", (0.05, 0.1))
    found = continue_equilibria(scene, *along, motion="initial", step=0.1)
    speed = np.linalg.norm(found["y"].values[:, 6:8], axis=1)
    # 1e-12: what Newton's method leaves of a speed.
    np.testing.assert_allclose(speed, np.sqrt(1.5 * G / found["value"].values), rtol=1e-12)
    assert found.attrs["complete"]
    assert np.abs(found["turning"].values).max() == 0.0


def test_a_pinned_link_whirls_as_fast_as_drag_lets_it() -> None:
    """P sin(nu) L = c_n (L/2) (Omega L)^2 L, and small changes of Omega decay with
    -c_n L^4 Omega / (M L^2 / 3)."""
    loads = {"follower": {"force": 2.0, "angle": 1.2}, "drag": DRAG}
    scene = _scene(1, "pinned", loads, integrate={"span": [0.0, 20.0]})
    found = continue_equilibria(scene, FORCE, (2.0, 6.0), motion="run", step=0.1)
    exact = np.sqrt(2 * found["value"].values * np.sin(1.2) / DRAG["normal"])
    np.testing.assert_allclose(np.abs(found["turning"].values), exact, rtol=1e-12)
    assert found["unstable"].values.tolist() == [0] * found.sizes["point"]


@pytest.mark.slow
def test_a_rod_that_is_pushed_straight_on_buckles() -> None:
    """Two free links, pushed at the tail in a direction that stays: with R = -F/2 in the joint
    moments about both centres are F l/4 sin a = k (a - b) and 3 F l/4 sin b = k (b - a); the
    straight rod has company from F = 16 k/(3 l) on."""
    scene = _scene(2, "free", {"tip": {"x": 0.0, "y": 0.0}})
    straight = continue_equilibria(scene, AXIAL, (-1.0, -40.0))
    l = 0.5
    k = 1 / l
    assert straight["special_kind"].values.tolist() == ["branch"]
    assert float(straight["special_value"][0]) == pytest.approx(-16 * k / (3 * l), rel=1e-10)
    assert straight["unstable"].values[[1, -1]].tolist() == [1, 2]  # it turns over, and buckles
    bent = continue_equilibria(scene, AXIAL, (-1.0, -40.0), branch_point=1)
    for at in (1, bent.sizes["point"] // 4, -1):
        a, b = bent["phi"].values[at]
        F = -float(bent["value"][at])

        def balance(z: Any, F: float = F) -> list[Any]:
            spring = k * (z[0] - z[1])
            return [F * l / 4 * np.sin(z[0]) - spring, 3 * F * l / 4 * np.sin(z[1]) + spring]

        exact = root(balance, [a + 1e-3, b - 1e-3], tol=1e-13)
        np.testing.assert_allclose([a, b], exact.x, atol=1e-9)
    _keeps_its_shape(bent, bent.sizes["point"] // 4, 0.2)


@pytest.mark.slow
def test_a_dragged_rod_keeps_its_bend(tmp_path: Any) -> None:
    """It falls across its axis, bent by the payload in its middle; with its own module's
    Jacobian as the second route to its stability."""
    loads = {"gravity": {"g": G}, "drag": DRAG, "internal_damping": {"coefficient": 0.1}}
    payload = [{"name": "payload", "at": 0.5, "mass": 0.5}]
    start = {"phi": "0.1*s", "velocity": [0.0, -3.0]}
    scene = _scene(4, "free", loads, bodies=payload, initial=start)
    found = continue_equilibria(scene, STIFFNESS, (10.0, 0.5), motion="initial", step=0.1)
    bend = np.ptp(found["phi"].values, axis=1)
    assert found.attrs["complete"]
    assert (np.diff(bend) > 0).all()
    assert bend[-1] > 0.3
    for at in (0, -1):
        _keeps_its_shape(found, at, 0.5)
        J = jacobian(equilibrium_data.scene_at(found, at))
        s = np.linalg.eigvals(np.delete(np.delete(J, [0, 1], 0), [0, 1], 1))
        assert int((s.real > 1e-9 * np.abs(s).max()).sum()) == found["unstable"].values[at]
    curve_datasets.save_curve(found, tmp_path / "branch.nc")
    read = equilibrium_data.FORMAT.read(tmp_path / "branch.nc")
    half = found.sizes["point"] // 2
    again = continue_equilibria(scene, STIFFNESS, (10.0, 0.5), resume=read, point=half, step=0.1)
    np.testing.assert_allclose(again["y"].values[-1, 2:], found["y"].values[-1, 2:], atol=1e-9)


@pytest.mark.slow
def test_a_rod_under_thrust_at_an_angle_goes_round() -> None:
    """What nothing but a run leads to: speed, rate of turning and bend are all unknown."""
    loads = {"follower": {"force": 2.0, "angle": 0.2}, "drag": DRAG | {"tangential": 0.1}}
    loads |= {"internal_damping": {"coefficient": 0.1}}
    start = {"velocity": [-2.0, 0.0]}
    scene = _scene(3, "free", loads, initial=start, integrate={"span": [0.0, 40.0]})
    found = continue_equilibria(scene, FORCE, (2.0, 10.0), motion="run", step=0.2)
    assert found.attrs["complete"]
    assert np.abs(found["turning"].values).min() > 0.5
    assert np.ptp(found["phi"].values[-1]) > 0.1
    assert found["unstable"].values[-1] == 0
    for at in (0, -1):
        _keeps_its_shape(found, at, 0.5)


def test_flutter_in_the_moving_frame() -> None:
    """Of a clamped rod the frame stands still: the Hopf point is the critical load."""
    loads = {"follower": {"force": 1.0}, "internal_damping": {"coefficient": 0.5}}
    scene = rod(3, "clamped", loads)
    found = continue_equilibria(scene, FORCE, (1.0, 80.0), motion="initial", step=0.1)
    exact = rodgen.critical_load(scene)
    assert found["special_kind"].values.tolist() == ["hopf"]
    # Both are roots of the real part of one eigenvalue, which rounds to 1e-13 of the largest.
    assert float(found["special_value"][0]) == pytest.approx(exact.value, rel=1e-10)
    assert float(found["special_frequency"][0]) == pytest.approx(exact.frequency, rel=1e-10)


@pytest.mark.slow
def test_what_is_no_steady_motion() -> None:
    """An even rod may fall at any angle: there is a family, and no branch; springs hold it."""
    loads = {"gravity": {"g": G}, "drag": DRAG}
    flat = _scene(4, "free", loads, initial={"velocity": [0.0, -3.0]})
    with pytest.raises(AnalysisError):
        continue_equilibria(flat, STIFFNESS, (1.0, 2.0), motion="initial")
    held = _scene(2, "free", {"gravity": {}}, supports=[{"at": 0.5, "stiffness": [1.0, 1.0]}])
    with pytest.raises(InputError, match=r"^motion = "):
        continue_equilibria(held, STIFFNESS, (1.0, 2.0), motion="initial")


def test_undamped_motions_that_go_on_oscillating_are_no_onset() -> None:
    """Two free links under a dead push: beside the turning of the whole, which grows under any, a
    second motion oscillates up to 16 k/(3 l) and diverges from there; k = 2 EI/L and l = L/2."""
    scene = rod(2, "free", {"tip": {"x": -1.0, "y": 0.0}}, **ONES)
    found = continue_equilibria(scene, AXIAL, (-1.0, -30.0), motion="initial")
    assert found["special_kind"].values.tolist() == ["branch"]
    # The force of a branch point is solved for to rounding, of which this leaves a few digits.
    assert float(found["special_value"][0]) == pytest.approx(-64 / 3, rel=1e-9)
