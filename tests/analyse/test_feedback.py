"""Modes and critical loads of rods whose loads follow the motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.errors import AnalysisError
from rodgen.scene import Scene
from tests.analyse.rods import ONES, are_among, eigenvalues, rod

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
@pytest.mark.parametrize(
    "angle", ["0.01*phi(0.3)", pytest.param("0.2*phi(0.85)", marks=pytest.mark.nightly)]
)
def test_a_thrust_that_is_fed_back_lets_a_free_rod_diverge(angle: str) -> None:
    """Whatever the gain, and wherever the sensor."""
    links = [5, 10, 20, 40]
    found = [rodgen.critical_force(_scene(n, angle)) for n in links]
    assert {one.kind for one in found} == {"divergence"}
    value = rodgen.richardson(links, [one.force for one in found]).value
    assert value == pytest.approx(DIVERGENCE, rel=1e-6)


@pytest.mark.parametrize("links", [20, pytest.param(80, marks=pytest.mark.slow)])
def test_the_error_says_what_a_tiny_gain_leaves(links: int) -> None:
    """The stiffness is singular beside the turning of the whole rod at one and the same force for
    every gain; a tiny one leaves that to rounding."""
    exact = rodgen.critical_force(_scene(links, "0.5*phi(0.3)"), lowest=15.0, highest=35.0)
    for gain in (1e-2, 1e-4):
        scene = _scene(links, f"{gain}*phi(0.3)")
        found = rodgen.critical_force(scene, lowest=15.0, highest=35.0)
        assert abs(found.force - exact.force) < found.error + exact.error
        # No blank cheque: known to a thousandth of itself at least.
        assert found.error < 1e-3


@pytest.mark.slow
def test_a_lag_moves_no_divergence() -> None:
    """At rest the gimbal stands where it is told to: that of the rod without a lag, and none of
    its bending modes, which the lead drives."""
    without, lagging = (
        rodgen.critical_force(scene, lowest=10.0, highest=40.0)
        for scene in (_scene(8, "0.1*phi(0.3)"), _scene(8, "gimbal", LAGGING))
    )
    assert lagging.kind == "divergence"
    # Rounding of entries that grow as n^4, and the tolerance of the search.
    assert lagging.force == pytest.approx(without.force, rel=1e-8)


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


@pytest.mark.nightly
def test_where_the_gyro_must_not_sit() -> None:
    """With the slope of the first bending mode of its other sign the same loop drives the mode."""
    growth = {}
    for at in (0.1, 0.9):
        modes = rodgen.natural_modes(_scene(8, f"0.05*omega({at})"), 4)
        bending = modes.frequencies > 1.0
        growth[at] = modes.growth[bending][0]
    assert growth[0.1] * growth[0.9] < 0


def test_refused() -> None:
    turned = _scene(4, "0.1 + phi(0.3)")
    with pytest.raises(AnalysisError):  # nothing holds it, and it turns
        rodgen.natural_modes(turned)
    drifts = {"gimbal": {"rate": "1 + gimbal**2"}}
    with pytest.raises(AnalysisError):
        rodgen.natural_modes(_scene(4, "gimbal", drifts))


SPAN = 100.0  # s of a run


@pytest.mark.parametrize(
    ("links", "offset"),
    [
        pytest.param(3, 0.0, marks=pytest.mark.nightly),
        pytest.param(6, 0.3, marks=pytest.mark.slow),
    ],
)
def test_growth_in_runs_is_that_of_eigenvalues(links: int, offset: float) -> None:
    """A clamped column whose gimbal lags behind its tail; one that stands askew at rest, by what
    the thrust makes up for, is known to fewer digits: of six links, noise would pass for growth
    at forces that are 1.5 % too low."""
    states = {"z": {"rate": f"({offset!r} + 0.5*phi(1) - z)/0.02"}}
    scene = _scene(links, f"z - {offset!r}", states, "clamped", **DAMPING)
    exact = rodgen.critical_force(scene).force
    # Within a run what grows by 1 % is seen.
    seen = rodgen.simulated_critical_force(scene, span=SPAN, tolerance=1e-3, target="c")
    rates = [_growth(scene, force) for force in (seen.low, seen.high)]
    assert rates[0] < np.log(1.01) / SPAN < rates[1]
    assert seen.force == pytest.approx(exact, rel=0.01)


@pytest.mark.slow
def test_a_lag_lets_a_free_rod_turn_ever_more() -> None:
    """Under any thrust, and slowly: the bending hardly tells of it, the mean angle does."""
    scene = _scene(3, "z", {"z": {"rate": "(0.3*phi(0.2) - z)/0.02"}}, **DAMPING)
    seen = rodgen.simulated_critical_force(scene, span=SPAN, tolerance=0.02, high=0.1, target="c")
    rates = [_growth(scene, force) for force in (seen.low, seen.high)]
    assert rates[0] < np.log(1.01) / SPAN < rates[1]


def _growth(scene: Scene, force: float) -> float:
    """The largest growth [1/s] of a motion that is not neutral, by the Jacobian at rest."""
    y = scene.initial_state()
    lag = scene.states["z"].rate
    y[-1] = float(lag[1:].split(" + ")[0]) if " + " in lag else 0.0
    s = eigenvalues(scene, y, follower_force=force)
    return float(s.real[np.abs(s) > 1e-5].max())
