"""All equilibria: as many as buckling loads have been passed, and as their stability adds up to."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rodgen.analyse.branches.coexistence import static_equilibria
from rodgen.analyse.statics import static_equilibrium
from rodgen.scene import Scene

Rod = Callable[..., Scene]
ONES = {"length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}


def test_a_column_at_30_has_five(rod: Rod) -> None:
    """Two buckling loads of pi^2/4 and 9 pi^2/4 are passed: the straight column and two pairs."""
    found = static_equilibria(rod(10, "clamped", {"tip": {"x": -30.0, "y": 0.0}}, **ONES))
    assert [one.stable for one in found] == [True, True, False, False, False]
    assert {one.instability for one in found[2:]} == {"divergence"}
    for a, b in ((0, 1), (2, 3)):
        np.testing.assert_allclose(found[a].phi, -found[b].phi, atol=1e-9)
    assert np.abs(found[4].phi).max() < 1e-12
    bent = static_equilibrium(
        rod(10, "clamped", {"tip": {"x": -30.0, "y": 0.0}}, **ONES), imperfection=0.01
    )
    assert min(np.abs(one.phi - bent.phi).max() for one in found[:2]) < 1e-9


def test_deflation_finds_what_no_branch_leads_to(rod: Rod) -> None:
    """A small force across leaves one branch from the unloaded rod; the other four equilibria are
    still there, beside those of the column without it."""
    found = static_equilibria(rod(10, "clamped", {"tip": {"x": -30.0, "y": 0.5}}, **ONES))
    assert [one.stable for one in found] == [True, True, False, False, False]
    assert sorted(bool(one.iterations) for one in found) == [False, True, True, True, True]


@pytest.mark.nightly
def test_stable_and_unstable_ones_add_up(rod: Rod) -> None:
    """Where no motion is rigid, equilibria with an even number of unstable directions are one more
    than those with an odd one."""
    found = static_equilibria(rod(8, "clamped", {"gravity": {"g": 50.0}}, **ONES))
    assert [one.stable for one in found] == [True, True, False]


@pytest.mark.nightly
def test_a_follower_force_has_one_alone(rod: Rod) -> None:
    (one,) = static_equilibria(rod(5, "clamped", {"follower": {"force": 30.0}}, **ONES))
    assert one.instability == "flutter"


@pytest.mark.nightly
@pytest.mark.parametrize("boundary", ["pinned", "clamped"])
def test_chains_too(rod: Rod, boundary: str) -> None:
    scene = rod(4, boundary, {"gravity": {"g": 9.81}}, **(ONES | {"bending_stiffness": 0.0}))
    found = static_equilibria(scene)
    assert found[0].stable
    np.testing.assert_allclose(found[0].tip, [0.0, -1.0], atol=1e-9)
