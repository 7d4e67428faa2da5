"""Runs that begin far from time zero, where the times of steps are rounded: the same motion."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from tests.sets import Make, sets

NOW = 1.7e9  # s since 1970: doubles are 2.4e-7 s apart
NIGHTLY = [
    *((method, "numpy", NOW) for method in ("gauss", "radau", "bdf", "rk45", "cvode")),
    *((method, "c", at) for method in ("gauss", "radau", "rk4") for at in (NOW, -NOW, 1e11)),
]


@pytest.mark.compiler
@pytest.mark.parametrize(
    ("method", "target", "start"),
    sets(
        [("dop853", "c", NOW)], slow=[("gauss", "c", NOW), ("lsoda", "numpy", NOW)], nightly=NIGHTLY
    ),
)
def test_motion_is_that_of_a_run_from_zero(
    make_scene: Make, method: str, target: str, start: float
) -> None:
    """At samples inside steps too, each of the time that it is given for."""
    if method == "cvode":
        pytest.importorskip("sksundae", reason="rodgen[cvode] is not installed")
    rod = {"length": 5.0, "bending_stiffness": 100.0, "mass": 20.0}
    initial, step = {"phi": "0.3*s", "omega": "2*s"}, {"step": 1e-3} if method == "rk4" else {}
    how = {"output_every": 0.125, "method": method, "rtol": 1e-8, "atol": 1e-10, **step}
    scene = make_scene(3, "clamped", ("gravity",), rod, initial, **how)
    spans = (0.0, 2.0), (start, start + 2.0)
    near, far = (rodgen.simulate(scene, target=target, span=span) for span in spans)
    np.testing.assert_array_equal(far.t - start, near.t)
    # Fixed steps are those of rounded times, each to half of what is between two doubles, and
    # their errors move with them: by the share of a step, at rates of a few rad/s.
    rounded = float(np.spacing(abs(start))) if method == "rk4" else 0.0
    np.testing.assert_allclose(far.phi, near.phi, rtol=0, atol=1e-12 + 20 * rounded)
