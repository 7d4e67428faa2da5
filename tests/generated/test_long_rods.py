"""C modules of rods that differ along their length or follow their motion, long enough for joint
forces that are cut into segments."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest

from rodgen.check.module import _drawn, check_module
from rodgen.scene.structure import Structure
from tests.agreement import differences
from tests.palette import ALONG, ENDS, LAWS, STATES, short

Built = Callable[..., ModuleType]
STRUCTURES = (
    Structure(12, "free", "uniform", ALONG, uneven=("stiffness", "bodies")),
    Structure(12, "clamped", "uniform", ENDS, uneven=("bodies",)),
    Structure(12, "cantilever", "uniform", ALONG, uneven=("stiffness", "mass")),
    Structure(12, "free", "lumped", ENDS, uneven=("points",)),
    Structure(12, "free", "uniform", (*ENDS, "drag"), LAWS, states=STATES),
    Structure(3, "cantilever", "lumped", ENDS, LAWS, states=STATES),
)
EACH = pytest.mark.parametrize("structure", STRUCTURES, ids=short)


@EACH
def test_module_equals_fifty_digit_arithmetic(built: Built, structure: Structure) -> None:
    # Rounding of some hundred operations, amplified by the condition of M.
    assert max(d.error for d in check_module(built(structure, "c"), states=2)) < 1e-12


@pytest.mark.nightly
@EACH
def test_jacobians_are_derivatives_of_the_rates(built: Built, structure: Structure) -> None:
    one, other = built(structure), built(structure, "c")
    values, y = _drawn(one, 0.3, np.random.default_rng(2), 0.5, 0.5)
    p = one.parameters(**values)
    J = one.jac(0.3, y, p)
    # Both follow from the same tangents, by different eliminations.
    np.testing.assert_allclose(other.jac(0.3, y, p), J, rtol=0, atol=1e-11 * np.abs(J).max())
    wrong = np.abs(differences(one.rhs, 0.3, y, p) - J)
    # Row by row, as those of the added states are smaller; the square of the step, and rounding.
    assert (wrong <= 1e-6 * np.abs(J).max(axis=1, keepdims=True) + 1e-7).all()


@pytest.mark.nightly
@EACH
def test_batches_are_single_rods(built: Built, structure: Structure) -> None:
    module, draw = built(structure, "c"), np.random.default_rng(1)
    pairs = [_drawn(module, 0.2, draw, 0.5, 0.5) for _ in range(9)]
    P = np.array([module.parameters(**values) for values, _ in pairs])
    Y = np.array([y for _, y in pairs])
    single = [module.rhs(0.2, y, p) for y, p in zip(Y, P, strict=True)]
    # Other orders of the same sums.
    many = module.rhs_batch(0.2, Y, P)
    np.testing.assert_allclose(many, single, rtol=1e-9, atol=1e-11 * np.abs(single).max())
