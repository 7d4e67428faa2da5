"""Boundaries of stability: against Ziegler's pendulum in closed form, and critical loads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.boundary_equations import BoundaryProblem, Scale
from rodgen.analyse.branches.stability_boundary import stability_boundary
from rodgen.analyse.branches.stability_region import OutlineTracer
from rodgen.analyse.curves.continuation import StepControl
from rodgen.analyse.pencil import MatrixPencil
from rodgen.errors import AnalysisError
from tests.analyse.rods import FORCE, ONES, eigenvalues, rod
from tests.sets import sets
from tests.told import refused

INTERNAL = "loads.internal_damping.coefficient"
MATERIAL, EXTERNAL = "loads.material_damping.time", "loads.external_damping.coefficient"


def test_ziegler_paradox_in_closed_form() -> None:
    """With damping B the pendulum flutters at P l/k = 41/28 + B^2/2 (G. Herrmann and I.-C. Jong,
    J. Appl. Mech. 32 (1965) 592), a ninth of the force; c_int = 0.18 is B^2 = 0.0648. The limit of
    none is a point of the boundary, far below the 7/2 - sqrt(2) of no damping; the points are in
    the order of the keys."""
    loads = {"follower": {"force": 2.0}, "internal_damping": {"coefficient": 0.18}}
    ziegler = rod(3, "cantilever", loads, inertia="lumped", **ONES)
    found = stability_boundary(ziegler, (FORCE, INTERNAL))
    force, damping = found["a"].values, found["b"].values
    assert damping[0] == 0.0
    assert force[0] == pytest.approx(9 * 41 / 28, rel=1e-12)
    due = 9 * (41 / 28 + (damping / 0.18) ** 2 * 0.0648 / 2)
    np.testing.assert_allclose(force, due, rtol=1e-10)
    at = int(np.argmin(np.abs(damping - 0.18)))
    assert (damping[at], force[at]) == pytest.approx((0.18, 13.4701714286), rel=1e-11)
    assert found.attrs["complete"]
    assert rodgen.critical_load(ziegler).value == pytest.approx(force[at], rel=1e-11)
    without = ziegler.replace({INTERNAL: 0.0})
    assert rodgen.critical_load(without).value == pytest.approx(9 * (3.5 - np.sqrt(2)), rel=1e-10)
    other = stability_boundary(ziegler, (INTERNAL, FORCE))
    np.testing.assert_allclose(force, other["b"], rtol=1e-9)
    assert other.attrs["a"] == INTERNAL
    with pytest.raises(AnalysisError, match=r"rod\.mass"):  # nothing begins in that range
        stability_boundary(ziegler, ("rod.mass", INTERNAL), bounds=((1.0, 2.0), None))


@pytest.mark.parametrize(
    ("n", "boundary", "loads", "key", "ends"),
    sets(
        [(5, "clamped", {"material_damping": {"time": 0.01}}, MATERIAL, (0.001, 0.1))],
        slow=[
            (4, "free", {"material_damping": {"time": 0.003}}, MATERIAL, (0.001, 0.01)),
            (3, "clamped", {"gravity": {"g": 1.0}}, "loads.gravity.g", (0.0, 2.0)),
        ],
        nightly=[(5, "clamped", {}, "rod.length", (0.8, 1.3))],
    ),
    ids=["material", "free", "bent", "length"],
)
def test_every_point_is_a_critical_force(
    n: int, boundary: str, loads: dict[str, Any], key: str, ends: tuple[float, float]
) -> None:
    scene = rod(n, boundary, {"follower": {"force": 0.0}} | loads, **ONES)
    found = stability_boundary(scene, (FORCE, key), bounds=(None, ends))
    last = found.sizes["point"] - 1
    assert found["b"].values[[0, -1]] == pytest.approx(ends)
    for at in (0, last // 2, last):
        critical = rodgen.critical_load(scene.replace({key: float(found["b"][at])}))
        assert float(found["a"][at]) == pytest.approx(critical.value, rel=1e-9)
        assert float(found["frequency"][at]) == pytest.approx(critical.frequency, rel=1e-6)


def test_boundary_of_a_rod_whose_thrust_is_steered_by_an_actuator() -> None:
    """An added state has no inertia: the pencil's last matrix is singular."""
    steered = {"follower": {"force": 1.0, "angle": "turn"}, "material_damping": {"time": 0.01}}
    states = {"turn": {"rate": "(gain*phi(1) - turn)/0.1"}}
    gain = {"parameters": {"gain": 0.1}, "states": states}
    scene = rod(3, "clamped", steered, **gain, **ONES)
    found = stability_boundary(scene, (FORCE, "parameters.gain"), bounds=(None, (0.05, 0.3)))
    for at in (0, -1):
        there = scene.replace({"parameters.gain": float(found["b"][at])})
        assert float(found["a"][at]) == pytest.approx(rodgen.critical_load(there).value, rel=1e-9)


def test_divergence_under_two_dead_loads() -> None:
    """A column buckles under its weight alone and under less of it beside a dead force; a force
    upwards lets it bear more. Every point has a stiffness that is singular."""
    loads = {"gravity": {"g": 1.0}, "tip": {"x": 0.0, "y": 0.0}}
    scene = rod(5, "clamped", loads, clamp_angle=np.pi / 2, **ONES)
    keys = "loads.gravity.g", "loads.tip.y"
    found = stability_boundary(scene, keys, bounds=(None, (-2.0, 2.0)))
    assert found.attrs["kind"] == "divergence"
    assert not found["frequency"].any()
    for at in (0, found.sizes["point"] // 2, -1):
        pulled = scene.replace({keys[1]: float(found["b"][at])})
        critical = rodgen.critical_load(pulled, load="gravity")
        assert float(found["a"][at]) == pytest.approx(critical.value, rel=1e-9)


@pytest.mark.slow
def test_much_damping_has_a_limit() -> None:
    """A rod in a fluid so thick that inertia does not count flutters at a load that no longer
    depends on it."""
    loads = {"follower": {"force": 1.0}, "external_damping": {"coefficient": 1.0}}
    scene = rod(5, "clamped", loads, **ONES)
    found = stability_boundary(scene, (FORCE, EXTERNAL))
    assert found.attrs["complete"]
    force, damping = found["a"].values, found["b"].values
    assert damping[0] == 0.0
    least = scene.replace({EXTERNAL: 1e-6})
    assert force[0] == pytest.approx(rodgen.critical_load(least).value, rel=1e-10)
    # Beyond where inertia counts, points go on as far as needed for the load to stand still.
    assert damping[-1] > 10.0
    assert np.abs(np.diff(force[-4:])).max() < 1e-6


class Pair:
    """Two motions that do not know of each other, and begin to grow at a = 1 and at b = 1."""

    keys, n_added_states = ("a", "b"), 0

    def matrices(self, a: float, b: float) -> MatrixPencil:
        K, M = np.diag([1.0, 9.0]), np.eye(2)
        C = np.array([[1.0 - a, 0.0], [0.0, 1.0 - b]])
        return MatrixPencil(K, C, M)

    def slopes(self, a: float, b: float) -> tuple[MatrixPencil, MatrixPencil]:
        nothing = np.zeros((2, 2))
        by = (MatrixPencil(nothing, np.diag(way), nothing) for way in ([-1.0, 0.0], [0.0, -1.0]))
        return next(by), next(by)


def test_the_outline_turns_where_another_motion_begins() -> None:
    plain = Scale(1.0, curved=False)
    boundary = BoundaryProblem(Pair(), (plain, plain), 1.0, True)
    outline = OutlineTracer(
        [(-2.0, 2.0), (-2.0, 2.0)], StepControl.of(0.1, 1000, 4), lambda point: None
    )
    found = outline.trace(boundary, 1.0, 1.0, 0.0)
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


@pytest.mark.parametrize(("tau", "corner"), sets([(0.0, None)], slow=[(0.02, (5 / 6, 2 / 3))]))
def test_flutter_goes_on_as_divergence(tau: float, corner: Any) -> None:
    """Ziegler's pendulum under a follower force p and a dead one f (both times l/k): it diverges at
    p = 3 - f - 1/f; there flutter begins with frequency zero, without damping where the trace of
    M^-1 K vanishes as well, 2 f^2 - f - 2 = 0, with damping in the springs at (5/6, 2/3)."""
    loads = {"follower": {"force": 2.0}, "tip": {"x": 0.0, "y": 0.0}}
    if tau:
        loads["material_damping"] = {"time": tau}
    scene = rod(3, "cantilever", loads, inertia="lumped", **ONES)
    ends = ((-30.0, 30.0), (-30.0, 10.0))
    found = stability_boundary(scene, (FORCE, "loads.tip.x"), bounds=ends)
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
            there = scene.replace({FORCE: a, "loads.tip.x": b})
            s = eigenvalues(there)
            grow.append(bool(s.real.max() > 1e-6 * np.abs(s).max()))
        assert sorted(grow) == [False, True]


@pytest.mark.slow
def test_a_cusp_is_named() -> None:
    """Of an undamped column that a spring holds in its middle the pair of motions that flutters
    changes: the boundary comes to a point, where both numbers stand still along it."""
    support = [{"at": 0.5, "stiffness": [0.0, 10.0]}]
    scene = rod(4, "clamped", {"follower": {"force": 1.0}}, supports=support, **ONES)
    keys, ends = (FORCE, "supports.0.stiffness.1"), ((0.0, 400.0), (0.0, 1500.0))
    found = stability_boundary(scene, keys, bounds=ends)
    assert "cusp" in found["special_kind"].values
    at = int(found["special_after"][list(found["special_kind"].values).index("cusp")])
    a, b = found["a"].values, found["b"].values
    before, after = (np.array([a[k + 1] - a[k], b[k + 1] - b[k]]) for k in (at - 1, at + 1))
    assert before @ after < 0


def test_a_boundary_begins_in_its_range_or_not_at_all() -> None:
    """Beck's column with a little damping flutters at some 11 EI/L^2: by the range of the force, of
    the other number, and of one without width."""
    scene = rod(3, "clamped", {"follower": {"force": 2.0}, "material_damping": {"time": 0.1}})
    force = rodgen.critical_load(scene).value
    for a in ((1.0, 2.0), (force + 1, force + 2)):
        with pytest.raises(AnalysisError, match=r"loads\.follower\.force"):
            stability_boundary(scene, (FORCE, MATERIAL), bounds=(a, (0.05, 0.2)))
    narrow = (1.0, 1.0000000000000002)
    for bounds in ((narrow, None), (None, narrow)):
        told = refused(stability_boundary, scene, (FORCE, MATERIAL), bounds=bounds)
        assert (told.field, told.value) == ("bounds", narrow)
    whole = stability_boundary(scene, (FORCE, MATERIAL), bounds=((0.0, 2 * force), (0.05, 0.2)))
    outside = {"resume": whole, "bounds": ((0.0, force / 4), (0.05, 0.2))}
    with pytest.raises(AnalysisError, match=r"loads\.follower\.force"):
        stability_boundary(scene, (FORCE, MATERIAL), **outside)
