"""Floquet multipliers against Mathieu's functions, eigenvalues, and products of maps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

import rodgen
from rodgen.analyse.cycles.elimination import CondensedSystem
from rodgen.analyse.cycles.floquet import floquet, product_eigenvalues
from rodgen.errors import AnalysisError
from rodgen.scene import Scene
from rodgen.system import System
from tests.analyse.rods import eigenvalues, rod

pytestmark = pytest.mark.compiler


def _pendulum(a: float, b: float) -> Scene:
    """One pinned link with a moment of inertia of 1 kg m^2 under a tip load: Mathieu's equation
    x'' + (a - 2q cos 2t) x = 0 with b = -2q, for small angles."""
    keys = {"length": 1.0, "bending_stiffness": 0.0, "mass": 3.0, "parameters": {"a": a, "b": b}}
    return rod(1, "pinned", {"tip": {"x": "a + b*cos(2*t)"}}, **keys)


def _edge(low: float, high: float, q: float) -> float:
    """Where between two values of a stability changes, by bisection."""
    stable = floquet(_pendulum(low, 2 * q)).stable
    for _ in range(24):
        middle = (low + high) / 2
        alike = floquet(_pendulum(middle, 2 * q)).stable == stable
        low, high = (middle, high) if alike else (low, middle)
    return low


@pytest.mark.parametrize(
    ("exact", "bracket", "q"),
    [
        (mathieu_b(1, 0.15), (0.5, 1.0), 0.15),
        (mathieu_a(2, 1.0), (4.1, 5.0), 1.0),
        pytest.param(mathieu_a(1, 0.15), (1.0, 1.5), 0.15, marks=pytest.mark.slow),
        pytest.param(mathieu_b(2, 1.0), (3.0, 4.1), 1.0, marks=pytest.mark.slow),
    ],
)
def test_boundaries_of_mathieus_equation(
    exact: float, bracket: tuple[float, float], q: float
) -> None:
    """The edges of the first two tongues: b1, a1, b2, a2 (SciPy). What counts as on the circle,
    1e-5, moves them by its square."""
    assert _edge(*bracket, q) == pytest.approx(exact, abs=2e-7)


def test_multipliers_answer_each_other_and_do_not_depend_on_segments() -> None:
    """Without damping their product is 1; in the first tongue the largest is negative."""
    whole = floquet(_pendulum(1.0, 0.3), segments=1)
    assert whole.period == pytest.approx(np.pi)
    assert np.prod(whole.multipliers) == pytest.approx(1.0, abs=1e-9)
    assert whole.argument == pytest.approx(np.pi)
    assert not whole.stable
    assert whole.growth == pytest.approx(np.log(whole.modulus) / np.pi)
    for segments in (3, 5, 20):
        found = floquet(_pendulum(1.0, 0.3), segments=segments)
        np.testing.assert_allclose(found.multipliers, whole.multipliers, atol=1e-9)


BEAM: dict[str, Any] = {"length": 1.0, "bending_stiffness": 30.0, "mass": 3.0}


@pytest.mark.parametrize("segments", [3, 5, 20])
@pytest.mark.parametrize(
    "multipliers", [product_eigenvalues, lambda G: CondensedSystem.of(G).multipliers]
)
def test_multipliers_that_a_product_of_segments_loses(
    multipliers: Callable[[list[Any]], Any], segments: int
) -> None:
    """Of segments that are made from their multipliers, from 1e14 to 1e-6: beside the largest, a
    product is all rounding below 1e-2."""
    random = np.random.default_rng(3)
    mu = np.array([1e14, 1e6, 1.0, 0.5, 1e-3, 1e-6])
    bases = [np.linalg.qr(random.standard_normal((6, 6)))[0] for _ in range(segments)]
    share = np.diag(mu ** (1 / segments))
    G = [bases[(i + 1) % segments] @ share @ bases[i].T for i in range(segments)]
    product = np.linalg.multi_dot(G[::-1])
    assert abs(np.sort(np.abs(np.linalg.eigvals(product)))[1] - 1e-3) > 1e-4
    found = multipliers(G)
    # Errors are those of angles: 1e-16 about 1, and as much of the inverse of a large one.
    assert found[0].real == pytest.approx(mu[0], rel=1e-2)
    np.testing.assert_allclose(found.real[1:4], mu[1:4], rtol=1e-9)
    np.testing.assert_allclose(found[4:], mu[4:], atol=1e-9)


@pytest.mark.slow
def test_forced_motion_is_found_and_its_multipliers_are_those_of_the_matrix() -> None:
    """A load across a damped column drives it round; the motion is small, and decays towards it as
    about rest."""
    loads = {"tip": {"x": 0.0, "y": "a*sin(w*t)"}, "internal_damping": {"coefficient": 2.0}}
    scene = rod(3, "clamped", loads, **BEAM, parameters={"a": 1e-4, "w": 8.0})
    found = floquet(scene)
    assert found.closed < 1e-9
    assert np.abs(found.y).max() > 1e-7
    sol = rodgen.simulate(
        System(scene).at(y0=found.y), span=[0.0, found.period], rtol=1e-12, atol=1e-14
    )
    np.testing.assert_allclose(sol.y[-1], found.y, atol=1e-9)
    exact = np.exp(eigenvalues(scene, np.zeros(6)) * found.period)
    for one in exact[np.abs(exact) > 1e-6]:
        assert np.abs(found.multipliers - one).min() < 1e-6
    assert found.stable


@pytest.mark.slow
def test_rod_that_flies_is_judged_beside_its_place() -> None:
    thrust = {"follower": {"force": "20*(1 + 0.2*sin(9*t))"}}
    keys = BEAM | {"length": 2.0, "initial": {"phi": "0.01*cos(pi*s)"}}
    found = floquet(rod(3, "free", thrust, **keys))
    assert len(found.multipliers) == 6
    # That it may point anywhere is a multiplier of one, twice.
    assert np.sort(np.abs(found.multipliers - 1))[1] < 1e-4


def test_no_motion_of_a_period(monkeypatch: pytest.MonkeyPatch) -> None:
    """From a state that a period does not bring back, with too few iterations to find one."""
    monkeypatch.setattr("rodgen.analyse.cycles.floquet.ITERATIONS", 1)
    with pytest.raises(AnalysisError, match=r"\b3\.14159 s"):
        floquet(_pendulum(1.0, 0.3), y=[1.0, 5.0])


def test_the_period_of_loads_whose_periods_have_a_common_one() -> None:
    """Two and three swings in 2 pi."""
    load = {"tip": {"x": "1 + 0.1*sin(2*t) + 0.1*sin(3*t)"}}
    scene = rod(1, "pinned", load, length=1.0, bending_stiffness=0.0, mass=3.0)
    found = floquet(scene, model=rodgen.build(scene, "numpy"))
    assert found.period == pytest.approx(2 * np.pi)
