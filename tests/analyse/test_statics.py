"""Static equilibria: against moments taken by hand, the elastica, and runs that come to rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.optimize import fsolve

import rodgen
from rodgen.analyse import elastica
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.extrapolate import richardson
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
    """Against moments taken by hand, solved in 300 steps of load, each from the one before."""
    phi = np.full(6, angle)

    def moments(turned: Any, share: float) -> list[float]:
        loads = (share * tip[0], share * tip[1])
        return [float(m) for m in _residual_moments(6, list(turned), share * g, loads, angle)]

    for share in np.linspace(0.0, 1.0, 301)[1:]:
        phi = fsolve(moments, phi, args=(share,), xtol=1e-12)
    loads = {"gravity": {"g": g}, "tip": {"x": tip[0], "y": tip[1]}}
    found = static_equilibrium(rod(6, "clamped", loads, clamp_angle=angle))
    np.testing.assert_allclose(found.phi, phi, atol=1e-9)


@pytest.mark.parametrize("load", [1.0, 10.0])
@pytest.mark.parametrize("weight", [False, True])
def test_large_deflections_extrapolate_to_the_elastica(rod: Rod, load: float, weight: bool) -> None:
    force = load * STIFFNESS / LENGTH**2
    loads = {"gravity": {"g": force / MASS}} if weight else {"tip": {"y": -force}}
    n = [20, 40, 80, 160]
    tips = [static_equilibrium(rod(k, "clamped", loads)).tip for k in n]
    expected = elastica.own_weight(load) if weight else elastica.tip_force(load)
    for at, exact in ((0, expected.x), (1, -expected.y)):
        found = richardson(n, [tip[at] / LENGTH for tip in tips], order=[2, 4, 6])
        assert found.value == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("boundary", ["clamped", "cantilever", "pinned"])
def test_a_damped_run_comes_to_rest_there(rod: Rod, boundary: str) -> None:
    loads = {
        "gravity": {"g": 3.0},
        "tip": {"x": 10.0, "y": 0.0},
        "internal_damping": {"coefficient": 2.0},
        "external_damping": {"coefficient": 4.0},
    }
    table = rod(5, boundary, loads).model_dump(exclude_none=True)
    table["integrate"] = {"span": [0.0, 60.0], "method": "radau", "rtol": 1e-8, "atol": 1e-10}
    scene = Scene.from_dict(table)
    end = rodgen.simulate(scene, target="numpy")
    # Drag ends where the velocity turns along the rod: the last digits of rest come slowly.
    np.testing.assert_allclose(end.tip[-1], static_equilibrium(scene).tip, atol=1e-5)


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
