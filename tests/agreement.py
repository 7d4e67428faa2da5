"""Two routes to one and the same: what tests of many rods hold against each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import rodgen
from rodgen.scene import Scene

STEP = 1e-6


def differences(rhs: Callable[..., Any], t: float, y: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The Jacobian of a right-hand side by central differences, whose errors are the square of the
    step, and rounding over it."""
    columns = [(rhs(t, y + d, p) - rhs(t, y - d, p)) / (2 * STEP) for d in STEP * np.eye(len(y))]
    return np.array(columns).T


def assert_implicit_steps_are_explicit(
    scene: Scene, states: float, energy: float = np.inf, **settings: Any
) -> None:
    """A scene ends in one state by a method without a Newton matrix and by two that have one."""
    runs = [
        rodgen.simulate(scene, method=method, rtol=1e-10, **{"atol": 1e-11, **settings})
        for method in ("dop853", "gauss", "radau")
    ]
    for sol in runs:
        assert sol.energy_error < energy
        np.testing.assert_allclose(sol.y[-1], runs[0].y[-1], rtol=1e-7, atol=states)
