"""The elastic beam of the IVP test set: scenes/ivp_beam.toml against its published solution.

ivp_beam_t5.json: problem Beam of the Test Set for IVP Solvers (Bari), revision 1.2 of 2006, n = 40,
computed there with RADAU at rtol = atol = 1.1e-18.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rodgen
from rodgen.scene import Scene
from tests.physics.sets import sets

PUBLISHED = json.loads((Path(__file__).parent / "ivp_beam_t5.json").read_text(encoding="utf-8"))
EXACT = np.array(PUBLISHED["y"])


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene.from_toml(Path(__file__).parents[2] / "scenes" / "ivp_beam.toml")


@pytest.mark.slow
def test_published_solution_is_reproduced(scene: Scene) -> None:
    # Off by 2.3e-10; by 2.2e-10 with atol 1e-16, in four times as many steps.
    settings = {"method": "dop853", "rtol": 1e-13, "atol": 1e-14, "output_every": 5.0}
    sol = rodgen.simulate(scene, target="c", **settings)
    # theta_i is phi_{i-1}: angles, then rates, as in the state.
    assert sol.t[-1] == 5.0
    np.testing.assert_allclose(sol.y[-1], EXACT, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("method", "rtol", "limit"),
    sets([("radau", 1e-5, 1e-3)], nightly=[("dop853", 1e-7, 1e-6)]),
)
def test_other_target_and_method_come_near(
    scene: Scene, method: str, rtol: float, limit: float
) -> None:
    """Rates are the worse half: the fastest modes, near 6400 rad/s, multiply errors of angles."""
    settings = {"method": method, "rtol": rtol, "atol": rtol / 100, "output_every": 5.0}
    sol = rodgen.simulate(scene, target="numpy", **settings)
    np.testing.assert_allclose(sol.y[-1], EXACT, rtol=0, atol=limit)
    np.testing.assert_allclose(sol.y[-1, :40], EXACT[:40], rtol=0, atol=limit / 100)
