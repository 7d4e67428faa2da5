"""Branches of equilibria: against discrete buckling loads, the elastica, and critical loads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches import equilibrium_data
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.curves import curve_datasets
from rodgen.analyse.extrapolation import richardson
from rodgen.analyse.references import elastica
from rodgen.errors import AnalysisError, InputError
from tests.analyse.rods import AXIAL, FORCE, LENGTH, ONES, STIFFNESS, rod
from tests.sets import sets

UNIT = STIFFNESS / LENGTH**2
DEAD = {"tip": {"x": 0.0, "y": 0.0}}
PUSHED = {"follower": {"force": 0.0}}
DAMPINGS = ("internal_damping", "external_damping")


def buckling(n: int, mode: int) -> float:
    """Load of a clamped rod of n links: phi_i = sin((2 k - 1) pi (i + 1/2) / (2 n)) solves
    k (phi_{i+1} - 2 phi_i + phi_{i-1}) + F l phi_i = 0, with a root spring of half the length."""
    angle = (2 * mode - 1) * np.pi / (2 * n)
    return float(2 * (1 - np.cos(angle)) * n * n * UNIT)


# Beyond 90 unknowns matrices are sparse.
@pytest.mark.parametrize(("n", "within"), sets([(5, 1e-12)], slow=[(100, 1e-9)]))
def test_branch_points_are_the_discrete_buckling_loads(n: int, within: float) -> None:
    found = continue_equilibria(rod(n, "clamped", DEAD), AXIAL, (0.0, -70 * UNIT), step=0.1)
    loads = [-buckling(n, mode) for mode in (1, 2, 3)]
    assert found["special_kind"].values[:3].tolist() == ["branch"] * 3
    np.testing.assert_allclose(found["special_value"].values[:3], loads, rtol=within)
    values, unstable = found["value"].values, found["unstable"].values
    first = values > loads[2]
    beyond = (values[first, None] < np.array(loads)).sum(axis=1)
    np.testing.assert_array_equal(unstable[first], beyond)


@pytest.mark.slow
def test_the_bent_branch_is_the_elastica() -> None:
    """Its tail at 1.5 times Euler's load, on both sides, from elliptic integrals."""
    load = 1.5 * np.pi**2 / 4
    exact = elastica.axial_force(load)
    ns, tails = (10, 20, 40), []
    for n in ns:
        scene = rod(n, "clamped", DEAD)
        found = continue_equilibria(scene, AXIAL, (0.0, -load * UNIT), branch_point=1, step=0.1)
        assert found["unstable"].values.tolist() == [0] * found.sizes["point"]
        first, last = found["tip"].values[[0, -1]]
        assert first[1] == pytest.approx(-last[1], rel=1e-9)
        tails.append(np.abs(last) / LENGTH)
    for along, known in zip(np.transpose(tails), (exact.x, exact.y), strict=True):
        # Of fourth order, with a factor near one.
        assert richardson(ns, along, order=[2, 4]).value == pytest.approx(abs(known), abs=1e-6)


@pytest.mark.parametrize(
    ("boundary", "n", "damping"),
    sets(
        [("clamped", 5, {}), ("clamped", 5, {"material_damping": {"time": 0.01}})],
        slow=[
            *(("clamped", 5, {name: {"coefficient": 0.3}}) for name in DAMPINGS),
            # Beyond 12 links the lowest modes are looked at, all of them in a few points.
            ("clamped", 30, {}),
            ("free", 5, {"internal_damping": {"coefficient": 0.3}}),  # it turns freely
            ("free", 5, {name: {"coefficient": 0.3} for name in DAMPINGS}),  # it flies
        ],
    ),
)
def test_hopf_points_are_critical_loads(boundary: str, n: int, damping: dict[str, Any]) -> None:
    scene = rod(n, boundary, PUSHED | damping)
    critical = rodgen.critical_load(scene)
    ends = 0.6 * critical.value, 1.2 * critical.value
    found = continue_equilibria(scene, FORCE, ends, step=0.1)
    assert found["special_kind"].values.tolist() == ["hopf"]
    assert float(found["special_value"][0]) == pytest.approx(critical.value, rel=1e-10)
    assert float(found["special_frequency"][0]) == pytest.approx(critical.frequency, rel=1e-9)
    assert set(found["unstable"].values.tolist()) == {0, 2}


def test_divergence_of_a_free_rod_of_two_links() -> None:
    """Which turns freely besides: at 32 EI/L^2, as critical loads have it."""
    scene = rod(2, "free", PUSHED, **ONES)
    found = continue_equilibria(scene, FORCE, (0.0, 45.0), step=0.1)
    assert found["special_kind"].values.tolist() == ["branch"]
    assert float(found["special_value"][0]) == pytest.approx(32.0, rel=1e-10)


@pytest.mark.slow
def test_stability_that_is_not_known_is_said() -> None:
    """External damping has no linear part about a bent state."""
    loads = PUSHED | {"gravity": {"g": 1.0}, "external_damping": {"coefficient": 0.1}}
    found = continue_equilibria(rod(4, "clamped", loads), FORCE, (0.0, 10.0), step=0.1)
    assert set(found["unstable"].values.tolist()) == {-1}
    assert found.rodgen.doubts
    assert found.attrs["complete"]


@pytest.mark.slow
def test_the_fold_of_a_column_with_a_force_across() -> None:
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

    def balance(a: Any, b: Any, F: Any) -> list[Any]:
        c = across
        pulls = [l * (F * mp.sin(x) - c * mp.cos(x)) for x in (a, b)]
        held = [
            3 * k + l * (F * mp.cos(a) + c * mp.sin(a)),
            k + l * (F * mp.cos(b) + c * mp.sin(b)),
        ]
        return [3 * k * a - k * b + pulls[0], k * (b - a) + pulls[1], held[0] * held[1] - k * k]

    start = [*found["special_phi"].values[0] + 0.01, float(found["special_value"][0]) - 0.1]
    exact = mp.findroot(balance, start)
    assert float(found["special_value"][0]) == pytest.approx(float(exact[2]), rel=1e-11)


@pytest.mark.slow
def test_a_file_is_gone_on_from(tmp_path: Path) -> None:
    scene = rod(6, "clamped", {"tip": {"x": 0.0, "y": 0.3}})
    part = continue_equilibria(scene, AXIAL, (0.0, -9.0))
    curve_datasets.save_curve(part, tmp_path / "branch.nc")
    read = equilibrium_data.FORMAT.read(tmp_path / "branch.nc")
    back = continue_equilibria(scene, AXIAL, (0.0, -20.0), resume=read, point=0)
    # The first point is that of the unloaded rod, on its edge.
    assert back.sizes["point"] == part.sizes["point"]
    with pytest.raises(InputError, match=r"^resume = 'loads\.tip\.x'"):
        continue_equilibria(scene, "loads.tip.y", (0.0, 1.0), resume=read)
    with pytest.raises(InputError, match=rf"^point = {len(part['value'])}"):
        continue_equilibria(scene, AXIAL, (0.0, -20.0), resume=read, point=len(part["value"]))
    read["y"].values[-1] += 0.1
    with pytest.raises(AnalysisError):
        continue_equilibria(scene, AXIAL, (0.0, -20.0), resume=read)


def test_a_scene_at_a_point_of_a_branch_is_at_rest() -> None:
    """Of one that was followed both ways from a value between."""
    scene = rod(6, "clamped", {"tip": {"x": 0.0, "y": 0.3}})
    found = continue_equilibria(scene, AXIAL, (0.0, -20.0), start=-7.0, step=0.1)
    values = found["value"].values
    assert (values[0], values[-1], -7.0 in values) == (0.0, -20.0, True)
    assert (np.diff(values) < 0).all()
    for at in (0, found.sizes["point"] // 2, -1):
        there = equilibrium_data.scene_at(found, at)
        model = rodgen.build(there, "numpy")
        rates = model.rhs(0.0, there.initial_state(), model.parameters(**there.parameters))
        assert np.abs(rates).max() < 1e-8
        assert there.loads.value("tip_force_x") == float(found["value"][at])
    with pytest.raises(InputError, match=r"^point = "):
        equilibrium_data.scene_at(found, found.sizes["point"])


@pytest.mark.slow
def test_no_point_is_known_next_to_a_branch_point() -> None:
    """Where an eigenvalue crosses zero at a branch point, Newton's method fails beside it, and the
    crossing cannot be narrowed: the branch goes on all the same."""
    table = {
        "name": "steered",
        "rod": {"links": 5, "length": 0.52835, "mass": 1.12378, "bending_stiffness": 41.7227},
        "loads": {
            "follower": {"force": 1.0, "angle": "0.269629*phi(0.43)"},
            "tip": {"x": -87.6483368965284, "y": -23.630142762649353},
            "material_damping": {"time": 7.682481593816146e-05},
            "internal_damping": {"coefficient": 0.05338902719863722},
        },
        "supports": [
            {"at": 0.0, "stiffness": [45839.53726540958, 1119.3945750387522]},
            {"at": 1.0, "stiffness": [9946.996278232271, 1581.5777547328112]},
        ],
    }
    table["supports"][0]["damping"] = [0.04346740708615853, 0.08506198141310836]
    table["supports"][1]["damping"] = [3.3829378941472137, 5.1611662110447885]
    scene = rodgen.Scene.from_dict(table)
    found = continue_equilibria(scene, FORCE, (0.0, 2300.0))
    assert found.attrs["complete"]
    assert found["special_kind"].values.tolist() == ["hopf", "branch"]
    assert found["unstable"].values[-1] == 3


@pytest.mark.parametrize("key", ["foundation.stiffness", "loads.material_damping.time"])
def test_a_branch_begins_and_ends_where_a_stiffness_or_damping_is_zero(key: str) -> None:
    """Though the scene refuses what lies beyond."""
    loads = {"follower": {"force": 3.0}, "gravity": {}, "material_damping": {"time": 0.01}}
    scene = rod(4, "clamped", loads, bending_stiffness=30.0, foundation={"stiffness": 1.0})
    for ends in ((0.0, 1.0), (1.0, 0.0)):
        branch = continue_equilibria(scene, key, ends)
        assert branch.value.values[[0, -1]].tolist() == list(ends)


def test_a_number_takes_the_place_of_a_law_that_there_is_none_of_at_the_start() -> None:
    scene = rod(4, "clamped", {"follower": {"force": "5/t"}, "gravity": {}}, bending_stiffness=30.0)
    branch = continue_equilibria(scene, "loads.follower.force", (1.0, 5.0))
    assert branch.value.values[[0, -1]].tolist() == [1.0, 5.0]
