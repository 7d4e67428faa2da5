"""Every method on equations whose solution is known, and between break points of a rod."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.arrays import Array
from rodgen.integrate.methods.python_integrator import make_stepper
from rodgen.integrate.stability import step_limit
from rodgen.integrate.stepper import InitialValueProblem, StepError, Stepper
from rodgen.model.methods import ADAPTIVE, EITHER, FIXED_STEP, METHODS, Tableau
from rodgen.scene.integration import IntegrationTable
from rodgen.system import System
from tests.palette import ENDS
from tests.sets import Make, sets

END = 2.0
# Steps for which errors are of the leading power and above rounding.
COUNTS = {1: (100, 200, 400), 2: (50, 100, 200), 4: (20, 40, 80), 6: (4, 6, 8)}


def exact(t: float | Array) -> Array:
    """Logistic growth q' = q (1 - q), and its speed: (2, ...)."""
    q = 1 / (1 + 4 * np.exp(-np.asarray(t)))
    return np.stack((q, q * (1 - q)))


def rhs(t: float, y: Array) -> Array:
    """The equation of second order that it solves; the last term, zero on the solution, tells a
    wrong time."""
    q, v = y
    return np.array([v, v * (1 - 2 * q) + 3 * (exact(t)[0] - q)])


def jac(t: float, y: Array) -> Array:
    """Jacobian of the rates by the state."""
    q, v = y
    return np.array([[0.0, 1.0], [-2 * v - 3, 1 - 2 * q]])


def problem(method: str, **integrate: Any) -> InitialValueProblem:
    """The equation by a method, from 0 to END."""
    if method == "cvode":
        pytest.importorskip("sksundae")
    settings = IntegrationTable(method=method, span=[0.0, END], **integrate)
    return InitialValueProblem(rhs, jac, 0.0, exact(0.0), END, settings)


def walked(steps: Stepper) -> float:
    """Largest error at the ends and in the middle of the steps of a whole way."""
    errors, done = [], False
    while not done:
        start = steps.t
        done = steps.step()
        middle = (start + steps.t) / 2
        at = steps.interpolant()(np.array([middle]))[0]
        errors += [np.abs(at - exact(middle)).max(), np.abs(steps.y - exact(steps.t)).max()]
    assert steps.t == END
    return float(max(errors))


@pytest.mark.parametrize("method", [*FIXED_STEP, *EITHER])
def test_order_of_equal_steps(method: str) -> None:
    """Slope of the error at the end against the step; inside a step dense output is of order 4 at
    least."""
    order, errors = METHODS[method].order, []
    for count in COUNTS[order]:
        steps = make_stepper(problem(method, step=END / count))
        while not steps.step():
            pass
        assert steps.counts.nsteps == count
        errors.append(np.abs(steps.y - exact(END)).max())
    slope = -np.polyfit(np.log(COUNTS[order]), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.2)
    inside = [walked(make_stepper(problem(method, step=END / count))) for count in (20, 40)]
    assert np.log2(inside[0] / inside[1]) > min(order, 4) - 0.3


@pytest.mark.parametrize("method", ADAPTIVE)
def test_error_follows_the_tolerance(method: str) -> None:
    """At the ends of steps and inside them."""
    for rtol in (1e-3, 1e-5, 1e-7):
        steps = make_stepper(problem(method, rtol=rtol, atol=rtol))
        # Some ten to hundred steps, each off by the tolerance; LSODA and CVODE keep to it loosely.
        assert walked(steps) < 30 * rtol
        counts = steps.counts
        assert counts.nfev > counts.nsteps > 0
        if METHODS[method].implicit and method not in ("lsoda", "cvode"):
            assert counts.njev > 0
            assert counts.nlu > 0


def test_last_step_meets_the_end() -> None:
    """It is shortened, and left out where it would be a millionth of the others."""
    counts = (0.3, 7), (END / 5 * (1 - 1e-8), 5)
    for method, (step, count) in product([*FIXED_STEP, *EITHER], counts):
        steps = make_stepper(problem(method, step=step))
        while not steps.step():
            pass
        assert (steps.t, steps.counts.nsteps) == (END, count)


@pytest.mark.parametrize("method", [*FIXED_STEP, "dop853", "gauss", "radau", "bdf"])
def test_rates_that_stop_being_finite_end_the_run(method: str) -> None:
    """(LSODA and CVODE creep up to that time, which a run notices.)"""
    given = problem(method, **({"step": 0.01} if method in FIXED_STEP else {}))

    def broken(t: float, y: Array) -> Array:
        return rhs(t, y) if t < 1.0 else np.full(2, np.nan)

    steps = make_stepper(replace(given, rhs=broken))
    with pytest.raises(StepError):
        walked(steps)
    assert 0.9 < steps.t <= 1.0 + 1e-12
    assert np.isfinite(steps.y).all()


def test_weights_of_a_tableau_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^A "):
        Tableau(A=((), (1, 1)), b=(1, 0))
    with pytest.raises(ValueError, match=r"^c "):
        Tableau(A=((), (1,)), b=(1, 0), c=(0,))


def test_documentation_has_the_table_of_methods() -> None:
    """A row a method, and the limits of those of fixed step."""
    text = (Path(__file__).parents[2] / "docs/methods.md").read_text(encoding="utf-8")
    for name, method in METHODS.items():
        order = f"to {method.order}" if method.varies else f"{method.order}"
        assert f"| `{name}` | {method.about} | {order} | {method.citation} |" in text
    for name in FIXED_STEP:
        row = re.search(rf"\| `{name}` \| ([\d.]+).*\| ([\d.]+) \|", text)
        assert row
        ends = step_limit(name, 1j), step_limit(name, -1 + 0j, 0j)
        assert [float(value) for value in row.groups()] == pytest.approx(ends, abs=5e-4)


# Rods -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "how", sets([{"rtol": 1e-10}], nightly=[{"method": "rk4", "step": 2.5e-4}])
)
def test_break_points_are_stepped_onto(make_scene: Make, how: dict[str, Any]) -> None:
    """A force that jumps in the middle of the span: two runs joined give the same."""
    scene = make_scene(3, "free", ("follower",))
    jumping = scene.replace({"loads.follower.force": "40 if t < 0.437 else -20"})
    assert jumping.breaks() == [pytest.approx(0.437, abs=1e-12)]
    whole, end = rodgen.simulate(jumping, **how), None
    for force, span in ((40.0, (0.0, 0.437)), (-20.0, (0.437, 1.0))):
        system = System(scene).at({"loads.follower.force": force}, y0=end)
        end = rodgen.simulate(system, rtol=1e-10, span=span).y[-1]
    # rk4's error at this step is 1e-8; one stage on the wrong side of the jump makes it 1e-3.
    np.testing.assert_allclose(whole.y[-1], end, rtol=0, atol=1e-7)


def test_runs_are_reproducible(make_scene: Make) -> None:
    scene = make_scene(3, "free", ENDS, span=[0.0, 0.2])
    one, two = rodgen.simulate(scene), rodgen.simulate(scene)
    np.testing.assert_array_equal(one.y, two.y)
