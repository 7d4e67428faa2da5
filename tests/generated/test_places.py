"""Loads that a scene has several of, each at a point of its own, in every target and form."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.check.module import check_module
from rodgen.derive.proofs import comparisons
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.scene import Scene
from rodgen.scene.structure import Structure
from tests.palette import PLACED, can_move, cases

Built = Callable[..., ModuleType]
# At joint 0 and inside the first link, at the tail and at the end of the last link but one.
PLACES = {
    1: ("follower@0", "follower@0+1/2"),
    2: ("follower@0+2/3", "follower@1", "follower"),
    4: ("follower@0", "follower@2+1/7", "follower"),
}


@cases("boundary, links, inertia", BOUNDARIES, PLACES, INERTIAS, where=can_move)
def test_all_derivations_agree(boundary: str, links: int, inertia: str) -> None:
    for explicit in (True, False):
        held = [
            c.name for c in comparisons(links, boundary, inertia, PLACES[links], explicit, links)
        ]
        assert held.count("F") == 2 * len(PLACES[links])
        assert "accelerations" in held


@pytest.mark.nightly
@cases(
    "boundary, links, inertia, form",
    *(BOUNDARIES, PLACES, INERTIAS, ("chain", "dense")),
    where=can_move,
)
def test_module_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, links: int, inertia: str, form: str
) -> None:
    module = built(Structure(links, boundary, inertia, PLACES[links]), "numpy", form)
    # Rounding of some hundred operations, amplified by the condition of M.
    assert max(d.error for d in check_module(module, states=2)) < 1e-12


def test_its_jacobian_is_that_of_the_closed_form(built: Built, point: type) -> None:
    at: Any = point(built(PLACED))
    exact = at.exact_jacobian()
    np.testing.assert_allclose(
        at.module.jac(at.t, at.y, at.p), exact, rtol=0, atol=1e-9 * np.abs(exact).max()
    )


@pytest.mark.compiler
def test_compiled_module_does_what_numpys_does(built: Built, point: type) -> None:
    at, other = point(built(PLACED)), built(PLACED, "c")
    assert max(d.error for d in check_module(other, states=2)) < 1e-12
    J = at.module.jac(at.t, at.y, at.p)
    # Both follow from the same tangents, by different eliminations.
    np.testing.assert_allclose(other.jac(at.t, at.y, at.p), J, rtol=0, atol=1e-11 * np.abs(J).max())
    Y = at.y + np.linspace(0.0, 1.0, 9)[:, None]
    many = other.rhs_batch(at.t, Y, np.tile(at.p, (9, 1)))
    single = [at.module.rhs(at.t, y, at.p) for y in Y]
    np.testing.assert_allclose(many, single, rtol=0, atol=1e-11 * np.abs(single).max())


@pytest.mark.compiler
def test_work_of_a_force_on_the_first_link_of_a_free_rod(make_scene: Callable[..., Scene]) -> None:
    """No link before it turns its point: a sum over none."""
    scene = make_scene(1, "free", ("follower",), span=[0.0, 0.1])
    sol = rodgen.simulate(scene.replace({"loads.follower.at": 0.0}), target="c")
    assert np.ptp(sol.work["follower"]) > 0.01  # J
    assert sol.energy_error < 1e-9  # of a rigid link, whose motion is smooth
