"""Two crossings within one step, by the flight of a rod, whose times are known."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate.reductions import Crossing
from rodgen.integrate.simulate_many import simulate_rods
from rodgen.scene.integration import IntegrationTable
from rodgen.system import System
from tests.compiled.conftest import NO_LOADS

G, STEP = 9.81, 0.8
# A step is looked at in eight parts of 0.1 s: a rod that is highest where two of them meet passes a
# level in both, on its way up and down; others do in parts that are apart.
HIGHEST = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.33, 0.42])  # s
APART = np.array([0.06] * 7 + [0.21, 0.34])  # s, of each crossing from there


@pytest.fixture(scope="module")
def thrown(missile: Scene) -> Scene:
    """A limp rod that lies level. Its height is a parabola, which both the classical method and its
    cubic have exactly."""
    settings = {"method": "rk4", "step": STEP, "span": [0.0, STEP]}
    late = {"parameters.ramp": 9.0, "parameters.jump": 9.0}  # so that it is one step
    return missile.replace({**NO_LOADS, **late, "integrate": settings, "initial": {}})


def _starts(model: ModuleType) -> np.ndarray:
    """States from which rods reach the height of zero at HIGHEST -+ APART."""
    y = np.zeros((len(HIGHEST), len(model.STATE)))
    y[:, model.STATE.index("y0")] = -G / 2 * (HIGHEST**2 - APART**2)
    y[:, model.STATE.index("vy0")] = G * HIGHEST
    return y


@pytest.mark.parametrize("number", ["y0", "centre_of_gravity_y"])
def test_both_are_found_side_by_side(thrown: Scene, number: str) -> None:
    """Of a state, and of a number that is observed; the values there are zero and the speeds
    opposite."""
    model = rodgen.build(thrown, "c", parts=("flow", "power", "lanes"))
    p, y = model.parameters(**thrown.parameters), _starts(model)
    both, up, down = (
        Crossing(number, 0.0, direction, ("tip_y", "vy0"), max_points=3)
        for direction in ("either", "rising", "falling")
    )
    how = {"method": "rk4", "step": STEP, "span": [0.0, STEP], "output_every": STEP}
    settings = IntegrationTable.model_validate(how)
    made = simulate_rods(model, p, y, settings, crossings=(both, up, down))
    assert made.nsteps.tolist() == [1] * len(y)
    due = np.stack((HIGHEST - APART, HIGHEST + APART), axis=1)
    for crossed, times in zip(made.crossed, (due, due[:, :1], due[:, 1:]), strict=True):
        count = times.shape[1]
        assert crossed.counts.tolist() == [count] * len(y)
        # Rounding of heights of some metres, over the speed of 0.6 m/s at which they are passed.
        np.testing.assert_allclose(crossed.t[:, :count], times, rtol=0, atol=1e-13)
        speeds = G * (HIGHEST[:, None] - times)
        np.testing.assert_allclose(crossed.values[:, :count, 0], 0.0, atol=1e-13)
        np.testing.assert_allclose(crossed.values[:, :count, 1], speeds, rtol=0, atol=1e-11)
        assert np.isnan(crossed.t[:, count:]).all()


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_both_are_found_in_a_run(thrown: Scene, target: str) -> None:
    model = rodgen.build(thrown, target)
    for number in ("y0", "centre_of_gravity_y"):
        scene = thrown.replace({"events": [{"quantity": number, "value": 0.0}]})
        for y0, highest, apart in zip(_starts(model), HIGHEST, APART, strict=True):
            sol = rodgen.simulate(System(scene).at(y0=y0), model=model)
            assert sol.stats.nsteps == 1
            found = [event.t for event in sol.events]
            assert found == pytest.approx([highest - apart, highest + apart], abs=1e-13)
