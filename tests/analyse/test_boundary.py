"""Boundaries of stability: against Ziegler's pendulum in closed form, and critical loads."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.boundary import stability_boundary
from rodgen.analyse.errors import AnalysisError
from rodgen.scene import Scene, SceneError
from rodgen.scene.keys import with_value

Rod = Callable[..., Scene]
FOLLOWER, INTERNAL = "loads.follower.force", "loads.internal_damping.coefficient"
MATERIAL, EXTERNAL = "loads.material_damping.time", "loads.external_damping.coefficient"
ONES = {"length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}


@pytest.fixture
def ziegler(rod: Rod) -> Scene:
    """Ziegler's pendulum with equal damping in both springs: P l/k is a ninth of the force."""
    loads = {"follower": {"force": 2.0}, "internal_damping": {"coefficient": 0.18}}
    return rod(3, "cantilever", loads, inertia="lumped", **ONES)


def test_ziegler_paradox_in_closed_form(ziegler: Scene) -> None:
    """With damping B the pendulum flutters at P l/k = 41/28 + B^2/2 (G. Herrmann and I.-C. Jong,
    J. Appl. Mech. 32 (1965) 592); c_int = 0.18 is B^2 = 0.0648. The limit of none is a point of the
    boundary, far below the 7/2 - sqrt(2) of no damping."""
    found = stability_boundary(ziegler, (FOLLOWER, INTERNAL))
    force, damping = found["a"].values, found["b"].values
    assert damping[0] == 0.0
    assert force[0] == pytest.approx(9 * 41 / 28, rel=1e-12)
    np.testing.assert_allclose(
        force, 9 * (41 / 28 + (damping / 0.18) ** 2 * 0.0648 / 2), rtol=1e-10
    )
    at = int(np.argmin(np.abs(damping - 0.18)))
    assert (damping[at], force[at]) == pytest.approx((0.18, 13.4701714286), rel=1e-11)
    assert found.attrs["complete"]
    without = with_value(ziegler, INTERNAL, 0.0)
    assert rodgen.critical_force(without).force == pytest.approx(9 * (3.5 - np.sqrt(2)), rel=1e-10)


def test_the_order_of_both_numbers_is_that_of_the_points(ziegler: Scene) -> None:
    one = stability_boundary(ziegler, (FOLLOWER, INTERNAL))
    other = stability_boundary(ziegler, (INTERNAL, FOLLOWER))
    np.testing.assert_allclose(one["a"], other["b"], rtol=1e-9)
    assert other.attrs["a"] == INTERNAL


@pytest.mark.parametrize(
    ("n", "boundary", "loads", "key", "ends"),
    [
        (8, "clamped", {"material_damping": {"time": 0.01}}, MATERIAL, (0.001, 0.1)),
        pytest.param(
            *(8, "clamped", {"external_damping": {"coefficient": 0.5}}, EXTERNAL, (0.1, 5.0)),
            marks=pytest.mark.long,
        ),
        (6, "free", {"material_damping": {"time": 0.003}}, MATERIAL, (0.001, 0.01)),
        pytest.param(*(6, "clamped", {}, "rod.length", (0.8, 1.3)), marks=pytest.mark.long),
        (4, "clamped", {"gravity": {"g": 1.0}}, "loads.gravity.g", (0.0, 2.0)),
    ],
    ids=["material", "external", "free", "length", "bent"],
)
def test_every_point_is_a_critical_force(
    rod: Rod, n: int, boundary: str, loads: dict[str, Any], key: str, ends: tuple[float, float]
) -> None:
    scene = rod(n, boundary, {"follower": {"force": 0.0}} | loads, **ONES)
    found = stability_boundary(scene, (FOLLOWER, key), ranges=(None, ends))
    last = found.sizes["point"] - 1
    assert found["b"].values[[0, -1]] == pytest.approx(ends)
    for at in (0, last // 3, 2 * last // 3, last):
        critical = rodgen.critical_force(with_value(scene, key, float(found["b"][at])))
        assert float(found["a"][at]) == pytest.approx(critical.force, rel=1e-9)
        assert float(found["frequency"][at]) == pytest.approx(critical.frequency, rel=1e-6)


def test_divergence_under_two_dead_loads(rod: Rod) -> None:
    """A column buckles under its weight alone and under less of it beside a dead force; a force
    upwards lets it bear more. Every point has a stiffness that is singular."""
    loads = {"gravity": {"g": 1.0}, "tip": {"x": 0.0, "y": 0.0}}
    scene = rod(10, "clamped", loads, clamp_angle=np.pi / 2, **ONES)
    keys = "loads.gravity.g", "loads.tip.y"
    found = stability_boundary(scene, keys, ranges=(None, (-2.0, 2.0)))
    assert found.attrs["kind"] == "divergence"
    assert not found["frequency"].any()
    for at in (0, found.sizes["point"] // 2, -1):
        pulled = with_value(scene, keys[1], float(found["b"][at]))
        critical = rodgen.critical_force(pulled, load="gravity")
        assert float(found["a"][at]) == pytest.approx(critical.force, rel=1e-9)


def test_much_damping_has_a_limit(rod: Rod) -> None:
    """A rod in a fluid so thick that inertia does not count flutters at a load that no longer
    depends on it."""
    loads = {"follower": {"force": 1.0}, "external_damping": {"coefficient": 1.0}}
    found = stability_boundary(rod(6, "clamped", loads, **ONES), (FOLLOWER, EXTERNAL))
    assert "much damping" in found.attrs["end"]
    assert "end of the range" in found.attrs["end"]  # no damping, the other limit
    least = with_value(rod(6, "clamped", loads, **ONES), EXTERNAL, 1e-6)
    assert float(found["a"][0]) == pytest.approx(rodgen.critical_force(least).force, rel=1e-10)
    much = np.diff(found["a"].values[-4:])
    assert np.abs(much).max() < 1e-6


def test_two_dampings_at_a_force_between_both_onsets(rod: Rod) -> None:
    """Between the limit of vanishing damping and the onset without any, the boundary in the plane
    of two dampings goes straight into the origin: a section of Whitney's umbrella."""
    loads = {
        "follower": {"force": 16.0},
        "internal_damping": {"coefficient": 0.0},
        "external_damping": {"coefficient": 0.0},
    }
    scene = rod(3, "cantilever", loads, inertia="lumped", **ONES)
    found = stability_boundary(scene, (INTERNAL, EXTERNAL))
    a, b = found["a"].values, found["b"].values
    assert b[0] == 0.0
    assert abs(a[0]) < 1e-6
    at = len(a) // 2
    damped = with_value(with_value(scene, INTERNAL, float(a[at])), EXTERNAL, float(b[at]))
    assert rodgen.critical_force(damped).force == pytest.approx(16.0, rel=1e-8)


def test_a_boundary_costs_a_tenth_of_as_many_critical_forces(rod: Rod) -> None:
    loads = {"follower": {"force": 1.0}, "material_damping": {"time": 0.01}}
    scene = rod(20, "clamped", loads, **ONES)
    rodgen.critical_force(scene)
    shares = []
    for _ in range(3):
        start = process_time()
        for _ in range(5):
            rodgen.critical_force(scene)
        middle = process_time()
        found = stability_boundary(scene, (FOLLOWER, MATERIAL), step=0.03)
        points = found.sizes["point"]
        shares.append((process_time() - middle) / points / ((middle - start) / 5))
    assert points > 150
    assert min(shares) < 0.1


@pytest.mark.parametrize(
    ("keys", "ranges", "field"),
    [
        ((FOLLOWER, FOLLOWER), (None, None), "vary"),
        ((FOLLOWER, "loads.nothing.x"), (None, None), "vary"),
        ((FOLLOWER, "rod.links"), (None, None), "rod.links"),
        ((FOLLOWER, INTERNAL), (None, (1.0, 0.0)), f"vary.{INTERNAL}"),
        ((FOLLOWER, INTERNAL), (None, (0.0, float("inf"))), f"vary.{INTERNAL}"),
    ],
)
def test_what_has_no_boundary(ziegler: Scene, keys: Any, ranges: Any, field: str) -> None:
    with pytest.raises(SceneError) as error:
        stability_boundary(ziegler, keys, ranges=ranges)
    assert error.value.field == field


def test_nothing_begins_in_a_range(ziegler: Scene) -> None:
    with pytest.raises(AnalysisError, match=r"rod\.mass"):
        stability_boundary(ziegler, ("rod.mass", INTERNAL), ranges=((1.0, 2.0), None))


def test_what_has_no_effect() -> None:
    """External damping of a rod in flight has no linear part."""
    scene = Scene.from_toml(Path(__file__).parents[2] / "scenes" / "missile.toml")
    with pytest.raises(SceneError, match="small motions depend on"):
        stability_boundary(scene, (FOLLOWER, EXTERNAL))
