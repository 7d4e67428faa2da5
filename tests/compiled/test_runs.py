"""Runs by compiled steps against the same runs in Python, and what they promise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate import Solution
from rodgen.model.methods import FIXED_STEP
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.palette import cases


def _both(scene: Scene, **how: Any) -> list[Solution]:
    return [rodgen.simulate(scene, target=target, **how) for target in ("c", "numpy")]


@pytest.mark.parametrize("method", FIXED_STEP)
def test_fixed_steps_agree_with_python(missile: Scene, method: str) -> None:
    compiled, walked = _both(missile, method=method, step=2e-4, span=[0.25, 0.4])
    # The same sums of rates of either target: rounding, carried along for 750 steps.
    np.testing.assert_allclose(compiled.y, walked.y, rtol=0, atol=1e-9)
    assert compiled.stats.steps == walked.stats.steps
    assert compiled.stats.rhs == walked.stats.rhs


@pytest.mark.parametrize(
    "method", ["dop853", pytest.param("radau", marks=pytest.mark.nightly), "gauss"]
)
def test_adaptive_methods_agree_with_python(missile: Scene, method: str) -> None:
    """Radau is SciPy's, Gauss's coefficients are worked out another way."""
    compiled, walked = _both(missile, method=method, rtol=1e-8, atol=1e-10)
    # Errors of some hundred steps at these tolerances, in rates of up to 100 rad/s.
    np.testing.assert_allclose(compiled.phi, walked.phi, rtol=0, atol=1e-6)
    for term, work in compiled.work.items():
        scale = max(1.0, np.abs(work).max())
        np.testing.assert_allclose(work, walked.work[term], rtol=0, atol=1e-6 * scale)


@cases(
    "method, boundary, inertia",
    ["dop853", "radau", "gauss", "rk4"],
    BOUNDARIES,
    INERTIAS,
)
def test_energy_balances_under_every_load(
    missile: Scene, method: str, boundary: str, inertia: str
) -> None:
    """Work is integrated with the state, energy follows from it: two routes."""
    table = missile.model_dump(exclude_none=True)
    table["rod"] |= {"links": 3, "boundary": boundary, "inertia": inertia}
    table["loads"]["tip"] = {"x": "sin(4*t)", "y": 2.0}
    if boundary != "free":
        table["initial"] = {"phi": 0.3}
    scene = Scene.from_dict(table)
    accuracy = {"step": 1e-4} if method == "rk4" else {"rtol": 1e-9, "atol": 1e-11}
    scene = scene.with_integrate(method=method, **accuracy)
    sol = rodgen.simulate(scene, target="c")
    assert set(sol.work) >= {"follower", "internal_damping", "external_damping", "tip_load"}
    scale = max(np.ptp(work) for work in sol.work.values())
    assert sol.energy_error < 1e-7 * scale


def test_samples_come_from_dense_output_and_change_no_step(missile: Scene) -> None:
    few, many = (
        rodgen.simulate(missile, target="c", method="dop853", output_every=every)
        for every in (1.0, 1e-4)
    )
    assert many.stats.steps == few.stats.steps
    assert many.y[-1].tobytes() == few.y[-1].tobytes()
    exact = rodgen.simulate(missile, target="c", rtol=1e-12, atol=1e-13, output_every=1e-4)
    assert np.abs(many.phi - exact.phi).max() < 1e-7


@pytest.mark.parametrize("method", ["dop853", "radau", "gauss", "rk4"])
def test_break_points_are_stepped_onto(short: Scene, method: str) -> None:
    """A force that is switched at 0.3 s: nothing of the run before it may know of it, and the
    error is that of a smooth run."""
    table = short.model_dump(exclude_none=True)
    table["loads"]["follower"]["force"] = "300 if t < 0.3 else -100"
    accuracy = {"step": 1e-4} if method == "rk4" else {"rtol": 1e-10, "atol": 1e-12}
    table["integrate"] |= {"method": method, **accuracy}
    scene = Scene.from_dict(table)
    whole = rodgen.simulate(scene, target="c")
    table["loads"]["follower"]["force"] = 300.0
    table["integrate"]["span"] = [0.0, 0.3]
    first = rodgen.simulate(Scene.from_dict(table), target="c")
    at = len(first.t) - 1
    assert whole.t[at] == pytest.approx(0.3, abs=1e-15)
    # One is a sum of steps of output_every, the other the end of a span.
    np.testing.assert_allclose(whole.y[at], first.y[-1], rtol=1e-12, atol=1e-12)
    exact = rodgen.simulate(scene, target="numpy", method="dop853", rtol=1e-12, atol=1e-13)
    assert np.abs(whole.phi - exact.phi).max() < 1e-7


def test_energy_over_a_million_steps() -> None:
    """A conservative pendulum of two links that swings regularly: semi-implicit Euler keeps its
    energy here, though not that of rods in general, and the classical method loses it slowly."""
    scene = Scene.from_dict(
        {
            "name": "pendulum",
            "rod": {
                "links": 2,
                "length": 2.0,
                "bending_stiffness": 1.0,
                "mass": 1.0,
                "boundary": "pinned",
            },
            "loads": {"gravity": {}},
            "initial": {"phi": "-1.57 + 0.2*s"},
            "integrate": {"span": [0.0, 2000.0], "output_every": 2.0, "step": 2e-3},
        }
    )
    first, last = slice(0, 100), slice(-100, None)
    sizes = {}
    for method in ("semi_implicit_euler", "rk4", "thesis_runge_kutta"):
        sol = rodgen.simulate(scene, target="c", method=method)
        assert sol.stats.steps == 10**6
        error = np.abs(sol.energy.total - sol.energy.total[0])
        sizes[method] = error[first].max(), error[last].max()
    kinetic = sol.energy.kinetic[:100].max()
    # An error of the order of omega h = 0.02 of the energies exchanged, and no more at the end.
    assert sizes["semi_implicit_euler"][1] < 0.1 * kinetic
    # (omega h)^6 / 72 of the energy a step, for omega = 12 rad/s at most: 3e-6 in all.
    assert sizes["rk4"][1] < 1e-4 * kinetic
    # Damped as by the ratio 5/12 omega h: after 2000 s, at rest.
    assert sizes["thesis_runge_kutta"][1] > 0.5 * kinetic


def test_gauss_keeps_energy_over_many_steps() -> None:
    scene = Scene.from_dict(
        {
            "name": "rod",
            "rod": {"links": 3, "length": 5.0, "bending_stiffness": 100.0, "mass": 50.0},
            "initial": {"phi": "0.3*cos(pi*s)"},
            "integrate": {"span": [0.0, 500.0], "output_every": 0.5},
        }
    )
    sol = rodgen.simulate(scene, target="c", method="gauss", rtol=1e-6, atol=1e-6)
    drift = np.abs(sol.energy.total / sol.energy.total[0] - 1)
    assert drift.max() < 1e-3
    assert drift[-100:].max() < 2 * drift[:500].max() + 1e-6


def test_a_run_of_nothing_that_moves() -> None:
    """Straight, at rest, without loads: no size to choose a step by, and exact zeros."""
    scene = Scene.from_dict(
        {
            "name": "still",
            "rod": {"links": 3, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0},
            "integrate": {"span": [0.0, 100.0], "output_every": 10.0},
        }
    )
    for method in ("dop853", "radau", "gauss", "auto"):
        sol = rodgen.simulate(scene, target="c", method=method)
        assert not sol.y.any()
        assert sol.stats.steps < 1e4
