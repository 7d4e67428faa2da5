"""rhs of the NumPy target on many states at once, as SciPy's solvers give them."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rodgen
from rodgen.emit.targets import FORMS
from rodgen.scene.structure import Structure

STRUCTURE = Structure(3, "clamped", terms=("follower", "gravity"))
VALUES = {"mass": 3.0, "length": 2.0, "bending_stiffness": 30.0, "follower_force": 5.0}
STATES = 6

Module = Callable[..., Any]


@pytest.fixture(params=FORMS)
def rod(request: pytest.FixtureRequest) -> ModuleType:
    return rodgen.build(STRUCTURE, "numpy", request.param)


def _one_by_one(rod: ModuleType, states: np.ndarray, p: np.ndarray) -> np.ndarray:
    return np.array([rod.rhs(0.3, state, p) for state in states])


@pytest.mark.parametrize("count", [0, 1, 4, STATES, 9])
def test_columns_are_states(rod: ModuleType, count: int) -> None:
    """Also where as many states as a state has values make the axes alike."""
    p, states = rod.parameters(**VALUES), np.random.default_rng(1).normal(size=(count, STATES))
    rates = rod.rhs(0.3, states.T, p)
    assert rates.shape == (STATES, count)
    if count:
        np.testing.assert_array_equal(rates, _one_by_one(rod, states, p).T)


@pytest.mark.parametrize("shape", [(4,), (2, 3), (1, 1), (STATES, STATES)])
def test_states_lie_along_the_last_axis_otherwise(rod: ModuleType, shape: tuple[int, ...]) -> None:
    p, y = rod.parameters(**VALUES), np.random.default_rng(2).normal(size=(*shape, STATES))
    rates = rod.rhs(0.3, y, p)
    assert rates.shape == y.shape
    flat = _one_by_one(rod, y.reshape(-1, STATES), p)
    np.testing.assert_array_equal(rates.reshape(-1, STATES), flat)


@pytest.mark.parametrize("shape", [(5, 4), (STATES, 2, 2), (2, STATES, 1), ()])
def test_other_shapes_are_refused(rod: ModuleType, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="y has shape"):
        rod.rhs(0.0, np.zeros(shape), rod.parameters(**VALUES))


@pytest.mark.parametrize("method", ["Radau", "BDF"])
def test_scipy_takes_it_as_vectorized(rod: ModuleType, method: str) -> None:
    """Its Jacobians by differences evaluate many columns at once, and come out the same."""
    p, y0 = rod.parameters(**VALUES), np.full(STATES, 0.1)
    runs = [
        solve_ivp(rod.rhs, (0.0, 0.2), y0, method, args=(p,), vectorized=vectorized)
        for vectorized in (True, False)
    ]
    assert all(run.success for run in runs)
    np.testing.assert_allclose(runs[0].y, runs[1].y, rtol=0, atol=1e-12)
