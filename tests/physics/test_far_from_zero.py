"""Runs that begin far from time zero, where the times of steps are rounded: the same motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from tests.palette import cases

SPAN = 2.0
NOW = 1.7e9  # s since 1970: doubles are 2.4e-7 s apart


WAYS = [
    *((method, "c") for method in ("dop853", "gauss", "radau", "rk4")),
    *((method, "numpy") for method in ("dop853", "gauss", "radau", "lsoda", "bdf", "rk45")),
    ("cvode", "numpy"),
]


# Of the palette; gravity alone acts.
LOADS: dict[str, Any] = {
    "follower": {"force": 0.0},
    "gravity": {},
    "internal_damping": {"coefficient": 0.0},
    "external_damping": {"coefficient": 0.0},
    "tip": {},
}


def swing(start: float, method: str) -> Scene:
    step = {"step": 1e-3} if method == "rk4" else {}
    rod = {"links": 3, "length": 5.0, "bending_stiffness": 100.0, "mass": 20.0}
    return Scene.from_dict(
        {
            "name": "swing",
            "rod": {**rod, "boundary": "clamped"},
            "loads": LOADS,
            "initial": {"phi": "0.3*s", "omega": "2*s"},
            "integrate": {"span": [start, start + SPAN], "method": method, "rtol": 1e-8, **step},
        }
    )


@pytest.mark.nightly
@pytest.mark.compiler
@cases("way, start", WAYS, (-NOW, NOW, 1e11))
def test_motion_is_that_of_a_run_from_zero(way: tuple[str, str], start: float) -> None:
    method, target = way
    if method == "cvode":
        pytest.importorskip("sksundae", reason="rodgen[cvode] is not installed")
    near = rodgen.simulate(swing(0.0, method), target=target)
    far = rodgen.simulate(swing(start, method), target=target)
    # Fixed steps are those of rounded times, each to half of what is between two doubles, and
    # their errors move with them: by the share of a step, at rates of a few rad/s.
    rounded = float(np.spacing(abs(start))) if method == "rk4" else 0.0
    np.testing.assert_allclose(far.phi[-1], near.phi[-1], rtol=0, atol=1e-12 + 20 * rounded)


@pytest.mark.compiler
@pytest.mark.parametrize("method", ["dop853", "gauss", "radau"])
def test_samples_between_steps_are_those_of_their_times(method: str) -> None:
    """Not of times that are rounded: a sample is that of the time that it is given for."""
    near = rodgen.simulate(swing(0.0, method), target="c", output_every=0.125)
    far = rodgen.simulate(swing(NOW, method), target="c", output_every=0.125)
    np.testing.assert_array_equal(far.t - NOW, near.t)
    np.testing.assert_allclose(far.phi, near.phi, rtol=0, atol=1e-12)
