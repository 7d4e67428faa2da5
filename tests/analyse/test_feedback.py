"""Modes and critical loads of rods whose loads follow the motion, and growth read off runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.simulated_critical import dmd_growth
from rodgen.scene import Scene
from tests.analyse.rods import ONES, are_among, eigenvalues, rod
from tests.told import refused

# (9/4) j^2 EI/L^2 with j the first zero of the Bessel function of order 2/3.
DIVERGENCE = 25.638181376802
LEAD = "0.1*phi(0.3) + 0.05*omega(0.3)"
LAGGING = {"gimbal": {"rate": f"({LEAD} - gimbal)/0.01"}}


def _scene(
    links: int,
    angle: str,
    states: dict[str, Any] | None = None,
    boundary: str = "free",
    **loads: Any,
) -> Scene:
    follower = {"follower": {"force": 3.0, "angle": angle}}
    return rod(links, boundary, follower | loads, **ONES, states=states or {})


@pytest.mark.slow
def test_a_couple_that_is_fed_back_is_a_support_against_turning() -> None:
    """Modes about the bent rod, and the onset of flutter, of a spring and a damper at the tail."""
    law = "-2*phi(1) - 0.1*omega(1)"
    loads = {"follower": {"force": 3.0}, "gravity": {"g": 1.0}}
    held = {"at": 1.0, "rotation": 2.0, "rotation_damping": 0.1}
    one = rod(4, "clamped", loads | {"moment": {"moment": law}}, **ONES)
    two = rod(4, "clamped", loads, **ONES, supports=[held])
    found, expected = (rodgen.natural_modes(scene, 4) for scene in (one, two))
    for name in ("frequencies", "growth"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=1e-9)
    onsets = [rodgen.critical_load(scene.replace({"loads.gravity": None})) for scene in (one, two)]
    assert onsets[0].value == pytest.approx(onsets[1].value, rel=1e-9)


@pytest.mark.parametrize(
    ("load", "table", "key"),
    [
        ("all", {"moment": {"moment": "-phi(1)"}}, "loads.moment.moment"),
        ("followers", {"follower": {"force": "1 - phi(1)"}}, "loads.follower.force"),
        ("tip", {"tip": {"x": -1.0, "y": "-phi(1)"}}, "loads.tip.y"),
    ],
)
def test_a_load_that_follows_the_motion_has_no_size_to_scale(
    load: str, table: dict[str, Any], key: str
) -> None:
    scene = rod(3, "clamped", {"gravity": {"g": 1.0}} | table, **ONES)
    told = refused(rodgen.critical_load, scene, load=load)
    assert told[0] == key
    assert "an expression in t" in told.allowed


@pytest.mark.slow
def test_a_thrust_that_is_fed_back_lets_a_free_rod_diverge() -> None:
    """Whatever the gain, and wherever the sensor."""
    links = [5, 10, 20, 40]
    found = [rodgen.critical_load(_scene(n, "0.01*phi(0.3)")) for n in links]
    assert {one.kind for one in found} == {"divergence"}
    value = rodgen.richardson(links, [one.value for one in found]).value
    assert value == pytest.approx(DIVERGENCE, rel=1e-6)


@pytest.mark.parametrize("links", [20, pytest.param(80, marks=pytest.mark.slow)])
def test_the_error_says_what_a_tiny_gain_leaves(links: int) -> None:
    """The stiffness is singular beside the turning of the whole rod at one and the same force for
    every gain; a tiny one leaves that to rounding."""
    exact = rodgen.critical_load(_scene(links, "0.5*phi(0.3)"), bounds=(15.0, 35.0))
    for gain in (1e-2, 1e-4):
        scene = _scene(links, f"{gain}*phi(0.3)")
        found = rodgen.critical_load(scene, bounds=(15.0, 35.0))
        assert abs(found.value - exact.value) < found.error + exact.error
        # No blank cheque: known to a thousandth of itself at least.
        assert found.error < 1e-3


@pytest.mark.slow
def test_a_lag_moves_no_divergence() -> None:
    """At rest the gimbal stands where it is told to: that of the rod without a lag, and none of
    its bending modes, which the lead drives."""
    without, lagging = (
        rodgen.critical_load(scene, bounds=(10.0, 40.0))
        for scene in (_scene(8, "0.1*phi(0.3)"), _scene(8, "gimbal", LAGGING))
    )
    assert lagging.kind == "divergence"
    # Rounding of entries that grow as n^4, and the tolerance of the search.
    assert lagging.value == pytest.approx(without.value, rel=1e-8)


DAMPING = {"material_damping": {"time": 0.01}}


@pytest.mark.parametrize(
    ("angle", "states", "loads"),
    [
        (LEAD, {}, {}),
        ("gimbal", LAGGING, {}),
        ("0.1*y(0.3) + 0.2*phi(0.2) + 0.1*vy(0)", {}, {}),
        ("0.1*(gimbal + y(1))", LAGGING, {}),
        # What damping does to the joints is no force on joint 0, whose place follows the angles.
        ("gimbal", LAGGING, DAMPING),
        ("0.3*phi(0.2) + 0.1*omega(0.6)", {}, DAMPING),
    ],
)
def test_modes_are_eigenvalues_of_the_jacobian(
    angle: str, states: dict[str, Any], loads: dict[str, Any]
) -> None:
    scene = _scene(5, angle, states, **loads)
    modes = rodgen.natural_modes(scene, 4)
    are_among(modes, eigenvalues(scene))
    assert modes.displacements.shape == (len(modes.frequencies), 6, 2)
    assert len(modes.frequencies) >= 3


SPAN = 100.0  # s of a run


@pytest.mark.slow
@pytest.mark.parametrize(
    ("links", "boundary", "at", "offset"),
    [
        # A clamped column whose gimbal lags behind its tail stands askew at rest, by what the
        # thrust makes up for: noise would pass for growth at forces that are 1.5 % too low.
        (6, "clamped", "0.5*phi(1)", 0.3),
        # A free rod turns ever more under any thrust, and slowly: the mean angle tells of it.
        (3, "free", "0.3*phi(0.2)", 0.0),
    ],
)
def test_growth_in_runs_is_that_of_eigenvalues(
    links: int, boundary: str, at: str, offset: float
) -> None:
    """Within a run what grows by 1 % is seen."""
    states = {"z": {"rate": f"({offset} + {at} - z)/0.02"}}
    scene = _scene(links, f"z - {offset}", states, boundary, **DAMPING)
    how: dict[str, Any] = {"tolerance": 1e-3}
    if boundary == "free":
        how = {"tolerance": 0.02, "bounds": (0.0, 0.1)}
    seen = rodgen.simulated_critical_load(scene, span=SPAN, target="c", **how)
    y = scene.initial_state()
    y[-1] = offset  # at rest
    rates = []
    for force in (seen.low, seen.high):
        s = eigenvalues(scene, y, follower_force=force)
        rates.append(s.real[np.abs(s) > 1e-5].max())  # but for motions that are neutral
    assert rates[0] < np.log(1.01) / SPAN < rates[1]
    if boundary == "clamped":
        assert seen.value == pytest.approx(rodgen.critical_load(scene).value, rel=0.01)


T = np.linspace(0.0, 4.0, 801)
RATES = np.array([0.02 + 3j, -0.5 + 11j, -3.0 + 40j])


@pytest.mark.parametrize("fastest", [0.02, 0.0, -0.1, 0.8])
@pytest.mark.parametrize("noise", [0.0, 1e-9])
def test_growth_in_samples_of_three_motions(fastest: float, noise: float) -> None:
    """The second oscillates 30 times as fast as samples could tell, the third dies at once."""
    random = np.random.default_rng(1)
    rates = RATES.copy()
    rates[0] = fastest + 3j
    shapes = random.normal(size=(3, 5)) + 1j * random.normal(size=(3, 5))
    angles, speeds = (np.exp(np.outer(T, rates)) @ (k * shapes) for k in (1, rates[:, None]))
    found = dmd_growth([angles.real + noise * random.normal(size=angles.shape), speeds.real])
    # A thousandth of what is found to be growth.
    assert found == pytest.approx(np.exp(4.0 * fastest), rel=1e-5)
    assert dmd_growth([0.0 * angles.real, 0.0 * speeds.real]) == 0.0  # nothing moves
