"""Cycles: against SciPy's collocation and differences of motions, by any number of segments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp

import rodgen
from rodgen.analyse.cycles.cycle import Cycle, find_cycle
from rodgen.analyse.cycles.elimination import multipliers
from rodgen.analyse.errors import AnalysisError
from rodgen.scene import Scene, SceneError

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
    "given", [{"period": 1.0}, {"y0": NEAR}, {"segments": 0}, {"y0": [0.0], "period": 1.0}]
)
def test_values_that_cannot_be_used(given: dict[str, Any]) -> None:
    with pytest.raises(SceneError):
        find_cycle(Scene.from_dict(ZIEGLER), target="numpy", **given)
