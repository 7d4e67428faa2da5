"""Numbers of expressions in modules: tables, and rods each with numbers of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from rodgen import build
from rodgen.scene import Scene

TABLE = "[0, 0.1, 0.6, 1], [0, 310, -290, 5]"
SCENE = Scene.from_dict(
    {
        "name": "test",
        "rod": {"links": 3, "length": 2.0, "bending_stiffness": 30.0, "mass": 3.0},
        "parameters": {"P0": 4.0},
        "loads": {
            "tip": {"x": f"interp(t, {TABLE}, 'cubic') + P0*t**2", "y": f"interp(t, {TABLE})"}
        },
    }
)


@pytest.fixture(scope="module")
def models() -> tuple[Any, Any]:
    """Of both targets."""
    return build(SCENE), build(SCENE, target="c")


def test_a_table_is_alike_in_both_targets_and_in_the_scene(models: Any) -> None:
    numpy, c = models
    p = c.parameters(**SCENE.parameters)
    y = np.random.default_rng(1).normal(size=len(c.STATE))
    for t in (-0.2, 0.0, 0.05, 0.1, 0.3, 0.6, 0.99, 1.0, 2.0, np.nan):
        due = [float(e(t)) for e in SCENE.time_dependent_loads.values()]
        # SciPy's monotone cubic is what the scene asks; the modules have one of their own.
        found = numpy.forces(t, y, p)["tip_load"][-1]
        np.testing.assert_allclose(found, due, rtol=1e-13, atol=1e-12)
        # A hundred roundings of accelerations of some thousands.
        np.testing.assert_allclose(c.rhs(t, y, p), numpy.rhs(t, y, p), rtol=1e-12, atol=1e-9)


# Knots and values of four, by what the slope at an end is: that of a parabola, zero where that
# would go the other way, and no more than three times the chord where the next one turns back.
TABLES = {
    "parabola": ([0.0, 0.3, 0.5, 1.0], [0.0, 2.0, 3.0, 3.5]),
    "zero": ([0.0, 0.2, 0.3, 0.5], [0.0, 0.1, 3.0, 3.05]),
    "three chords": ([0.0, 0.4, 0.5, 1.0], [0.0, 1.0, -9.0, -8.0]),
    "both ends": ([0.0, 0.5, 0.6, 1.0], [5.0, 4.0, 9.0, 7.0]),
    "flat": ([0.0, 0.2, 0.6, 1.0], [1.0, 1.0, 2.0, 2.0]),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_cubic_table_is_that_of_scipy(models: Any, name: str) -> None:
    """PchipInterpolator has another code for the slopes at the ends, where they differ by kind."""
    numpy, c = models
    knots, values = TABLES[name]
    due = PchipInterpolator(knots, values)
    p = c.parameters(**SCENE.parameters)
    at = SCENE.structure.indices
    for number, (knot, value) in enumerate(zip(knots, values, strict=True), 1):
        p[at[f"tip_force_x_knot_{number}"]] = knot
        p[at[f"tip_force_x_value_{number}"]] = value
    y = np.zeros(len(c.STATE))
    for t in np.linspace(0.0, 1.0, 41):
        force = pytest.approx(float(due(min(t, knots[-1]))) + 4.0 * t**2, rel=1e-12, abs=1e-12)
        assert numpy.forces(t, y, p)["tip_load"][-1][0] == force
        # Along a straight rod that is free: its mass of 3 kg under the force at its tail.
        assert 3.0 * c.rhs(t, y, p)[len(y) // 2] == force


def test_each_rod_of_a_batch_has_numbers_of_its_own(models: Any) -> None:
    _, c = models
    draw = np.random.default_rng(2)
    y = draw.normal(size=(19, len(c.STATE)))
    p = np.tile(c.parameters(**SCENE.parameters), (19, 1))
    for name, at in SCENE.structure.indices.items():
        if "value" in name or name == "P0":
            p[:, at] *= draw.uniform(0.5, 2.0, 19)
    rates = c.rhs_batch(0.3, y, p)
    one_by_one = [c.rhs(0.3, *rod) for rod in zip(y, p, strict=True)]
    np.testing.assert_allclose(rates, one_by_one, rtol=1e-12, atol=1e-9)
    assert np.ptp(rates[:, -1]) > 0
