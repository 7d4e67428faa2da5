"""Static equilibria: against moments taken by hand, buckling loads and the elastica; all
equilibria, as many as buckling loads have been passed."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import rodgen
from rodgen.analyse.branches.deflation import static_equilibria
from rodgen.analyse.references import elastica
from rodgen.analyse.statics import static_equilibrium
from rodgen.scene import Scene
from tests.analyse.rods import LENGTH, MASS, ONES, STIFFNESS, rod
from tests.sets import sets

LEFT = {"angle": -np.pi / 2}  # on which side a pressure pushes a rod


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


def test_angles_to_ten_digits() -> None:
    for tip in ((0.0, 0.0), (-20.0, 35.0), (3.0, -200.0)):
        scene = rod(5, "clamped", {"gravity": {"g": 2.0}, "tip": {"x": tip[0], "y": tip[1]}})
        found = static_equilibrium(scene)
        exact = _exact(found.phi, 2.0, tip)
        np.testing.assert_allclose(found.phi, exact, atol=1e-12)
        ends = np.cos(exact).sum(), np.sin(exact).sum()
        np.testing.assert_allclose(found.tip, ends, atol=1e-10)


def _exact(near: Any, g: float, tip: tuple[float, float]) -> np.ndarray:
    """Angles of the clamped rod in balance, near these."""

    def moments(*phi: Any) -> list[Any]:
        return _residual_moments(len(near), list(phi), g, tip)

    with mp.workdps(30):
        return np.array([float(a) for a in mp.findroot(moments, tuple(map(float, near)))])


def test_the_branch_is_that_of_small_steps() -> None:
    """Against moments taken by hand, solved in 60 steps of load, each from the one before."""
    angle, g, tip = 1.0, 2.0, (-30.0, -50.0)
    phi = np.full(4, angle)

    def moments(turned: Any, share: float) -> list[float]:
        loads = (share * tip[0], share * tip[1])
        return [float(m) for m in _residual_moments(4, list(turned), share * g, loads, angle)]

    for share in np.linspace(0.0, 1.0, 61)[1:]:
        phi = fsolve(moments, phi, args=(share,), xtol=1e-12)
    loads = {"gravity": {"g": g}, "tip": {"x": tip[0], "y": tip[1]}}
    found = static_equilibrium(rod(4, "clamped", loads, clamp_angle=angle))
    np.testing.assert_allclose(found.phi, phi, atol=1e-9)


def test_heavy_loads_are_stepped_to() -> None:
    found = static_equilibrium(rod(40, "clamped", {"gravity": {"g": 300.0}}))
    assert len(found.stages) > 3
    assert found.stages[-1] == 1.0
    assert found.stable
    assert found.phi[-1] == pytest.approx(-np.pi / 2, abs=1e-2)


def test_steps_of_the_load_take_few_corrections() -> None:
    """They begin where the tangent turns to, and end when the next correction would be rounding: 23
    in all, 29 along the tangent alone, 26 to rounding at every step."""
    found = static_equilibrium(rod(6, "clamped", {"follower": {"force": 40.0, "angle": 1.5}}))
    assert found.iterations < 26
    assert found.change < 1e-12  # the last step goes on to rounding
    # A rod that comes to hang turns less and less: 51, 56 if the tangent turns on over all of it.
    assert static_equilibrium(rod(40, "clamped", {"gravity": {"g": 1000.0}})).iterations < 54


def test_a_column_that_would_fall_over() -> None:
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


@pytest.mark.parametrize(("n", "beyond"), sets([(5, 1e-6), (5, 1e-2)], slow=[(100, 1e-6)]))
def test_a_column_just_beyond_eulers_load(n: int, beyond: float) -> None:
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


def test_a_column_just_below_eulers_load_stays_straight() -> None:
    scene = rod(20, "clamped", {"tip": {"x": -_euler(20) * (1 - 1e-6)}})
    for imperfection in (None, 0.01, 1.0):
        found = static_equilibrium(scene, imperfection=imperfection)
        assert found.stable
        np.testing.assert_allclose(found.phi, 0.0, atol=1e-9)


def test_the_size_of_an_imperfection_leaves_no_trace() -> None:
    """And the bent state is that of moments taken by hand."""
    scene = rod(5, "clamped", {"tip": {"x": -15.0}})
    found = [static_equilibrium(scene, imperfection=size) for size in (1e-6, 1e-3, 1.0)]
    exact = _exact(found[0].phi, 0.0, (-15.0, 0.0))
    for one in found:
        np.testing.assert_allclose(one.phi, exact, atol=1e-12)
        assert one.phi[-1] > 1


def test_what_does_not_buckle_is_the_same_with_an_imperfection() -> None:
    for boundary, loads in (("clamped", {"tip": {"x": 50.0}}), ("pinned", {"gravity": {}})):
        scene = rod(5, boundary, loads)
        plain, bent = static_equilibrium(scene), static_equilibrium(scene, imperfection=0.1)
        np.testing.assert_allclose(bent.phi, plain.phi, atol=1e-12)


def test_flutter_is_told_from_divergence() -> None:
    """Beck's column just below and above its critical load; no imperfection helps it."""
    scene = rod(6, "clamped", {"follower": {"force": 1.0}})
    critical = rodgen.critical_load(scene).value
    for over, instability in ((-1e-6, ""), (1e-6, "flutter")):
        pushed = rod(6, "clamped", {"follower": {"force": critical * (1 + over)}})
        assert static_equilibrium(pushed).instability == instability
        assert static_equilibrium(pushed, imperfection=0.01).instability == instability


@pytest.mark.slow
def test_thousands_of_links() -> None:
    force = 10.0 * STIFFNESS / LENGTH**2
    found = static_equilibrium(rod(5000, "clamped", {"tip": {"y": -force}}))
    exact = elastica.tip_force(10.0)
    # Second order in 1/n with a factor near one.
    np.testing.assert_allclose(found.tip / LENGTH, [exact.x, -exact.y], atol=1e-7)
    assert found.stable is None


def test_springs_too_soft_to_be_stepped_from() -> None:
    for stiffness in (0.0, 1e-12):
        found = static_equilibrium(rod(5, "clamped", {"gravity": {}}, bending_stiffness=stiffness))
        np.testing.assert_allclose(found.tip, [0.0, -LENGTH], atol=1e-9)
        assert found.stable


@pytest.mark.parametrize("moment", [2.0, -0.5, 2 * np.pi])
def test_a_couple_at_the_tail_bends_a_rod_to_a_circle(moment: float) -> None:
    """Every joint by M l/EI, the root by half of it: the links are chords of a circle that lies
    outside that of the rod, by the arc of half a link over its sine; a whole one closes."""
    n = 20
    found = static_equilibrium(rod(n, "clamped", {"moment": {"moment": moment}}, **ONES))
    np.testing.assert_allclose(found.phi, moment / n * (np.arange(n) + 0.5), atol=1e-12)
    half = moment / n / 2
    arc = np.array([np.sin(moment), 1 - np.cos(moment)]) / moment
    np.testing.assert_allclose(found.tip, half / np.sin(half) * arc, rtol=0, atol=1e-12)


def test_a_couple_is_varied_from_a_study_to_a_branch() -> None:
    """One at the tail and one at 3/8 of the rod, whose links up to there are bent by both."""
    couples = [{"moment": 0.0}, {"moment": 0.5, "at": 0.375}]
    scene = rod(4, "clamped", {"moment": couples}, **ONES)
    key, sizes = "loads.moment.0.moment", [0.5, 1.5]
    second = 0.5 * np.cumsum([0.5, 1.0, 0.0, 0.0]) / 4
    due = np.array([size / 4 * (np.arange(4) + 0.5) + second for size in sizes])
    branch = rodgen.continue_equilibria(scene, key, (0.5, 1.5))
    np.testing.assert_allclose(branch.phi[[0, -1]], due, atol=1e-9)
    study = rodgen.study(scene, {key: sizes}, analysis="static", workers=1)
    np.testing.assert_allclose(study.tip_angle, due[:, -1], atol=1e-12)


@pytest.mark.parametrize("pressure", [15.0, 25.0])
def test_a_pressure_to_the_left(pressure: float) -> None:
    """Against the elastica, shot from the tail: EI theta'' = sin(theta) F_x - cos(theta) F_y with F
    the pressure on all that is beyond."""

    def rates(s: float, state: Any) -> list[float]:
        theta, bend, _, _, across, up = state
        c, s = np.cos(theta), np.sin(theta)
        return [bend, s * across - c * up, c, s, pressure * s, -pressure * c]

    def shot(last: float) -> Any:
        start = [last, 0.0, 0.0, 0.0, 0.0, 0.0]
        return solve_ivp(rates, (1.0, 0.0), start, "DOP853", rtol=1e-11, atol=1e-11).y[:, -1]

    scenes = [
        rod(n, "clamped", {"distributed_follower": {"force_per_length": pressure} | LEFT}, **ONES)
        for n in (20, 40, 80)
    ]
    found = [static_equilibrium(scene) for scene in scenes]
    last = fsolve(lambda last: shot(last.item())[0], found[-1].phi[-1], xtol=1e-12)
    expected = -shot(last.item())[2:4]
    tips = [one.tip for one in found]
    finer = [(4 * b - a) / 3 for a, b in pairwise(tips)]
    np.testing.assert_allclose((16 * finer[1] - finer[0]) / 15, expected, rtol=0, atol=1e-5)


def column(load: float, across: float = 0.0, links: int = 5) -> Scene:
    return rod(links, "clamped", {"tip": {"x": -load, "y": across}}, **ONES)


@pytest.mark.parametrize(("links", "load", "pairs"), sets([(2, 5.0, 1)], slow=[(5, 30.0, 2)]))
def test_a_column_has_a_pair_for_each_buckling_load(links: int, load: float, pairs: int) -> None:
    """Those passed are about pi^2/4 and 9 pi^2/4: the straight column and pairs of bent ones."""
    found = static_equilibria(column(load, links=links))
    assert [one.stable for one in found] == [True, True] + [False] * (2 * pairs - 1)
    assert {one.instability for one in found[2:]} == {"divergence"}
    for k in range(pairs):
        np.testing.assert_allclose(found[2 * k].phi, -found[2 * k + 1].phi, atol=1e-9)
    assert np.abs(found[-1].phi).max() < 1e-12
    bent = static_equilibrium(column(load, links=links), imperfection=0.01)
    assert min(np.abs(one.phi - bent.phi).max() for one in found[:2]) < 1e-9


@pytest.mark.slow
def test_deflation_finds_what_no_branch_leads_to() -> None:
    """A small force across leaves one branch from the unloaded rod; the other four equilibria are
    still there, beside those of the column without it."""
    found = static_equilibria(column(30.0, 0.5))
    assert [one.stable for one in found] == [True, True, False, False, False]
    assert sorted(bool(one.iterations) for one in found) == [False, True, True, True, True]
