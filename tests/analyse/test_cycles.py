"""Cycles: against SciPy's collocation and differences of motions, by any number of segments."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp

import rodgen
from rodgen.analyse.cycles.cycle import Cycle
from rodgen.analyse.cycles.elimination import multipliers
from rodgen.analyse.cycles.search import Search, find_cycle
from rodgen.analyse.errors import AnalysisError
from rodgen.scene import Scene, SceneError

SCENES = Path(__file__).parents[2] / "scenes"
# Ziegler's double pendulum with damping, beyond its flutter.
ZIEGLER: dict[str, Any] = {
    "name": "ziegler",
    "rod": {
        "links": 3,
        "length": 1.0,
        "mass": 1.0,
        "bending_stiffness": 1.0,
        "boundary": "cantilever",
        "inertia": "lumped",
    },
    "loads": {"follower": {"force": 16.0}, "internal_damping": {"coefficient": 0.3}},
    "initial": {"phi": [0.2, 0.1]},
    "integrate": {"span": [0.0, 12.0], "rtol": 1e-8, "atol": 1e-10},
}
# Near the cycle; three digits suffice to begin with.
NEAR, ABOUT = [-0.514, -0.998, 2.545, 3.172], 0.887


@pytest.fixture(scope="module")
def cycle() -> Cycle:
    return find_cycle(Scene.from_dict(ZIEGLER), y0=NEAR, period=ABOUT, target="numpy")


@pytest.mark.nightly
def test_by_collocation_of_scipy(cycle: Cycle) -> None:
    """A fourth-order boundary value solver finds the same period, and the multipliers are those of
    differences of motions."""
    scene = Scene.from_dict(ZIEGLER)
    model = rodgen.build(scene)
    p = model.parameters(**scene.parameters)

    def rates(t: float, y: Any) -> Any:
        return model.rhs(t, y, p)

    def after(y: Any, span: float) -> Any:
        return solve_ivp(rates, (0, span), y, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]

    start = np.array(NEAR)
    times = np.linspace(0, 1, 400)
    guess = solve_ivp(rates, (0, ABOUT), start, "DOP853", t_eval=times * ABOUT, rtol=1e-8).y
    # Time over the period; where it starts on the cycle is given by one of the angles.
    found = solve_bvp(
        lambda s, y, T: T[0] * np.array([rates(0.0, one) for one in y.T]).T,
        lambda a, b, T: np.append(a - b, a[0] - start[0]),
        times,
        guess,
        [ABOUT],
        tol=1e-7,
        max_nodes=20000,
    )
    assert found.success
    assert cycle.period == pytest.approx(found.p[0], rel=1e-8)
    y0 = found.y[:, 0]
    columns = [after(y0 + d, cycle.period) - after(y0 - d, cycle.period) for d in 1e-5 * np.eye(4)]
    expected = np.linalg.eigvals(np.array(columns).T / 2e-5)
    for mu in expected:
        assert np.abs(cycle.multipliers - mu).min() < 1e-6
    assert cycle.trivial_error < 1e-8
    assert cycle.trivial == 1
    assert cycle.stable


def test_from_a_run_as_from_nearby(cycle: Cycle) -> None:
    found = find_cycle(Scene.from_dict(ZIEGLER), target="numpy")
    assert found.period == pytest.approx(cycle.period, rel=1e-9)
    np.testing.assert_allclose(
        np.sort(np.abs(found.nontrivial)), np.sort(np.abs(cycle.nontrivial)), rtol=1e-6, atol=1e-12
    )
    # What thrust brings in, damping takes out.
    assert sum(found.work.values()) == pytest.approx(0, abs=1e-9 * found.work["follower"])


def test_shooting_finds_what_collocation_finds(cycle: Cycle) -> None:
    """Two discretisations with nothing in common but the rates: to the tolerance of either."""
    assert cycle.by == "collocation"
    assert cycle.error < 1e-9
    shot = find_cycle(
        Scene.from_dict(ZIEGLER), y0=NEAR, period=ABOUT, by="shooting", target="numpy"
    )
    assert shot.by == "shooting"
    assert shot.period == pytest.approx(cycle.period, rel=1e-9)
    for mu in shot.multipliers:
        assert np.abs(cycle.multipliers - mu).min() < 1e-8


@pytest.mark.parametrize("count", [2, 4])
def test_leading_multipliers_are_those_of_all(cycle: Cycle, count: int) -> None:
    """Newton's method on a few directions, Picard's iteration on the rest."""
    found = find_cycle(
        Scene.from_dict(ZIEGLER), y0=NEAR, period=ABOUT, multipliers=count, target="numpy"
    )
    assert found.by == "picard"
    assert len(found.multipliers) == count
    assert found.period == pytest.approx(cycle.period, rel=1e-10)
    np.testing.assert_allclose(
        np.abs(found.multipliers), np.abs(cycle.multipliers[:count]), atol=1e-9
    )


@pytest.mark.nightly  # it compiles a structure of its own
def test_stiff_cycles_by_radau_as_by_dop853() -> None:
    """Tangents of an implicit stepper, whose steps are longer than the fastest motion lasts: it
    decays by exp(-60000) in a period."""
    table = Scene.from_toml(SCENES / "beck_after_flutter.toml").model_dump(exclude_none=True)
    table["rod"]["links"], table["loads"]["material_damping"]["time"] = 20, 0.01
    scene = Scene.from_dict(table)
    leading = find_cycle(scene, multipliers=3)
    flow = Search.of(scene).flow(0.0, leading.y0)
    x, period = leading.y0[flow.quotient.kept], leading.period
    assert flow.suited(0.0, x, period).method == "radau"
    slow, fast = (
        replace(flow, method=method).with_tangents(0.0, x, period / 8)
        for method in ("dop853", "radau")
    )
    for a, b in zip(slow, fast, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-8 * np.abs(a).max())
    whole = find_cycle(scene, y0=leading.y0, period=leading.period)
    assert whole.by == "collocation"
    assert whole.period == pytest.approx(leading.period, rel=1e-9)
    np.testing.assert_allclose(
        np.abs(whole.multipliers[:3]), np.abs(leading.multipliers), atol=1e-8
    )
    # Nothing of the fastest motions is left after a period, whatever the steps.
    assert np.abs(whole.multipliers[8:]).max() < 1e-12


@pytest.mark.nightly  # a third of it on one core: hundreds of intervals of a module without a compiler
@pytest.mark.parametrize(
    ("load", "within"),
    [
        ({"drag": {"normal": 0.5, "tangential": 0.1}}, 1e-9),
        ({"external_damping": {"coefficient": 0.5}}, 1e-7),
    ],
)
def test_a_kink_takes_more_intervals_and_what_is_left_is_told(
    load: dict[str, Any], within: float
) -> None:
    """The order of collocation is lost; the mesh gathers at the kinks. Multipliers by shooting are
    right to some 1e-6 there."""
    scene = Scene.from_dict(ZIEGLER | {"loads": ZIEGLER["loads"] | load})
    found = find_cycle(scene, y0=NEAR, period=ABOUT, target="numpy")
    assert found.error < within
    assert found.trivial_error < 10 * within
    shot = find_cycle(scene, y0=found.y0, period=found.period, by="shooting", target="numpy")
    assert shot.period == pytest.approx(found.period, rel=1e-10)
    assert np.abs(shot.nontrivial[0] - found.nontrivial[0]) < 1e-5


@pytest.mark.parametrize("segments", [1, 3, 20])
def test_as_stable_with_any_number_of_segments(cycle: Cycle, segments: int) -> None:
    scene = Scene.from_dict(ZIEGLER)
    found = find_cycle(scene, y0=cycle.y0, period=cycle.period, segments=segments, target="numpy")
    assert found.period == pytest.approx(cycle.period, rel=1e-10)
    key = np.sort_complex(np.round(found.nontrivial, 12))
    np.testing.assert_allclose(key, np.sort_complex(np.round(cycle.nontrivial, 12)), atol=1e-9)
    assert found.trivial_error < 1e-8


@pytest.mark.parametrize("segments", [3, 5, 20])
def test_multipliers_that_a_product_of_segments_loses(segments: int) -> None:
    """Of segments that are made from their multipliers, from 1e14 to 1e-6: beside the largest, a
    product is all rounding below 1e-2."""
    random = np.random.default_rng(3)
    mu = np.array([1e14, 1e6, 1.0, 0.5, 1e-3, 1e-6])
    bases = [np.linalg.qr(random.standard_normal((6, 6)))[0] for _ in range(segments)]
    share = np.diag(mu ** (1 / segments))
    G = [bases[(i + 1) % segments] @ share @ bases[i].T for i in range(segments)]
    product = np.linalg.multi_dot(G[::-1])
    assert abs(np.sort(np.abs(np.linalg.eigvals(product)))[1] - 1e-3) > 1e-4
    found = multipliers(G)
    # Errors are those of angles: 1e-16 about 1, and as much of the inverse of a large one.
    assert found[0].real == pytest.approx(mu[0], rel=1e-2)
    np.testing.assert_allclose(found.real[1:4], mu[1:4], rtol=1e-9)
    np.testing.assert_allclose(found[4:], mu[4:], atol=1e-9)


def test_what_is_no_cycle_is_refused() -> None:
    below = ZIEGLER | {"loads": ZIEGLER["loads"] | {"follower": {"force": 5.0}}}
    at_rest = Scene.from_dict(below | {"initial": {"phi": 0.0}})
    with pytest.raises(AnalysisError, match="come to rest"):
        find_cycle(at_rest, target="numpy")
    with pytest.raises(AnalysisError, match="no "):
        find_cycle(Scene.from_dict(below), y0=[0.3, 0.1, 0, 0], period=1.0, target="numpy")


@pytest.mark.parametrize(
    "given",
    [
        {"period": 1.0},
        {"y0": NEAR},
        {"segments": 0},
        {"y0": [0.0], "period": 1.0},
        {"by": "hand"},
        {"by": "collocation", "segments": 3},
        {"by": "shooting", "multipliers": 3},
        {"segments": 3, "multipliers": 3},
        {"multipliers": 0},
    ],
)
def test_values_that_cannot_be_used(given: dict[str, Any]) -> None:
    with pytest.raises(SceneError):
        find_cycle(Scene.from_dict(ZIEGLER), target="numpy", **given)
