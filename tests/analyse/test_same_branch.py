"""Rests and branches of random rods that were of another branch, or ended where they should not:
where branches meet, turn back or begin without load."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.statics import static_equilibrium
from rodgen.errors import AnalysisError
from rodgen.scene import Scene
from tests.analyse.rods import FORCE, ONES, eigenvalues, rod

TURNED: dict[str, Any] = {
    "name": "turned",
    "rod": {"length": 0.52835, "mass": 1.12378, "bending_stiffness": 41.7227, "links": 5},
    "loads": {
        "follower": {"force": 3005.788, "angle": "0.269629*phi(0.43)"},
        "tip": {"x": -87.6483368965284, "y": -23.630142762649353},
    },
    "supports": [
        {"at": 0.0, "stiffness": [45839.53726541, 1119.394575038]},
        {"at": 1.0, "stiffness": [9946.9962782322, 1581.57775473281]},
    ],
}


def test_where_branches_meet_a_rest_stays_on_its_own() -> None:
    """A rod that turns as a whole, straight, on its springs; at some load of the way a branch of
    bent ones leaves it, which are stable."""
    table = TURNED | {"rod": TURNED["rod"] | {"boundary": "free"}}
    for force in (3005.788, 4868.880342522, 6359.3539167638):
        thrust = TURNED["loads"]["follower"] | {"force": force}
        loads = TURNED["loads"] | {"follower": thrust}
        found = static_equilibrium(Scene.from_dict(table | {"loads": loads}))
        np.testing.assert_allclose(found.phi, found.phi[0], atol=1e-9)


def test_a_rest_in_the_wind_beside_a_weight_turns_back_as_well() -> None:
    """A weight that is next to nothing does not let the rod hang on another branch."""
    drag = {"normal": 1.0, "tangential": 0.0, "wind": [-10.0, 1.0]}
    with pytest.raises(AnalysisError, match=r"0\.142\d+ .* turns back"):
        static_equilibrium(rod(2, "clamped", {"drag": drag, "gravity": {"g": 0.01}}, **ONES))


def test_a_line_does_not_close_in_itself() -> None:
    """Whose longest steps reach back to its start."""
    loads = {"follower": {"force": 0.0, "angle": "-0.06*(0.37*omega(0.44) + phi(0.5))"}}
    branch = continue_equilibria(rod(5, "clamped", loads, **ONES), FORCE, (0.0, 60.0))
    assert branch["value"].values[-1] == 60.0


def test_a_free_steered_rod_branches_where_an_eigenvalue_is_zero() -> None:
    """Though it accelerates as a whole."""
    loads = {"follower": {"force": 0.0, "angle": "-0.02*phi(0.5)"}, "tip": {"x": -0.5}}
    scene = rod(3, "free", loads, **ONES)
    branch = continue_equilibria(scene, FORCE, (0.0, 30.0))
    (value,) = branch["special_value"].values[branch["special_kind"].values == "branch"].tolist()
    beside = [
        np.sort(np.abs(eigenvalues(scene.replace({FORCE: share * value}))))[4]
        for share in (1.0, 0.99)
    ]
    # Four zeros are of the place; the root of what the force is known to is what remains of it.
    assert beside[0] < 1e-4 < 1e-2 < beside[1]


@pytest.mark.slow
def test_external_damping_brakes_nothing_along_a_free_rod_on_springs() -> None:
    """As a run shows, in which the whole rod swings along itself by a millimetre."""
    springs = [{"at": at, "stiffness": [10.0, 50.0]} for at in (0.0, 1.0)]
    loads = {"external_damping": {"coefficient": 0.5}}
    tables = {"initial": {"position": [1e-3, 0.0]}, "integrate": {"span": [0.0, 4.0]}}
    scene = rod(2, "free", loads, supports=springs, **tables, **ONES)
    modes = natural_modes(scene)
    along = np.argmin(np.abs(modes.frequencies - np.sqrt(20.0) / (2 * np.pi)))
    assert modes.growth[along] == 0.0
    assert (np.delete(modes.growth, along) < 0).all()
    run = rodgen.simulate(scene, target="numpy")
    assert np.abs(run.y[-80:, 0]).max() == pytest.approx(1e-3, rel=1e-2)  # samples miss the crest


def test_a_pinned_rod_under_a_dead_push_grows_all_along_its_branch() -> None:
    scene = rod(3, "pinned", {"tip": {"x": -1.0}}, **ONES)
    branch = continue_equilibria(scene, "loads.tip.x", (0.0, -5.0))
    assert (branch["unstable"].values[1:] > 0).all()


def test_a_pinned_rod_rests_where_its_thrust_is_steered_to() -> None:
    """Straight, at the angle zero, which the steering alone makes a rest of its own."""
    loads = {"follower": {"force": 5.0, "angle": "0.2*phi(0.5)"}, "material_damping": {"time": 0.1}}
    found = static_equilibrium(rod(3, "pinned", loads, **ONES))
    np.testing.assert_array_equal(found.phi, 0.0)
    grows = eigenvalues(rod(3, "pinned", loads, **ONES)).real.max() > 1e-9
    assert found.stable is not bool(grows)


@pytest.mark.slow
def test_flutter_before_a_fold_is_found() -> None:
    """Beyond which there is no rest at all."""
    table = {
        "name": "blown",
        "rod": {"length": 1.46795, "mass": 1.40269, "bending_stiffness": 3.89177, "links": 2},
        "loads": {
            "follower": {"force": 1.0, "angle": "-0.1282989*omega(0.63)"},
            "tip": {"x": -0.2564741, "y": 0.3659032},
            "material_damping": {"time": 0.08769608698},
            "drag": {"normal": 1.04, "tangential": 0.119, "wind": [-0.46995, 0.762834]},
        },
        "supports": [{"at": 1.0, "stiffness": [0.0, 19.9446], "damping": [0.0, 0.1152]}],
    }
    table["rod"] |= {"boundary": "pinned", "inertia": "lumped"}
    found = rodgen.critical_load(Scene.from_dict(table), bounds=(None, 100.0))
    assert found.kind == "flutter"


def test_a_branch_of_a_free_steered_rod_begins_without_load() -> None:
    """Where no load gives it a direction; that of a gimbal which follows rates alone gives none."""
    loads = {"follower": {"force": 0.0, "angle": "gimbal"}}
    states = {"gimbal": {"rate": "20*(0.05*omega(0.3) - gimbal)"}}
    branch = continue_equilibria(rod(2, "free", loads, states=states, **ONES), FORCE, (0.0, 60.0))
    assert branch["value"].values[-1] == 60.0
    hopf = branch["special_value"].values[branch["special_kind"].values == "hopf"].tolist()
    s = eigenvalues(rod(2, "free", loads, states=states, **ONES).replace({FORCE: hopf[-1]}))
    assert np.abs(s[s.imag > 0.1].real).min() < 1e-9


def test_a_tiny_force_across_leads_an_upright_column_to_its_side() -> None:
    """Around a sharp bend at Euler's load, to where the branch leads."""
    loads = {"tip": {"x": 1e-6, "y": -30.0}}
    scene = rod(10, "clamped", loads, clamp_angle=np.pi / 2, **ONES)
    found = static_equilibrium(scene)
    branch = continue_equilibria(scene, "loads.tip.y", (0.0, -30.0))
    assert found.stable
    np.testing.assert_allclose(found.phi, branch["phi"].values[-1], atol=1e-9)


def test_a_kink_of_the_springs_is_passed() -> None:
    spring = "k*max(-0.05, min(0.05, d)) + 0.2*k*d"
    loads = {"gravity": {"g": 4.0}, "follower": {"force": 0.5}}
    scene = rod(2, "clamped", loads, spring=spring, **ONES)
    found = static_equilibrium(scene)
    assert np.abs(np.diff(found.phi, prepend=0.0)).max() > 0.05
    rates = rodgen.build(scene, "numpy").rhs(0.0, found.y, scene_parameters(scene))
    np.testing.assert_allclose(rates, 0.0, atol=1e-9)


def scene_parameters(scene: Scene) -> np.ndarray:
    """p of a module."""
    return rodgen.build(scene, "numpy").parameters(**scene.parameters)


def test_roundings_of_a_neutral_motion_are_no_growth() -> None:
    """External damping moves no divergence."""
    loads = {"follower": {"force": 1.0, "angle": "0.02*phi(0.47)"}}
    damped = loads | {"external_damping": {"coefficient": 0.5}}
    bare, found = (rodgen.critical_load(rod(10, "pinned", x, **ONES)) for x in (loads, damped))
    assert (bare.kind, found.growth) == (found.kind, 0.0)
    assert found.value == pytest.approx(bare.value, rel=1e-6)
