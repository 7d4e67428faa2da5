"""Equilibria of free rods on supports and of rods whose loads follow the motion: exact cases, runs
that come to rest, and the Jacobian of the module."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import rodgen
from rodgen.analyse.statics import static_equilibrium
from rodgen.scene import Scene
from tests.analyse.rods import are_among, eigenvalues, rod
from tests.sets import sets

ROD = {"length": 2.0, "mass": 4.0, "bending_stiffness": 20.0}
WEIGHT = 4.0 * 9.81


def _held(loads: dict[str, Any], links: int = 3, boundary: str = "free", **keys: Any) -> Scene:
    return rod(links, boundary, loads, **ROD, **keys)


@pytest.mark.parametrize("angle", ["0.3 + phi(1)", "0.3 + z"])
def test_one_link_whose_thrust_follows_its_angle(angle: str) -> None:
    """The root spring, 2 EI/L, bears the moment of the thrust about joint 0."""
    states = {"z": {"rate": "phi(1) - z", "initial": 0.7}} if "z" in angle else {}
    loads = {"follower": {"force": 5.0, "angle": angle}}
    found = static_equilibrium(_held(loads, 1, "clamped", states=states))
    exact = brentq(lambda a: 20.0 * a + 2.0 * 5.0 * np.sin(0.3 + a), -1.0, 1.0, xtol=1e-15)
    assert found.phi[0] == pytest.approx(exact, abs=1e-12)
    assert found.states == pytest.approx({"z": exact} if states else {}, abs=1e-12)


@pytest.mark.slow
def test_the_place_alone_may_be_fed_back() -> None:
    """A load that pulls the tail back to (1, -2) holds a free rod that does not bend; it hangs
    from there by its weight over the gain."""
    loads = {"tip": {"x": "10*(1 - x(1))", "y": "10*(-2 - y(1))"}, "gravity": {}}
    found = static_equilibrium(_held(loads, 2, supports=[{"at": 0.0, "rotation": 1.0}]))
    np.testing.assert_allclose(found.tip, [1.0, -2.0 - WEIGHT / 10.0], rtol=1e-9)


@pytest.mark.parametrize("boundary", sets([], slow=["clamped"], nightly=["free"]))
def test_a_damped_run_comes_to_rest_there(boundary: str) -> None:
    springs = {"stiffness": [30.0, 80.0], "damping": [8.0, 20.0]}
    scene = _held(
        {
            "gravity": {},
            "follower": {"force": "4 + z", "angle": "0.4*phi(0.9) - 0.1*y(0.5)"},
            "material_damping": {"time": 0.3},
        },
        boundary=boundary,
        supports=[{"at": 0.2, "to": [0.5, 0.2]} | springs, {"at": 0.9, "rotation": 1.0} | springs],
        states={"z": {"rate": "3*(y(0.5) - z) - z**3"}, "seen": {"rate": "phi(0.1) - seen"}},
        integrate={"span": [0.0, 25.0], "rtol": 1e-7, "atol": 1e-9, "output_every": 5.0},
    )
    end = rodgen.simulate(scene, target="numpy").y[-1]
    found = static_equilibrium(scene)
    assert found.stable
    # The slowest motion dies as exp(-t), to 1e-11; the tolerance of the run is what is left.
    np.testing.assert_allclose(found.y, end, atol=1e-6)
    np.testing.assert_allclose([*found.states.values()], end[-2:], atol=1e-6)
    # The equilibrium is known to rounding of the stiffness, 1e-12 of the largest rate.
    are_among(rodgen.natural_modes(scene, 3), eigenvalues(scene, found.y), 1e-7)


@pytest.mark.slow
def test_a_free_column_between_supports_buckles() -> None:
    """Hinged ends: the first buckling load of n links is 4 n EI/L (n/L) sin^2(pi/2n)."""
    n = 4
    euler = 4 * 20.0 * (n / 2.0) ** 2 * np.sin(np.pi / (2 * n)) ** 2
    ends = [{"at": 0.0, "stiffness": [1e6, 1e6]}, {"at": 1.0, "stiffness": [0.0, 1e6]}]
    for beyond, stable in ((-1e-3, True), (1e-3, False)):
        scene = _held({"tip": {"x": -euler * (1 + beyond)}}, n, supports=ends)
        straight = static_equilibrium(scene)
        assert straight.stable is stable
        np.testing.assert_allclose(straight.phi, 0.0, atol=1e-12)
        bent = static_equilibrium(scene, imperfection=0.01)
        assert bent.stable
        assert (np.abs(bent.phi).max() > 1e-2) is not stable


def test_an_integral_controller_brings_the_tail_where_it_is_told() -> None:
    loads = {"gravity": {"g": 1.0}, "follower": {"force": 3.0, "angle": "z"}}
    scene = _held(loads, 2, "clamped", states={"z": {"rate": "0.01 - phi(1)"}})
    assert static_equilibrium(scene).phi[-1] == pytest.approx(0.01, abs=1e-12)
