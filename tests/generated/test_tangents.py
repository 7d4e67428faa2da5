"""Tangents of the rates along given directions, against the Jacobian of the NumPy module."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest

from rodgen.scene.structure import Structure
from tests.palette import ENDS, LAWS, LONG, SMALL, STATES, short

Built = Callable[..., ModuleType]

FED = Structure(3, "free", "uniform", ENDS, LAWS, states=STATES)


@pytest.mark.compiler
@pytest.mark.parametrize("structure", [*SMALL[:4], SMALL[6], *LONG[1:3], FED], ids=short)
@pytest.mark.parametrize("count", [1, 2, 11])
def test_tangents_are_products_with_the_jacobian(
    built: Built, point: type, structure: Structure, count: int
) -> None:
    """One direction, which has a function of its own, a few, and more than there are lanes; each
    row to the rounding of its terms. What comes out does not depend on the directions beside."""
    at = point(built(structure, "numpy"))
    v = np.random.default_rng(count).standard_normal((count, len(at.y)))
    J = at.module.jac(at.t, at.y, at.p)
    exact = v @ J.T
    np.testing.assert_array_equal(at.module.tangents(at.t, at.y, at.p, v), exact)
    compiled = built(structure, "c")
    got = compiled.tangents(at.t, at.y, at.p, v)
    size = np.abs(v) @ np.abs(J).T
    floor = 1e-3 * size.max(axis=1, keepdims=True)  # zeros hold the rounding of what cancels
    assert np.max(np.abs(got - exact) / np.maximum(size, floor)) < 1e-10
    np.testing.assert_array_equal(got[:2], compiled.tangents(at.t, at.y, at.p, v[:2]))


@pytest.mark.compiler
def test_directions_of_other_shapes_are_refused(built: Built, point: type) -> None:
    for target in ("numpy", "c"):
        at = point(built(SMALL[3], target))
        for wrong in (np.ones(3), np.ones(len(at.y)), np.ones((2, 3)), np.ones((1, 1, len(at.y)))):
            with pytest.raises(ValueError, match="has shape"):
                at.module.tangents(at.t, at.y, at.p, wrong)
        empty = np.empty((0, len(at.y)))
        assert at.module.tangents(at.t, at.y, at.p, empty).shape == empty.shape


@pytest.mark.compiler
def test_state_that_is_not_finite_has_none(built: Built, point: type) -> None:
    at = point(built(SMALL[2], "c"))
    at.y[0] = np.nan
    assert not np.isfinite(at.module.tangents(at.t, at.y, at.p, np.eye(len(at.y)))).all()
