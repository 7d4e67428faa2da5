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
from rodgen.analyse.branches.boundary_equations import Boundary, Matrices, Scale
from rodgen.analyse.branches.outline import Outline
from rodgen.analyse.curves.continuation import Steps
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
            marks=pytest.mark.nightly,
        ),
        (6, "free", {"material_damping": {"time": 0.003}}, MATERIAL, (0.001, 0.01)),
        pytest.param(*(6, "clamped", {}, "rod.length", (0.8, 1.3)), marks=pytest.mark.nightly),
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
    assert "vanishing damping" in found.attrs["end"]
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


class Pair:
    """Two motions that do not know of each other, and begin to grow at a = 1 and at b = 1."""

    keys, added = ("a", "b"), 0

    def at(self, a: float, b: float) -> Matrices:
        K, M = np.diag([1.0, 9.0]), np.eye(2)
        C = np.array([[1.0 - a, 0.0], [0.0, 1.0 - b]])
        return Matrices(K, C, M)

    def slopes(self, a: float, b: float) -> tuple[Matrices, Matrices]:
        nothing = np.zeros((2, 2))
        by = (Matrices(nothing, np.diag(way), nothing) for way in ([-1.0, 0.0], [0.0, -1.0]))
        return next(by), next(by)


def test_the_outline_turns_where_another_motion_begins() -> None:
    plain = Scale(1.0, curved=False)
    boundary = Boundary(Pair(), (plain, plain), 1.0, True)  # type: ignore[arg-type]  # a stand-in
    outline = Outline([(-2.0, 2.0), (-2.0, 2.0)], Steps.of(0.1, 1000, 4), lambda point: None)
    found = outline.around(boundary, 1.0, 1.0, 0.0)
    a, b, frequency, _ = np.array([point.u for point in found.points]).T
    (corner,) = found.special
    assert corner.kind == "corner"
    np.testing.assert_allclose(corner.u[:3], [1.0, 1.0, 1 / (2 * np.pi)], atol=1e-10)
    at = corner.after + 1
    np.testing.assert_allclose(a[:at], 1.0, atol=1e-10)
    np.testing.assert_allclose(b[at:], 1.0, atol=1e-10)
    assert (b[0], a[-1] < -1.9) == (-2.0, True)
    np.testing.assert_allclose(2 * np.pi * frequency[[0, -1]], [1.0, 3.0], rtol=1e-10)
    assert found.complete


@pytest.mark.parametrize(("tau", "corner"), [(0.0, None), (0.02, (5 / 6, 2 / 3))])
def test_flutter_goes_on_as_divergence(rod: Rod, tau: float, corner: Any) -> None:
    """Ziegler's pendulum under a follower force p and a dead one f (both times l/k): it diverges at
    p = 3 - f - 1/f; there flutter begins with frequency zero, without damping where the trace of
    M^-1 K vanishes as well, 2 f^2 - f - 2 = 0, with damping in the springs at (5/6, 2/3)."""
    loads = {"follower": {"force": 2.0}, "tip": {"x": 0.0, "y": 0.0}}
    if tau:
        loads["material_damping"] = {"time": tau}
    scene = rod(3, "cantilever", loads, inertia="lumped", **ONES)
    ends = ((-30.0, 30.0), (-30.0, 10.0))
    found = stability_boundary(scene, (FOLLOWER, "loads.tip.x"), ranges=ends)
    assert found["special_kind"].values.tolist() == ["zero frequency"]
    p, f = float(found["special_a"][0]) / 9, -float(found["special_b"][0]) / 9
    if corner is None:
        f0 = (1 + np.sqrt(17)) / 4
        corner = 3 - f0 - 1 / f0, f0
    # 1e-9: the frequency is zero to a millionth there, of which everything follows the square.
    assert (p, f) == pytest.approx(corner, rel=1e-9)
    still = found["frequency"].values == 0.0
    p, f = found["a"].values[still] / 9, -found["b"].values[still] / 9
    np.testing.assert_allclose(p, 3 - f - 1 / f, atol=1e-9)
    assert still.sum() > 20
    assert (~still).sum() > 20
    assert found.attrs["complete"]
    # It is the outline of what is stable: to one side of it something grows, to the other nothing.
    model = rodgen.build(scene, "numpy")
    points = np.array([found["a"].values, found["b"].values]).T
    there_both = points[int(found["special_after"][0])]
    for at in range(5, found.sizes["point"] - 1, 10):
        if np.linalg.norm(points[at] - there_both) < 0.5:
            continue  # so near both sides are as near to the other motion
        along = points[at + 1] - points[at - 1]
        across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
        grow = []
        for way in (-0.01, 0.01):
            a, b = (points[at] + way * across).tolist()
            there = with_value(with_value(scene, FOLLOWER, a), "loads.tip.x", b)
            J = model.jac(0.0, there.initial_state(), model.parameters(**there.parameters))
            s = np.linalg.eigvals(J)
            grow.append(bool(s.real.max() > 1e-6 * np.abs(s).max()))
        assert sorted(grow) == [False, True]


@pytest.mark.nightly
def test_a_cusp_is_named(rod: Rod) -> None:
    """Of an undamped column that a spring holds in its middle the pair of motions that flutters
    changes: the boundary comes to a point, where both numbers stand still along it."""
    support = [{"at": 0.5, "stiffness": [0.0, 10.0]}]
    table = rod(4, "clamped", {"follower": {"force": 1.0}}, **ONES).model_dump(exclude_none=True)
    scene = Scene.from_dict(table | {"supports": support})
    found = stability_boundary(
        scene, (FOLLOWER, "supports.0.stiffness.1"), ranges=((0.0, 400.0), (0.0, 1500.0))
    )
    assert "cusp" in found["special_kind"].values
    at = int(found["special_after"][list(found["special_kind"].values).index("cusp")])
    a, b = found["a"].values, found["b"].values
    before, after = (np.array([a[k + 1] - a[k], b[k + 1] - b[k]]) for k in (at - 1, at + 1))
    assert before @ after < 0
