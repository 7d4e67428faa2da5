"""Branches of equilibria: against discrete buckling loads, the elastica, and critical loads."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import fsolve

import rodgen
from rodgen.analyse.branches import branch_data
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.curves import files
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.extrapolate import richardson
from rodgen.analyse.references import elastica
from rodgen.scene import Scene, SceneError

Rod = Callable[..., Scene]
STIFFNESS, LENGTH = 100.0, 5.0
UNIT = STIFFNESS / LENGTH**2
DEAD = {"tip": {"x": 0.0, "y": 0.0}}
PUSHED = {"follower": {"force": 0.0}}
AXIAL, FOLLOWER = "loads.tip.x", "loads.follower.force"


def buckling(n: int, mode: int) -> float:
    """Load of a clamped rod of n links: phi_i = sin((2 k - 1) pi (i + 1/2) / (2 n)) solves
    k (phi_{i+1} - 2 phi_i + phi_{i-1}) + F l phi_i = 0, with a root spring of half the length."""
    angle = (2 * mode - 1) * np.pi / (2 * n)
    return float(2 * (1 - np.cos(angle)) * n * n * UNIT)


@pytest.mark.parametrize(("n", "within"), [(5, 1e-12), (50, 1e-10)])
def test_branch_points_are_the_discrete_buckling_loads(rod: Rod, n: int, within: float) -> None:
    found = continue_equilibria(rod(n, "clamped", DEAD), AXIAL, (0.0, -70 * UNIT), step=0.05)
    loads = [-buckling(n, mode) for mode in (1, 2, 3)]
    assert found["special_kind"].values[:3].tolist() == ["branch"] * 3
    np.testing.assert_allclose(found["special_value"].values[:3], loads, rtol=within)
    values, unstable = found["value"].values, found["unstable"].values
    first = values > loads[2]
    beyond = (values[first, None] < np.array(loads)).sum(axis=1)
    np.testing.assert_array_equal(unstable[first], beyond)


def test_the_bent_branch_is_the_elastica(rod: Rod) -> None:
    """Its tail at 1.5 times Euler's load, on both sides, from elliptic integrals."""
    load = 1.5 * np.pi**2 / 4
    exact = elastica.axial_force(load)
    ns = (10, 20, 40, 80)
    for at, side in ((0, "x"), (1, "y")):
        tails = []
        for n in ns:
            scene = rod(n, "clamped", DEAD)
            found = continue_equilibria(scene, AXIAL, (0.0, -load * UNIT), switch=1, step=0.1)
            assert found["unstable"].values.tolist() == [0] * found.sizes["point"]
            first, last = found["tip"].values[[0, -1]]
            assert first[1] == pytest.approx(-last[1], rel=1e-9)
            tails.append(abs(last[at]) / LENGTH)
        assert richardson(ns, tails).value == pytest.approx(abs(getattr(exact, side)), abs=1e-6)


@pytest.mark.parametrize("n", [5, pytest.param(30, marks=pytest.mark.nightly)])
@pytest.mark.parametrize(
    "damping",
    [
        {},
        {"material_damping": {"time": 0.01}},
        {"internal_damping": {"coefficient": 0.3}},
        {"external_damping": {"coefficient": 0.2}},
    ],
    ids=lambda damping: next(iter(damping), "none"),
)
def test_hopf_points_are_critical_loads(rod: Rod, n: int, damping: dict[str, Any]) -> None:
    scene = rod(n, "clamped", PUSHED | damping)
    critical = rodgen.critical_force(scene)
    ends = 0.6 * critical.force, 1.2 * critical.force
    found = continue_equilibria(scene, FOLLOWER, ends, step=0.1)
    assert found["special_kind"].values.tolist() == ["hopf"]
    assert float(found["special_value"][0]) == pytest.approx(critical.force, rel=1e-10)
    assert float(found["special_frequency"][0]) == pytest.approx(critical.frequency, rel=1e-9)
    assert set(found["unstable"].values.tolist()) == {0, 2}


def test_a_free_rod_in_steady_flight() -> None:
    scene = Scene.from_toml(Path(__file__).parents[2] / "scenes" / "missile.toml")
    found = continue_equilibria(scene, FOLLOWER, (0.0, 400.0), step=0.1)
    critical = rodgen.critical_force(scene)
    assert found["special_kind"].values.tolist() == ["hopf"]
    assert float(found["special_value"][0]) == pytest.approx(critical.force, rel=1e-10)


def test_divergence_of_a_free_rod_of_two_links() -> None:
    """Which turns freely besides: at 32 EI/L^2, as critical loads have it."""
    rod = {"links": 2, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0, "boundary": "free"}
    scene = Scene.from_dict({"name": "free", "rod": rod, "loads": PUSHED})
    found = continue_equilibria(scene, FOLLOWER, (0.0, 45.0), step=0.1)
    assert found["special_kind"].values.tolist() == ["branch"]
    assert float(found["special_value"][0]) == pytest.approx(32.0, rel=1e-10)


def test_stability_that_is_not_known_is_said(rod: Rod) -> None:
    """External damping has no linear part about a bent state."""
    loads = PUSHED | {"gravity": {"g": 1.0}, "external_damping": {"coefficient": 0.1}}
    found = continue_equilibria(rod(4, "clamped", loads), FOLLOWER, (0.0, 10.0), step=0.1)
    assert set(found["unstable"].values.tolist()) == {-1}
    assert "external damping" in found.attrs["notes"]
    assert found.attrs["complete"]


def test_the_fold_of_a_column_with_a_force_across(rod: Rod) -> None:
    """The bent state to the other side of a small force across ends in a fold, where both angles of
    two links are in balance and the determinant of their stiffness is zero."""
    across = -0.5
    scene = rod(2, "clamped", {"tip": {"x": 0.0, "y": across}})
    found = continue_equilibria(scene, AXIAL, (-60.0, 0.0), imperfection=1.0)
    assert found["special_kind"].values.tolist() == ["fold"]
    assert found["value"].values[-1] == -60.0
    assert found["unstable"].values[[0, -1]].tolist() == [0, 1]
    l = LENGTH / 2
    k = STIFFNESS / l

    def balance(z: Any) -> list[float]:
        (a, b, F), c = z, across
        pulls = [l * (F * np.sin(x) - c * np.cos(x)) for x in (a, b)]
        held = [
            3 * k + l * (F * np.cos(a) + c * np.sin(a)),
            k + l * (F * np.cos(b) + c * np.sin(b)),
        ]
        return [3 * k * a - k * b + pulls[0], k * (b - a) + pulls[1], held[0] * held[1] - k * k]

    start = [*found["special_phi"].values[0] + 0.01, float(found["special_value"][0]) - 0.1]
    exact = fsolve(balance, start, xtol=1e-14)
    assert float(found["special_value"][0]) == pytest.approx(exact[2], rel=1e-11)


def test_a_file_is_gone_on_from(rod: Rod, tmp_path: Path) -> None:
    scene = rod(10, "clamped", {"tip": {"x": 0.0, "y": 0.3}})
    whole = continue_equilibria(scene, AXIAL, (0.0, -20.0))
    part = continue_equilibria(scene, AXIAL, (0.0, -9.0))
    files.save(part, tmp_path / "branch.nc")
    read = branch_data.read(tmp_path / "branch.nc")
    more = continue_equilibria(scene, AXIAL, (0.0, -20.0), resume=read)
    np.testing.assert_array_equal(more["phi"].values[: part.sizes["point"]], part["phi"].values)
    assert (np.diff(more["length"].values) > 0).all()
    np.testing.assert_allclose(more["phi"].values[-1], whole["phi"].values[-1], rtol=1e-11)
    back = continue_equilibria(scene, AXIAL, (0.0, -20.0), resume=read, at=0)
    # The first point is that of the unloaded rod, on its edge.
    assert back.sizes["point"] == part.sizes["point"]
    with pytest.raises(SceneError, match=r"loads\.tip\.x"):
        continue_equilibria(scene, "loads.tip.y", (0.0, 1.0), resume=read)
    with pytest.raises(SceneError, match="point"):
        continue_equilibria(scene, AXIAL, (0.0, -20.0), resume=read, at=len(part["value"]))
    read["y"].values[-1] += 0.1
    with pytest.raises(AnalysisError, match="no equilibrium"):
        continue_equilibria(scene, AXIAL, (0.0, -20.0), resume=read)


def test_a_scene_at_a_point_of_a_branch_is_at_rest(rod: Rod) -> None:
    scene = rod(6, "clamped", {"tip": {"x": 0.0, "y": 0.3}})
    found = continue_equilibria(scene, AXIAL, (0.0, -20.0), step=0.1)
    for at in (0, found.sizes["point"] // 2, -1):
        there = branch_data.scene_at(found, at)
        model = rodgen.build(there, "numpy")
        rates = model.rhs(0.0, there.initial_state(), model.parameters(**there.parameters))
        assert np.abs(rates).max() < 1e-8
        assert there.loads.value("tip_force_x") == float(found["value"][at])
    with pytest.raises(SceneError, match="at"):
        branch_data.scene_at(found, found.sizes["point"])


def test_both_ways_from_a_value_between(rod: Rod) -> None:
    scene = rod(10, "clamped", {"tip": {"x": 0.0, "y": 0.3}})
    found = continue_equilibria(scene, AXIAL, (0.0, -20.0), start=-7.0)
    values = found["value"].values
    assert values[0] == 0.0
    assert values[-1] == -20.0
    assert (np.diff(values) < 0).all()
    assert -7.0 in values


@pytest.mark.parametrize(
    ("key", "ends", "field"),
    [
        ("rod.links", (5, 10), "vary"),
        ("loads.tip.z", (0, 1), "loads.tip.z"),
        ("name", (0, 1), "vary"),
        ("loads.tip.x", (1.0, 1.0), "vary.loads.tip.x"),
        ("loads.tip.x", (0.0, float("nan")), "vary.loads.tip.x"),
        ("rod.mass", (1.0, -1.0), "rod.mass"),
        ("initial.phi.0", (0.0, 1.0), "vary"),
    ],
)
def test_what_cannot_be_varied(rod: Rod, key: str, ends: Any, field: str) -> None:
    with pytest.raises(SceneError) as error:
        continue_equilibria(rod(5, "clamped", DEAD), key, ends)
    assert error.value.field == field


def test_switching_where_nothing_branches(rod: Rod) -> None:
    with pytest.raises(SceneError, match="switch"):
        continue_equilibria(rod(5, "clamped", PUSHED), FOLLOWER, (0.0, 80.0), switch=1, step=0.1)


def test_a_branch_costs_what_its_length_does(rod: Rod) -> None:
    """Of long rods all is O(n): 200 points of 1000 links take 20 times those of 50 at the very
    most, where dense matrices take 400 times as long and more."""
    from time import process_time

    times = []
    for n in (50, 1000):
        start = process_time()
        continue_equilibria(rod(n, "clamped", DEAD), AXIAL, (0.0, -2 * UNIT), step=0.05)
        times.append(process_time() - start)
    assert times[1] < 20 * times[0]
