"""All equilibria: as many as buckling loads have been passed, and as their stability adds up to."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.analyse.branches.coexistence import static_equilibria
from rodgen.analyse.statics import static_equilibrium
from rodgen.scene import Scene
from tests.analyse.rods import ONES, rod


def column(load: float, across: float = 0.0, links: int = 5) -> Scene:
    return rod(links, "clamped", {"tip": {"x": -load, "y": across}}, **ONES)


@pytest.mark.parametrize(
    ("links", "load", "pairs"), [(2, 5.0, 1), pytest.param(5, 30.0, 2, marks=pytest.mark.slow)]
)
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


@pytest.mark.nightly
def test_stable_and_unstable_ones_add_up() -> None:
    """Where no motion is rigid, equilibria with an even number of unstable directions are one more
    than those with an odd one; a follower force leaves the straight rod alone, a chain hangs."""
    found = static_equilibria(rod(8, "clamped", {"gravity": {"g": 50.0}}, **ONES))
    assert [one.stable for one in found] == [True, True, False]
    (one,) = static_equilibria(rod(5, "clamped", {"follower": {"force": 30.0}}, **ONES))
    assert one.instability == "flutter"
    for boundary in ("pinned", "clamped"):
        chain = ONES | {"bending_stiffness": 0.0}
        first, *_ = static_equilibria(rod(4, boundary, {"gravity": {"g": 9.81}}, **chain))
        assert first.stable
        np.testing.assert_allclose(first.tip, [0.0, -1.0], atol=1e-9)
