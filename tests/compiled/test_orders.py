"""Orders of the compiled methods and of their dense output, on steps of one length."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

from rodgen import Scene
from rodgen.model.methods import METHODS

REFERENCE = 4000  # steps of DOP853: its error is rounding
# Steps at which errors are above rounding and Newton's tolerance, and small enough to be of the
# leading power of their order.
COUNTS = {
    1: (2000, 3000, 4000, 6000),
    2: (800, 1200, 1600),
    4: (400, 560, 800, 1120),
    5: (64, 80, 100, 128, 160, 200),
    6: (50, 64, 80, 100, 128),
    8: (100, 115, 130, 145),
}


def _run(model: ModuleType, scene: Scene, method: str, steps: int, atol: float) -> Any:
    """A run of equal steps, each a stretch of its own."""
    p = model.parameters(**scene.parameters)
    y0 = scene.initial_state()
    run = model.Run(method, 0.0, y0, p, step=1.0, rtol=1e-13, atol=atol)
    none = np.zeros(0), np.zeros((0, len(run.state)))
    for k in range(1, steps + 1):
        run.numbers.step = 1.0
        assert run.begin(k / steps) == model.PAUSED
        assert run.advance(10**4, *none)[0] == model.REACHED
    return run


@pytest.mark.parametrize("method", [name for name, method in METHODS.items() if method.in_c])
def test_order(smooth: Scene, model: ModuleType, method: str) -> None:
    order = METHODS[method].order
    counts, states = COUNTS[order], len(model.STATE)
    exact = _run(model, smooth, "dop853", REFERENCE, 1e-3).state[:states]
    errors = []
    for steps in counts:
        # As tight as the steps are not rejected: Newton's method stops at a share of it.
        for atol in (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1):
            run = _run(model, smooth, method, steps, atol)
            if run.numbers.steps == steps:
                break
        assert run.numbers.steps == steps
        errors.append(np.abs(run.state[:states] - exact).max())
    slope = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.2)


SHARES = np.array([0.2, 0.37, 0.61, 0.85])  # of a step
# One step of several lengths, short enough for the leading power; the order inside it.
DENSE = {
    "rk4": ((0.0005, 0.001, 0.002), 1e-2, 4),
    "dop853": ((0.015, 0.02, 0.03), 1e-2, 8),
    "radau": ((0.001, 0.002, 0.003, 0.004), 1e-7, 5),
    "gauss": ((0.002, 0.003, 0.004, 0.005), 1e-7, 6),
}


def _inside(
    model: ModuleType, scene: Scene, method: str, lengths: tuple[float, ...], atol: float
) -> Any:
    """Slopes of the errors inside one step from exact values, of states and of works."""
    p, states, errors = model.parameters(**scene.parameters), len(model.STATE), []
    for h in lengths:
        start = 0.0, scene.initial_state(), p
        run = model.Run(method, *start, step=1.0, rtol=1e-13, atol=atol)
        run.begin(h)
        assert run.advance(10, np.zeros(0), np.zeros((0, len(run.state))))[0] == model.REACHED
        assert run.numbers.steps == 1
        due = np.empty((len(SHARES), len(run.state)))
        exact = model.Run("dop853", *start, rtol=1e-13, atol=1e-14)
        exact.begin(h)
        assert exact.advance(1000, SHARES * h, due)[1] == len(SHARES)
        off = np.abs(run.state_at(SHARES * h) - due)
        errors.append((off[:, :states].max(), off[:, states:].max()))
    return np.polyfit(np.log(lengths), np.log(errors), 1)[0]


@pytest.mark.parametrize("method", DENSE)
def test_order_of_dense_output(smooth: Scene, model: ModuleType, method: str) -> None:
    """Its error inside one step is of the power one above its order."""
    lengths, atol, order = DENSE[method]
    slope, _ = _inside(model, smooth, method, lengths, atol)
    # Hermite's cubic: h^4; collocation at three points with what it lacks there: that of the error
    # of a run; DOP853's of order 7: h^8.
    assert slope == pytest.approx(order, abs=0.3)


def test_works_inside_a_step_are_of_the_order_of_the_states(
    smooth: Scene, model: ModuleType
) -> None:
    """By the power in the middle of a step, where damping takes much."""
    coefficient = {"loads.internal_damping.coefficient": 0.3}
    fast = smooth.replace({**coefficient, "initial.omega": "5*(1-s)"})
    assert _inside(model, fast, "gauss", (0.0007, 0.001, 0.0014), 1e-9) == pytest.approx(6, abs=0.2)
