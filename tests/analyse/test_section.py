"""Poincaré sections: against a stroboscope of the linear motion, and an exact crossing."""

from __future__ import annotations

import numpy as np

import rodgen
from rodgen.scene import Scene
from tests.analyse.rods import ONES, rod

SMALL = 1e-3  # rad


def _pendulum() -> Scene:
    """One pinned link of 1 kg and 1 m that hangs, and swings a little."""
    start = {"phi": -np.pi / 2 + SMALL}
    settings = {"span": [0.0, 20.0], "rtol": 1e-11, "atol": 1e-13}
    return rod(1, "pinned", {"gravity": {"g": 9.81}}, **ONES, initial=start, integrate=settings)


def test_a_section_of_a_swing_is_a_stroboscope() -> None:
    """Every period from three quarters of the first on, as it swings to where it began: by the
    pendulum's elliptic integral, 1 + SMALL^2/16 of the small swing's period."""
    period = 2 * np.pi * np.sqrt(2 / (3 * 9.81)) * (1 + SMALL**2 / 16)
    found = rodgen.poincare_section(_pendulum(), "phi_0", rising=-np.pi / 2)
    times = period * (0.75 + np.arange(found.sizes["crossing"]))
    assert found.sizes["crossing"] == int((20.0 - 0.75 * period) // period) + 1
    # 1e-9: the run's own errors over 12 periods.
    np.testing.assert_allclose(found["t"].values, times, rtol=1e-9)
    np.testing.assert_allclose(found["phi"].values[:, 0], -np.pi / 2, atol=1e-14)
    np.testing.assert_allclose(found["omega"].values[:, 0], 2 * np.pi / period * SMALL, rtol=1e-6)
    strobe = rodgen.simulate(_pendulum(), span=[0.0, 20.0], t_eval=times)
    np.testing.assert_allclose(found["y"].values, strobe.y, atol=1e-11)
    np.testing.assert_allclose(found["tip"].values[:, 1], -1.0, atol=1e-12)


def test_a_run_is_made_again_and_its_start_left_out() -> None:
    run = rodgen.simulate(_pendulum(), span=[0.0, 5.0])
    of_scene = rodgen.poincare_section(_pendulum(), "phi_0", falling=-np.pi / 2)
    of_run = rodgen.poincare_section(run, "phi_0", falling=-np.pi / 2)
    np.testing.assert_allclose(of_run["t"].values, of_scene["t"].values[: of_run.sizes["crossing"]])
    assert of_run["t"].values.max() < 5.0
    both = rodgen.poincare_section(run, "phi_0", either=-np.pi / 2)
    late = rodgen.poincare_section(run, "phi_0", either=-np.pi / 2, transient=2.0)
    np.testing.assert_array_equal(late["t"].values, both["t"].values[both["t"].values >= 2.0])
