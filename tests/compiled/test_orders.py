"""Orders of the compiled methods and of their dense output, on steps of one length."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene

REFERENCE = 4000  # steps of DOP853: its error is rounding
# Steps at which errors are above rounding and Newton's tolerance, and small enough to be of the
# leading order; nominal order; order of the dense output inside a step.
METHODS = {
    "euler": ((2000, 3000, 4000, 6000), 1, None),
    "semi_implicit_euler": ((2000, 3000, 4000, 6000), 1, None),
    "thesis_runge_kutta": ((2000, 3000, 4000, 6000), 1, None),
    "rk4": ((400, 560, 800, 1120), 4, 4),
    "dop853": ((100, 115, 130, 145), 8, 8),
    "radau": ((64, 80, 100, 128, 160, 200), 5, 5),
    "gauss": ((50, 64, 80, 100, 128), 6, 6),
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
        status = model.PAUSED
        while status == model.PAUSED:
            status, _ = run.on(1000, *none)
        assert status == model.REACHED
    return run


@pytest.fixture(scope="module")
def model() -> ModuleType:
    from tests.compiled.conftest import SMOOTH

    return rodgen.build(Scene.from_dict(SMOOTH), "c")


@pytest.mark.parametrize("method", METHODS)
def test_order(smooth: Scene, model: ModuleType, method: str) -> None:
    counts, order, _ = METHODS[method]
    states = len(model.STATE)
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
# One step of several lengths, short enough for the leading power.
DENSE = {
    "rk4": ((0.0005, 0.001, 0.002), 1e-2),
    "dop853": ((0.015, 0.02, 0.03), 1e-2),
    "radau": ((0.001, 0.002, 0.003, 0.004), 1e-7),
    "gauss": ((0.002, 0.003, 0.004, 0.005), 1e-7),
}


@pytest.mark.parametrize("method", DENSE)
def test_order_of_dense_output(smooth: Scene, model: ModuleType, method: str) -> None:
    """Its error inside one step from exact values is of the power one above its order."""
    lengths, atol = DENSE[method]
    p, states = model.parameters(**smooth.parameters), len(model.STATE)
    exact = model.Run("dop853", 0.0, smooth.initial_state(), p, rtol=1e-13, atol=1e-14)
    exact.begin(0.1)
    errors = []
    for h in lengths:
        run = model.Run(method, 0.0, smooth.initial_state(), p, step=1.0, rtol=1e-13, atol=atol)
        run.begin(h)
        while run.on(10, np.zeros(0), np.zeros((0, len(run.state))))[0] == model.PAUSED:
            pass
        assert run.numbers.steps == 1
        due = np.empty((len(SHARES), len(run.state)))
        exact = model.Run("dop853", 0.0, smooth.initial_state(), p, rtol=1e-13, atol=1e-14)
        exact.begin(h)
        while exact.on(100, SHARES * h, due)[0] == model.PAUSED:
            pass
        errors.append(np.abs(run.at(SHARES * h) - due)[:, :states].max())
    slope = np.polyfit(np.log(lengths), np.log(errors), 1)[0]
    # Hermite's cubic: h^4; collocation at three points with what it lacks there: that of the error
    # of a run; DOP853's of order 7: h^8.
    assert slope == pytest.approx(METHODS[method][2], abs=0.3)
