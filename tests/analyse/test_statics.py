"""Static equilibria: against moments taken by hand, the elastica, and runs that come to rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.optimize import fsolve

import rodgen
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.extrapolate import richardson
from rodgen.analyse.references import elastica
from rodgen.analyse.statics import static_equilibrium
from rodgen.scene import Scene, SceneError

Rod = Callable[..., Scene]
STIFFNESS, LENGTH, MASS = 100.0, 5.0, 50.0


def _residual_moments(
    n: int, phi: list[Any], g: float, tip: tuple[float, float], angle: float = 0.0
) -> list[Any]:
    """Moment about every joint of what hangs behind it, less the moment of its spring; clamped,
    with a root spring of 2 EI/l."""
    l, m = mp.mpf(LENGTH) / n, mp.mpf(MASS) / n
    k = mp.mpf(STIFFNESS) / l
    moments = []
    for s in range(n):
        x = y = mp.mpf(0)
        moment = mp.mpf(0)
        for i in range(s, n):
            moment -= m * g * (x + l / 2 * mp.cos(phi[i]))
            x, y = x + l * mp.cos(phi[i]), y + l * mp.sin(phi[i])
        moment += x * tip[1] - y * tip[0]
        bend = phi[s] - (phi[s - 1] if s else angle)
        moments.append(moment - (k if s else 2 * k) * bend)
    return moments


@pytest.mark.parametrize("tip", [(0.0, 0.0), (-20.0, 35.0), (3.0, -200.0)])
def test_angles_to_ten_digits(rod: Rod, tip: tuple[float, float]) -> None:
    scene = rod(5, "clamped", {"gravity": {"g": 2.0}, "tip": {"x": tip[0], "y": tip[1]}})
    found = static_equilibrium(scene)
    with mp.workdps(30):
        exact = mp.findroot(
            lambda *phi: _residual_moments(5, list(phi), 2.0, tip), tuple(map(float, found.phi))
        )
        x = sum(mp.cos(a) for a in exact)
        y = sum(mp.sin(a) for a in exact)
    np.testing.assert_allclose(found.phi, [float(a) for a in exact], atol=1e-12)
    np.testing.assert_allclose(found.tip, [float(x), float(y)], atol=1e-10)


@pytest.mark.parametrize(
    ("angle", "g", "tip"),
    [(1.0, 2.0, (-30.0, -50.0)), (1.0, 1.0, (-10.0, -10.0)), (2.5, 3.0, (20.0, 60.0))],
)
def test_the_branch_is_that_of_small_steps(
    rod: Rod, angle: float, g: float, tip: tuple[float, float]
) -> None:
    """Against moments taken by hand, solved in 60 steps of load, each from the one before."""
    phi = np.full(4, angle)

    def moments(turned: Any, share: float) -> list[float]:
        loads = (share * tip[0], share * tip[1])
        return [float(m) for m in _residual_moments(4, list(turned), share * g, loads, angle)]

    for share in np.linspace(0.0, 1.0, 61)[1:]:
        phi = fsolve(moments, phi, args=(share,), xtol=1e-12)
    loads = {"gravity": {"g": g}, "tip": {"x": tip[0], "y": tip[1]}}
    found = static_equilibrium(rod(4, "clamped", loads, clamp_angle=angle))
    np.testing.assert_allclose(found.phi, phi, atol=1e-9)


@pytest.mark.parametrize("boundary", ["clamped", "pinned"])
def test_a_damped_run_comes_to_rest_there(rod: Rod, boundary: str) -> None:
    loads = {
        "gravity": {"g": 3.0},
        "tip": {"x": 10.0, "y": 0.0},
        "internal_damping": {"coefficient": 2.0},
        "external_damping": {"coefficient": 4.0},
    }
    table = rod(3, boundary, loads).model_dump(exclude_none=True)
    table["integrate"] = {"span": [0.0, 60.0], "method": "radau", "rtol": 1e-8, "atol": 1e-10}
    scene = Scene.from_dict(table)
    end = rodgen.simulate(scene, target="numpy")
    # Drag ends where the velocity turns along the rod: the last digits of rest come slowly.
    np.testing.assert_allclose(end.tip[-1], static_equilibrium(scene).tip, atol=3e-5)


def test_heavy_loads_are_stepped_to(rod: Rod) -> None:
    found = static_equilibrium(rod(40, "clamped", {"gravity": {"g": 300.0}}))
    assert len(found.stages) > 3
    assert found.stages[-1] == 1.0
    assert found.stable
    assert found.phi[-1] == pytest.approx(-np.pi / 2, abs=1e-2)


def test_a_column_that_would_fall_over(rod: Rod) -> None:
    upright = {"clamp_angle": np.pi / 2}
    # Greenhill: q L^3/EI = 7.837 buckles a clamped column under its own weight.
    for load, stable in ((7.7, True), (8.0, False)):
        g = load * STIFFNESS / LENGTH**2 / MASS
        found = static_equilibrium(rod(80, "clamped", {"gravity": {"g": g}}, **upright))
        assert found.stable is stable
        np.testing.assert_allclose(found.tip, [0.0, LENGTH], atol=1e-12)


def _euler(n: int) -> float:
    """Buckling load [N] of the column of n links: springs of EI n/L at joints, 2 EI n/L at the
    clamp, have sin((j + 1/2) pi / 2n) as their first shape."""
    return float(4 * STIFFNESS * (n / LENGTH) ** 2 * np.sin(np.pi / (4 * n)) ** 2)


def _energy(n: int, phi: np.ndarray, load: float) -> float:
    """Of springs and of an axial load [J]."""
    l = LENGTH / n
    bends = np.diff(phi, prepend=0.0)
    stiffness = np.full(n, STIFFNESS / l)
    stiffness[0] *= 2
    return float(stiffness @ bends**2 / 2 + load * l * np.cos(phi).sum())


@pytest.mark.parametrize("beyond", [1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("n", [5, 100])
def test_a_column_just_beyond_eulers_load(rod: Rod, n: int, beyond: float) -> None:
    """It bends by the root of what its load has too much; the straight state is not stable."""
    load = _euler(n) * (1 + beyond)
    scene = rod(n, "clamped", {"tip": {"x": -load}})
    straight = static_equilibrium(scene)
    assert (straight.stable, straight.instability) == (False, "divergence")
    np.testing.assert_array_equal(straight.phi, 0.0)
    bent = static_equilibrium(scene, imperfection=0.01)
    assert (bent.stable, bent.instability) == (True, "")
    # a^2 = 8 (1 - Euler's / load) of a bend a sin((j + 1/2) pi / 2n), from its work up to a^4; the
    # other shapes in it, and the next term, are a^2 / 16 of it at most.
    amplitude = np.sqrt(8 * beyond / (1 + beyond))
    shape = np.sin((np.arange(n) + 0.5) * np.pi / (2 * n))
    np.testing.assert_allclose(bent.phi, amplitude * shape, atol=amplitude**3 / 16)
    assert _energy(n, bent.phi, load) < _energy(n, straight.phi, load)


def test_a_column_just_below_eulers_load_stays_straight(rod: Rod) -> None:
    scene = rod(20, "clamped", {"tip": {"x": -_euler(20) * (1 - 1e-6)}})
    for imperfection in (None, 0.01, 1.0):
        found = static_equilibrium(scene, imperfection=imperfection)
        assert found.stable
        np.testing.assert_allclose(found.phi, 0.0, atol=1e-9)


@pytest.mark.parametrize("load", [3.0, 20.0])
def test_bent_columns_extrapolate_to_the_elastica(rod: Rod, load: float) -> None:
    loads = {"tip": {"x": -load * STIFFNESS / LENGTH**2}}
    n = [20, 40, 80, 160]
    found = [static_equilibrium(rod(k, "clamped", loads), imperfection=0.01) for k in n]
    assert all(one.stable for one in found)
    expected = elastica.axial_force(load)
    for at, exact in ((0, expected.x), (1, expected.y)):
        limit = richardson(n, [one.tip[at] / LENGTH for one in found], order=[2, 4, 6])
        assert limit.value == pytest.approx(exact, abs=1e-8)


def test_the_size_of_an_imperfection_leaves_no_trace(rod: Rod) -> None:
    """And the bent state is that of moments taken by hand."""
    scene = rod(5, "clamped", {"tip": {"x": -15.0}})
    found = [static_equilibrium(scene, imperfection=size) for size in (1e-6, 1e-3, 1.0)]
    with mp.workdps(30):
        exact = mp.findroot(
            lambda *phi: _residual_moments(5, list(phi), 0.0, (-15.0, 0.0)),
            tuple(map(float, found[0].phi)),
        )
    for one in found:
        np.testing.assert_allclose(one.phi, [float(a) for a in exact], atol=1e-12)
        assert one.phi[-1] > 1


def test_what_does_not_buckle_is_the_same_with_an_imperfection(rod: Rod) -> None:
    for boundary, loads in (
        ("clamped", {"gravity": {"g": 300.0}}),
        ("clamped", {"tip": {"x": 50.0}}),
        ("pinned", {"gravity": {}}),
    ):
        scene = rod(6, boundary, loads)
        plain, bent = static_equilibrium(scene), static_equilibrium(scene, imperfection=0.1)
        np.testing.assert_allclose(bent.phi, plain.phi, atol=1e-12)


def test_flutter_is_told_from_divergence(rod: Rod) -> None:
    """Beck's column just below and above its critical load; no imperfection helps it."""
    scene = rod(6, "clamped", {"follower": {"force": 1.0}})
    critical = rodgen.critical_force(scene).force
    for over, instability in ((-1e-6, ""), (1e-6, "flutter")):
        pushed = rod(6, "clamped", {"follower": {"force": critical * (1 + over)}})
        assert static_equilibrium(pushed).instability == instability
        assert static_equilibrium(pushed, imperfection=0.01).instability == instability


@pytest.mark.parametrize("imperfection", [0.0, -0.01, 1.5, np.nan, np.inf, "0.1", True])
def test_imperfections_that_are_none(rod: Rod, imperfection: Any) -> None:
    with pytest.raises(SceneError, match="above 0 and at most 1 rad"):
        static_equilibrium(rod(4, "clamped"), imperfection=imperfection)


def test_thousands_of_links(rod: Rod) -> None:
    force = 10.0 * STIFFNESS / LENGTH**2
    found = static_equilibrium(rod(5000, "clamped", {"tip": {"y": -force}}))
    exact = elastica.tip_force(10.0)
    # Second order in 1/n with a factor near one.
    np.testing.assert_allclose(found.tip / LENGTH, [exact.x, -exact.y], atol=1e-7)
    assert found.stable is None


@pytest.mark.parametrize("stiffness", [0.0, 1e-12])
def test_springs_too_soft_to_be_stepped_from(rod: Rod, stiffness: float) -> None:
    found = static_equilibrium(rod(6, "clamped", {"gravity": {}}, bending_stiffness=stiffness))
    np.testing.assert_allclose(found.tip, [0.0, -LENGTH], atol=1e-9)
    assert found.stable


def test_a_free_rod_is_refused(rod: Rod) -> None:
    with pytest.raises(SceneError, match="nothing holds a free rod"):
        static_equilibrium(rod(4, "free", {"gravity": {}}))


def test_a_pinned_rod_without_loads(rod: Rod) -> None:
    with pytest.raises(AnalysisError, match="its direction"):
        static_equilibrium(rod(4, "pinned"))


def test_a_load_that_no_equilibrium_bears(rod: Rod) -> None:
    # A follower force across the tail winds the chain without stiffness up for ever.
    scene = rod(4, "clamped", {"follower": {"force": 1.0, "angle": 1.5}}, bending_stiffness=0.0)
    with pytest.raises(AnalysisError, match="no equilibrium found beyond 0 of the load"):
        static_equilibrium(scene)
