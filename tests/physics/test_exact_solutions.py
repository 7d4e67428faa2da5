"""Against solutions that need no rodgen: pendulum, rigid body, statics, continuum."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq, fsolve

import rodgen
from rodgen.scene import Scene

Make = Callable[..., Scene]
SCENES = Path(__file__).parents[2] / "scenes"


def test_two_links_are_a_pendulum_with_a_spring(make_scene: Make) -> None:
    """One link turns about joint 1: J phi'' = -k phi - m g (l/2) cos(phi)."""
    sol = rodgen.simulate(make_scene(2, "cantilever", ("gravity",), initial={"phi": 0.7}))
    m, l, k, g = 1.5, 1.0, 30.0, 9.81
    inertia = m * l**2 / 3

    def pendulum(_: float, y: np.ndarray) -> list[float]:
        return [y[1], (-k * y[0] - m * g * l / 2 * np.cos(y[0])) / inertia]

    start = [0.7, 0.5 * 0.75]
    exact = solve_ivp(pendulum, (0, 1), start, "Radau", sol.t, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(sol.phi[:, 1], exact.y[0], atol=1e-8)
    assert np.all(sol.phi[:, 0] == 0)


def test_one_free_link_is_a_rigid_body(make_scene: Make) -> None:
    """A follower force at the angle nu turns it evenly: (M L^2/12) phi'' = -P (L/2) sin(nu)."""
    scene = make_scene(1, "free", ("follower",), initial={"phi": 0.3, "omega": 0.0})
    sol = rodgen.simulate(scene)
    turning = -40.0 * 1.0 * np.sin(0.1) / (3.0 * 4.0 / 12)
    np.testing.assert_allclose(sol.phi[:, 0], 0.3 + turning * sol.t**2 / 2, atol=1e-9)


def _equilibrium(n: int, length: float, stiffness: float, mass: float, g: float) -> np.ndarray:
    """Angles at which the springs carry the weight beyond them, by moments about each joint."""
    l, m = length / n, mass / n
    k = stiffness / l

    def moments(moving: np.ndarray) -> np.ndarray:
        phi = np.concatenate(([0.0], moving))
        ends = np.concatenate(([0.0], np.cumsum(l * np.cos(phi))))
        middles = ends[:-1] + l * np.cos(phi) / 2
        beyond = [m * g * np.sum(middles[s:] - ends[s]) for s in range(1, n)]
        return k * np.diff(phi) + np.array(beyond)

    return np.concatenate(([0.0], fsolve(moments, np.zeros(n - 1), xtol=1e-13)))


def test_cantilever_settles_to_its_static_deflection() -> None:
    scene = Scene.from_toml(SCENES / "cantilever_self_weight.toml")
    sol = rodgen.simulate(scene)
    # Thesis 3.2 with the discrete rod solved exactly: 0.07359 m (the thesis has 0.0735).
    assert -sol.tip[-1, 1] == pytest.approx(0.07359, rel=5e-3)
    phi = _equilibrium(50, 5.0, 100.0, 0.05, 9.81)
    assert -np.sum(0.1 * np.sin(phi)) == pytest.approx(0.07359, abs=5e-6)
    np.testing.assert_allclose(sol.phi[-1], phi, atol=1e-6)


def test_large_static_deflection(make_scene: Make) -> None:
    """A hundred times the weight bends the rod by more than a radian."""
    rod = {"mass": 30.0, "bending_stiffness": 60.0}
    scene = make_scene(
        8, "cantilever", ("gravity", "internal_damping"), rod=rod, initial={"phi": 0.0}
    )
    table = scene.model_dump(exclude_none=True)
    table["loads"]["internal_damping"]["coefficient"] = 10.0
    table["initial"]["omega"] = 0.0
    sol = rodgen.simulate(
        Scene.from_dict(table), method="radau", span=[0.0, 60.0], rtol=1e-8, output_every=1.0
    )
    phi = _equilibrium(8, 2.0, 60.0, 30.0, 9.81)
    assert phi[-1] < -0.9
    np.testing.assert_allclose(sol.phi[-1], phi, atol=1e-6)


def _frequencies(boundary: str, n: int) -> np.ndarray:
    """Natural frequencies [rad/s] of a straight unit rod from the generated module: M as it is,
    K by differences of the spring energy (exact: it is quadratic)."""
    model = rodgen.build(rodgen.Structure(n, boundary, terms=()))
    p = model.parameters(mass=1.0, length=1.0, bending_stiffness=1.0)
    size = len(model.STATE) // 2
    unit = np.concatenate((np.eye(size), np.zeros((size, size))), axis=1)

    def energy(y: np.ndarray) -> np.ndarray:
        return np.asarray(model.energy(y, p)[1])

    both = energy(unit[:, None] + unit[None, :])
    alone = energy(unit)
    stiffness = both - alone[:, None] - alone[None, :]
    values = eigh(stiffness, model.mass_matrix(np.zeros(2 * size), p), eigvals_only=True)
    return np.sqrt(values[values > 1e-3])


def test_frequencies_converge_to_the_free_beam() -> None:
    """cosh(b) cos(b) = 1 (S. S. Rao, Vibration of Continuous Systems, 2007, table 11.2)."""
    roots = [brentq(lambda b: np.cosh(b) * np.cos(b) - 1, a, a + 1) for a in (4.2, 7.4, 10.5)]
    exact = np.square(roots)
    coarse, fine = _frequencies("free", 20)[:3], _frequencies("free", 40)[:3]
    order = np.log2(np.abs(coarse / exact - 1) / np.abs(fine / exact - 1))
    np.testing.assert_allclose(fine, exact, rtol=1e-3)
    # Second order in stiffness and in rotary inertia; for free ends the two errors cancel.
    np.testing.assert_allclose(order, 4.0, atol=0.2)


def test_frequencies_converge_to_the_cantilever() -> None:
    """cosh(b) cos(b) = -1, for the length that moves: 1 - 1/n. The clamp is of first order."""
    root = brentq(lambda b: np.cosh(b) * np.cos(b) + 1, 1.5, 2.5)
    errors = []
    for n in (40, 80):
        moving = 1 - 1 / n
        # mass and stiffness per length are those of the whole rod
        errors.append(_frequencies("cantilever", n)[0] / (root / moving) ** 2 - 1)
    assert abs(errors[1]) < 0.02
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.2)
