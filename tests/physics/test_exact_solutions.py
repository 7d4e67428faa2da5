"""Against solutions that need no rodgen: pendulum, rigid body, statics, continuum."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq, fsolve
from scipy.special import ellipk, jn_zeros

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


def _frequencies(boundary: str, n: int, inertia: str = "uniform") -> np.ndarray:
    """Natural frequencies [rad/s] of a straight unit rod from the generated module: M as it is,
    K by differences of the spring energy (exact: it is quadratic)."""
    model = rodgen.build(rodgen.Structure(n, boundary, inertia, terms=()))
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


def _order(boundary: str, inertia: str, exact: np.ndarray) -> np.ndarray:
    """Observed order of the lowest frequencies in 1/n, which must be within a hundredth."""
    coarse, fine = (_frequencies(boundary, n, inertia)[: len(exact)] for n in (20, 40))
    np.testing.assert_allclose(fine, exact, rtol=1e-2)
    return np.log2(np.abs(coarse / exact - 1) / np.abs(fine / exact - 1))


# S. S. Rao, Vibration of Continuous Systems, 2007, table 11.2: clamped-free, pinned-free.
BEAMS = {
    "clamped": (lambda b: np.cosh(b) * np.cos(b) + 1, ((1.5, 2.5), (4.2, 5.2), (7.4, 8.4))),
    "pinned": (lambda b: np.tan(b) - np.tanh(b), ((3.5, 4.2), (6.7, 7.4), (9.9, 10.5))),
}


@pytest.mark.parametrize("inertia", ["uniform", "lumped"])
@pytest.mark.parametrize("boundary", BEAMS)
def test_frequencies_converge_to_the_held_beam(boundary: str, inertia: str) -> None:
    """Of second order in 1/n, the clamp too: half a link bends at a root spring of 2 EI/l. For
    uniform links without a clamp the errors of stiffness and rotary inertia cancel."""
    equation, brackets = BEAMS[boundary]
    exact = np.square([brentq(equation, *bracket) for bracket in brackets])
    order = 4.0 if (boundary, inertia) == ("pinned", "uniform") else 2.0
    np.testing.assert_allclose(_order(boundary, inertia, exact), order, atol=0.2)


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


# Clamped and pinned -----------------------------------------------------------------------------


def _statics(model: ModuleType, p: np.ndarray) -> np.ndarray:
    """Angles at which nothing accelerates, by Newton's method with the module's Jacobian."""
    size = len(model.STATE) // 2
    y = np.zeros(2 * size)
    for _ in range(20):
        rates, J = model.rhs(0.0, y, p)[size:], model.jac(0.0, y, p)[size:, :size]
        y[:size] -= np.linalg.solve(J, rates)
    return y


@pytest.mark.parametrize("inertia", ["uniform", "lumped"])
@pytest.mark.parametrize("n", [1, 4, 16])
def test_clamped_rod_bends_under_a_force_at_its_tip(n: int, inertia: str) -> None:
    """Moments F (L - s l) turn springs EI/l (2 EI/l at the root): by hand the tip sinks by
    (1/3 + 1/(6 n^2)) F L^3/EI, of second order in 1/n; Euler and Bernoulli have F L^3/(3 EI)."""
    model = rodgen.build(rodgen.Structure(n, "clamped", inertia, ("tip_load",)))
    force, length, stiffness = 1e-5, 2.0, 30.0
    p = model.parameters(mass=3.0, length=length, bending_stiffness=stiffness, tip_force_y=force)
    tip = model.joints(_statics(model, p), p)[-1, 1]
    expected = (1 / 3 + 1 / (6 * n**2)) * force * length**3 / stiffness
    # Linear theory: off by the square of angles of 1e-6; Newton's steps by the condition of M.
    assert tip == pytest.approx(expected, rel=1e-9)


def test_clamped_rod_bends_far_as_an_elastica() -> None:
    """F L^2/EI = 2: the tip turns by 0.782 rad and sinks by 0.4935 L (K. E. Bisshopp and D. C.
    Drucker, 1945, by elliptic integrals), here by quadrature."""
    load = 2.0

    def arc(tip: float) -> float:
        """sqrt(2 F/EI) times the length of a rod whose tip turns that far; sin = 1 - u^2."""
        top = np.sin(tip)
        u, w = np.polynomial.legendre.leggauss(200)
        u, w = (u + 1) / 2 * np.sqrt(top), w / 2 * np.sqrt(top)
        return float(np.sum(w * 2.0 / np.sqrt(1.0 - (top - u**2) ** 2)))

    tip = brentq(lambda a: arc(a) - np.sqrt(2 * load), 0.1, 1.5)
    errors = []
    for n in (20, 40):
        model = rodgen.build(rodgen.Structure(n, "clamped", terms=("tip_load",)))
        p = model.parameters(mass=1.0, length=1.0, bending_stiffness=1.0, tip_force_y=load)
        size = len(model.STATE) // 2
        y = _statics(model, p)
        # Extrapolated to the end of the last link, whose angle is that of its middle.
        errors.append(1.5 * y[size - 1] - 0.5 * y[size - 2] - tip)
    assert abs(errors[1]) < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


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


def test_hanging_chain_swings_as_a_rope() -> None:
    """J_0(2 omega sqrt(L/g)) = 0 (D. Bernoulli, 1733), of second order in 1/n."""
    exact = jn_zeros(0, 2) / 2 * np.sqrt(9.81)
    errors = []
    for n in (20, 40):
        model = rodgen.build(rodgen.Structure(n, "pinned", "lumped", ("gravity",)))
        p = model.parameters(mass=1.0, length=1.0, bending_stiffness=0.0)
        hanging = np.concatenate((np.full(n, -np.pi / 2), np.zeros(n)))
        squares = -np.linalg.eigvals(model.jac(0.0, hanging, p)[n:, :n]).real
        errors.append(np.sqrt(np.sort(squares)[:2]) / exact - 1)
    assert np.abs(errors[1]).max() < 3e-3
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 2.0, atol=0.2)


def test_clamp_angle_turns_the_whole_rod(make_scene: Make) -> None:
    """Without gravity nothing else knows where a rod points."""
    one, two = (
        rodgen.simulate(
            make_scene(4, "clamped", ("internal_damping",), rod, {"phi": f"{a} + 0.3*s"})
        )
        for a, rod in ((0.0, {}), (0.7, {"clamp_angle": 0.7}))
    )
    np.testing.assert_allclose(one.phi + 0.7, two.phi, rtol=0, atol=1e-8)
    assert np.ptp(one.phi) > 0.1
