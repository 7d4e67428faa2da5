"""What a tolerance asks for is what the implicit methods give, at the price of their order."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate import Solution
from rodgen.integrate.stability import step_limit
from rodgen.model.methods import METHODS
from tests.compiled.conftest import SMOOTH

TOLERANCES = 10.0 ** -np.arange(3, 12)
ORDERS = {"gauss": 6, "radau": 5}


@pytest.fixture(scope="module")
def exact(model: ModuleType) -> Solution:
    """By another family of methods, 100 times as sharp as the sharpest of these runs."""
    return _run(model, "dop853", 1e-13)


def _run(model: ModuleType, method: str, rtol: float, **how: Any) -> Solution:
    scene = Scene.from_dict(SMOOTH)
    return rodgen.simulate(scene, model=model, method=method, rtol=rtol, atol=rtol / 100, **how)


def _over_tolerance(sol: Solution, exact: Solution, rtol: float) -> float:
    """Largest error over all samples, which lie between steps, in tolerances: of the positions by
    gauss, which judges these alone, else of all states."""
    count = sol.y.shape[1] // (2 if sol.scene.integrate.method == "gauss" else 1)
    allowed = rtol * np.abs(exact.y[:, :count]).max(axis=0) + rtol / 100
    return float(np.sqrt(np.mean(((sol.y - exact.y)[:, :count] / allowed) ** 2, axis=1)).max())


@pytest.mark.parametrize("method", ORDERS)
def test_errors_follow_the_tolerance(model: ModuleType, exact: Solution, method: str) -> None:
    sols = [_run(model, method, rtol) for rtol in TOLERANCES]
    errors = [_over_tolerance(*pair) for pair in zip(sols, [exact] * 9, TOLERANCES, strict=True)]
    assert min(errors) > 0.005
    assert max(errors) < 1
    # What control of a method of that order asks for, over the last three powers of ten: where
    # tolerances are loose it is the estimate of order 3 that holds.
    steps = np.array([sol.stats.nsteps for sol in sols], dtype=float)
    assert steps[-1] / steps[-4] < 1.05 * 10 ** (3 / ORDERS[method])
    assert sum(sol.stats.rejected or 0 for sol in sols) < 0.05 * steps.sum()
    # Works and rates at samples inside of steps too: dense output is of the order of the steps.
    sol = sols[6]
    assert sol.stats.nsteps > 2 * len(sol.t)
    largest = np.abs(sol.y - exact.y).max(axis=0)
    # Twice what the last sample, an end of a step, is off by, or what rates swing by meanwhile.
    assert (largest < 1e-9 * np.abs(exact.y).max(axis=0) + 5e-10).all()
    for term, work in sol.work.items():
        assert np.abs(work - exact.work[term]).max() < 1e-9 * max(1.0, np.abs(work).max())


def test_both_targets_take_as_many_steps(model: ModuleType, smooth: Scene, exact: Solution) -> None:
    """DOP853 is SciPy's, with the same estimate of the error and choice of the next step, so that
    rounding decides one or two; Gauss's in Python makes derivatives anew for every step."""
    walker = rodgen.build(smooth, "numpy")
    for method, within in (("dop853", {"abs": 2}), ("gauss", {"rel": 0.15})):
        for rtol in (1e-4, 1e-8):
            compiled, walked = (_run(each, method, rtol) for each in (model, walker))
            ours, theirs = compiled.stats, walked.stats
            assert ours.nsteps == pytest.approx(theirs.nsteps, **within)
            if method == "dop853":
                assert ours.rejected == pytest.approx(theirs.rejected, **within)
            else:
                assert 0.005 < _over_tolerance(walked, exact, rtol) < 1


@pytest.mark.parametrize("damping", [0.02, 0.1, 5.0])
def test_dop853_knows_the_fastest_motion_that_bounds_its_steps(
    model: ModuleType, smooth: Scene, damping: float
) -> None:
    """Its iteration beside the eigenvalues of the Jacobian, which is exact, and the bound beside
    the root of the stability polynomial: for motions that oscillate, some and hardly, and for one
    that creeps."""
    scene = smooth.replace({"loads.internal_damping.coefficient": damping})
    p = model.parameters(**scene.parameters)
    run = model.Run("dop853", 0.0, scene.initial_state(), p, rtol=1e-8, atol=1e-10)
    run.begin(0.1, longest=1e-4)
    assert run.advance(10**4, (), np.empty((0, len(run.state))))[0] == model.REACHED
    state = run.state[: len(model.STATE)]
    values = np.linalg.eigvals(model.jac(run.numbers.t, state, p))
    fastest = complex(values[np.argmax(np.abs(values))])
    # The last look was up to 32 steps of 1e-4 s before.
    assert run.numbers.modulus == pytest.approx(abs(fastest), rel=0.01)
    # Between the directions of a table it is a straight line.
    assert run.numbers.most == pytest.approx(step_limit("dop853", fastest), rel=0.05)


@pytest.mark.parametrize("method", ["dop853", "gauss", "radau"])
def test_a_tolerance_asks_for_no_more_than_rounding_leaves(
    model: ModuleType, smooth: Scene, method: str
) -> None:
    """Sixteen roundings of a state are the least that is asked for: a tolerance of nothing is one
    of 16 eps, to the bit."""
    p, y0 = model.parameters(**smooth.parameters), smooth.initial_state()
    least = 16 * np.finfo(float).eps
    ends = []
    for rtol in (0.0, 1e-30, least):
        run = model.Run(method, 0.0, y0, p, rtol=rtol, atol=1e-14)
        run.begin(0.01)
        assert run.advance(2000, (), np.empty((0, len(run.state))))[0] == model.REACHED
        ends.append(run.state.copy())
    np.testing.assert_array_equal(ends[0], ends[1])
    # Of an angle below one turn all of its size counts, so that both tolerances are one.
    np.testing.assert_array_equal(ends[0], ends[2])


def test_dop853_keeps_to_what_added_states_allow() -> None:
    """A lag of 1 ms beside a slow rod: steps end where it would be torn apart, in runs and in
    lanes, and none is rejected for it. The bound is the root of the stability polynomial."""
    tables = {
        "loads": {"follower": {"force": 5.0, "angle": "z"}},
        "states": {"z": {"rate": "(0.2*phi(0.5) - z)/tau"}, "w": {"rate": "(z - w)/(2*tau)"}},
        "parameters": {"tau": 1e-3},
    }
    scene = Scene.from_dict(
        {"name": "lag", "rod": SMOOTH["rod"], "initial": {"phi": "0.1*s"}} | tables
    )
    model = rodgen.build(scene, "c", parts=("flow", "power", "lanes"))
    p, y0 = model.parameters(**scene.parameters), scene.initial_state()
    run = model.Run("dop853", 0.0, y0, p, rtol=1e-5, atol=1e-7)
    run.begin(1.0)
    assert run.advance(10**4, (), np.empty((0, len(run.state))))[0] == model.REACHED
    bound = step_limit("dop853", complex(-1e3))
    # The table of bounds is rounded to a thousandth, and a slope is a difference over 1e-6.
    assert run.numbers.most == pytest.approx(bound, rel=2e-3)
    assert run.numbers.rejected == 0
    assert run.numbers.steps == pytest.approx(1.0 / bound, rel=0.1)
    share = METHODS["dop853"].per_step
    tolerances = {"rtol": 1e-5 / share, "atol": 1e-7 / share}
    how: dict[str, Any] = {"method": "dop853", "span": [0.0, 1.0], **tolerances}
    rods = np.tile(p, (3, 1))
    rods[:, model.PARAMETERS.index("tau")] = 1e-3, 5e-4, 2e-3
    made = rodgen.simulate_many(model, rods, y0, **how)
    assert not made.rejected.any()
    assert made.nsteps[0] == run.numbers.steps
    assert made.nsteps[1] == pytest.approx(2.0 / bound, rel=0.1)


@pytest.mark.slow
def test_dop853_looks_beside_a_jump_of_a_rate() -> None:
    """A state that falls to zero and stays just below it: the slope over the jump, a millionth
    away, would ask for steps of microseconds."""
    tables = {"states": {"z": {"rate": "-1 if z >= 0 else 0", "initial": 0.3}}}
    scene = Scene.from_dict({"name": "jump", "rod": SMOOTH["rod"], "initial": {}} | tables)
    run = rodgen.simulate(scene.with_integrate(method="dop853", span=[0.0, 1.0]), target="c")
    assert -1e-6 < run.y[-1, -1] < 0
    assert run.stats.nsteps < 500  # 400 000 by that slope
