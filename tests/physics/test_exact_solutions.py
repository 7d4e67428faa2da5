"""Runs against motions and rests that need no rodgen: rigid body, pendulum, thesis, test set."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk

import rodgen
from rodgen.scene import Scene
from tests.sets import Make, sets


def test_one_free_link_is_a_rigid_body(make_scene: Make) -> None:
    """A follower force at the angle nu turns it evenly: (M L^2/12) phi'' = -P (L/2) sin(nu)."""
    scene = make_scene(1, "free", ("follower",), initial={"phi": 0.3, "omega": 0.0})
    sol = rodgen.simulate(scene)
    turning = -40.0 * 1.0 * np.sin(0.1) / (3.0 * 4.0 / 12)
    np.testing.assert_allclose(sol.phi[:, 0], 0.3 + turning * sol.t**2 / 2, atol=1e-9)


@pytest.mark.slow
def test_cantilever_settles_to_its_static_deflection() -> None:
    """Thesis 3.2 with the discrete rod solved exactly: 0.07359 m (the thesis has 0.0735)."""
    scene = Scene.example("cantilever_self_weight")
    sol, rest = rodgen.simulate(scene), rodgen.static_equilibrium(scene)
    assert -rest.tip[1] == pytest.approx(0.07359, abs=5e-6)
    np.testing.assert_allclose(sol.phi[-1], rest.phi, atol=1e-6)


@pytest.mark.parametrize(("inertia", "factor"), [("lumped", 1.0), ("uniform", 1.5)])
def test_one_pinned_link_is_a_pendulum(make_scene: Make, inertia: str, factor: float) -> None:
    """Small: sqrt(g/l), and sqrt(3 g/(2 l)) for a bar. Large: the period is an elliptic
    integral, 4 K(sin(a/2))/omega, after which it is where it was."""
    omega = np.sqrt(factor * 9.81 / 2.0)
    start = 2.0  # of the pendulum from the vertical
    period = 4 * ellipk(np.sin(start / 2) ** 2) / omega
    initial = {"phi": start - np.pi / 2, "omega": 0.0}
    scene = make_scene(1, "pinned", ("gravity",), {"inertia": inertia}, initial)
    sol = rodgen.simulate(scene, span=[0.0, period], output_every=period / 2, rtol=1e-11)
    np.testing.assert_allclose(sol.phi[:, 0] + np.pi / 2, [start, -start, start], rtol=0, atol=1e-8)
    hanging = np.array([-np.pi / 2, 0.0])
    J = sol.model.jac(0.0, hanging, sol.model.parameters(**scene.parameters))
    np.testing.assert_allclose(J, [[0.0, 1.0], [-(omega**2), 0.0]], atol=1e-14)


# The problem Beam of the Test Set for IVP Solvers (Bari), revision 1.2 of 2006, n = 40, computed
# there with RADAU at rtol = atol = 1.1e-18. Off by 2.3e-10 at the smallest tolerance here; by
# 2.2e-10 with atol 1e-16, in four times as many steps.
PUBLISHED = json.loads((Path(__file__).parent / "ivp_beam_t5.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("method", "target", "rtol", "limit"),
    sets(
        [("radau", "numpy", 1e-5, 1e-3)],
        slow=[("dop853", "c", 1e-13, 1e-9)],
        nightly=[("dop853", "numpy", 1e-7, 1e-6)],
    ),
)
def test_elastic_beam_of_the_ivp_test_set(
    method: str, target: str, rtol: float, limit: float
) -> None:
    """theta_i is phi_{i-1}: angles, then rates, as in the state. Rates are the worse half: the
    fastest modes, near 6400 rad/s, multiply errors of angles."""
    settings = {"method": method, "rtol": rtol, "atol": rtol / 10, "output_every": 5.0}
    scene, exact = Scene.example("ivp_beam"), np.array(PUBLISHED["y"])
    sol = rodgen.simulate(scene, target=target, **settings)
    assert sol.t[-1] == 5.0
    np.testing.assert_allclose(sol.y[-1], exact, rtol=0, atol=limit)
    np.testing.assert_allclose(sol.y[-1, :40], exact[:40], rtol=0, atol=limit / 100)
