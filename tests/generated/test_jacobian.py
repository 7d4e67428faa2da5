"""Analytic Jacobians against differences of the closed form in 50 digits."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene.structure import Structure
from tests.palette import SHORT_RODS, cases

Built = Callable[..., ModuleType]


def _holds(point: Any) -> None:
    """Every row to 1e-9 of its largest entry."""
    exact = point.exact_jacobian()
    got = point.module.jac(point.t, point.y, point.p)
    assert got.shape == exact.shape
    largest = np.abs(exact).max(axis=1, keepdims=True)
    # Rows of zeros (nothing turns one free link) hold the rounding of terms that cancel.
    floor = 1e-5 * np.abs(exact).max()
    off = np.abs(got - exact) / np.maximum(largest, floor)
    assert off.max() < 1e-9


@SHORT_RODS
def test_jacobian_is_that_of_the_closed_form(
    built: Built, point: type, boundary: str, links: int, inertia: str, terms: tuple[str, ...]
) -> None:
    _holds(point(built(Structure(links, boundary, inertia, terms))))


@cases("boundary, inertia, term", BOUNDARIES, INERTIAS, TERMS)
def test_jacobian_of_every_load(
    built: Built, point: type, boundary: str, inertia: str, term: str
) -> None:
    _holds(point(built(Structure(3, boundary, inertia, (term,)))))


@pytest.mark.parametrize(("boundary", "links"), [("pinned", 5), ("cantilever", 3)])
def test_dense_form_has_the_same_jacobian(
    built: Built, point: type, boundary: str, links: int
) -> None:
    structure = Structure(links, boundary, terms=TERMS)
    at = point(built(structure))
    dense = built(structure, "numpy", "dense")
    np.testing.assert_array_equal(dense.jac(at.t, at.y, at.p), at.module.jac(at.t, at.y, at.p))


def test_state_of_rest_has_a_jacobian(built: Built) -> None:
    """External damping is not smooth at rest: its derivative there is taken as zero."""
    rod = built(Structure(3, terms=TERMS))
    p = rod.parameters(
        mass=3.0,
        length=2.0,
        bending_stiffness=30.0,
        follower_force=1.0,
        internal_damping=0.1,
        material_damping_time=0.01,
        external_damping=9.0,
        distributed_follower=[1.0] * 3,
    )
    J = rod.jac(0.0, np.zeros(10), p)
    assert np.isfinite(J).all()
    p_still = p.copy()
    p_still[rod.PARAMETERS.index("external_damping")] = 0.0
    np.testing.assert_allclose(J, rod.jac(0.0, np.zeros(10), p_still), atol=1e-12)


def test_differences_see_a_wrong_jacobian(built: Built, point: type) -> None:
    at = point(built(Structure(3, terms=())))

    class Wrong:
        @staticmethod
        def jac(t: float, y: np.ndarray, p: np.ndarray) -> np.ndarray:
            J = right.jac(t, y, p)
            J[7, 3] *= 1 + 1e-8
            return J

    right, at.module = at.module, Wrong
    at.exact_jacobian = _kept(right, at)
    with pytest.raises(AssertionError):
        _holds(at)


def _kept(module: ModuleType, point: Any) -> Callable[[], np.ndarray]:
    wrong, point.module = point.module, module
    exact = type(point).exact_jacobian(point)
    point.module = wrong
    return lambda: exact
