"""The C target: against 50-digit arithmetic, against NumPy, and with what it is given."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from types import ModuleType

import numpy as np
import pytest

from rodgen.check.module import check_module
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene.structure import Structure
from tests.palette import LONG, PALETTE, SMALL, TIMED, short

pytestmark = pytest.mark.compiler
Built = Callable[..., ModuleType]


def test_every_choice_is_among_the_structures() -> None:
    assert {(s.boundary, s.inertia) for s in PALETTE} == {*product(BOUNDARIES, INERTIAS)}
    assert {(term, term in s.terms) for s in SMALL for term in TERMS} == {*product(TERMS, (0, 1))}
    assert {s.links for s in SMALL} >= {1, 2, 3}
    assert {s.inertia for s in LONG} == set(INERTIAS)


def _some(few: int, structures: tuple[Structure, ...]) -> pytest.MarkDecorator:
    """Parametrize by structures, of which all but a few are long."""
    rest = [pytest.param(each, marks=pytest.mark.nightly) for each in structures[few:]]
    return pytest.mark.parametrize("structure", [*structures[:few], *rest], ids=short)


@_some(3, (SMALL[6], SMALL[3], LONG[0], *LONG[1:], *SMALL[:3], *SMALL[4:6], SMALL[7]))
def test_module_equals_fifty_digit_arithmetic(built: Built, structure: Structure) -> None:
    # Rounding of some hundred operations, amplified by the condition of M: about 20 at n = 5, it
    # grows as n^3, to 6e4 at n = 50.
    worst = max(d.error for d in check_module(built(structure, "c"), states=1))
    assert worst < 1e-13 * (structure.links**1.5 if structure.links > 5 else 1)


@pytest.mark.parametrize("structure", [*PALETTE, TIMED], ids=short)
def test_targets_agree(
    built: Built, point: type, structure: Structure, request: pytest.FixtureRequest
) -> None:
    """Rates and Jacobians, which NumPy's modules hold against 50 digits; all else is one text."""
    if structure in LONG:
        request.getfixturevalue("flags_of_users")
    at, numpy = point(built(structure, "c"), 7), built(structure)
    for function, digits in (("rhs", 1e-10), ("jac", 1e-9)):
        one = getattr(at.module, function)(at.t, at.y, at.p)
        two = getattr(numpy, function)(at.t, at.y, at.p)
        # Condition of M at n = 50 (6e4) times rounding; less for shorter rods.
        limit = digits * min(1.0, (structure.links / 20) ** 3 + 1e-2)
        np.testing.assert_allclose(one, two, rtol=0, atol=limit * np.abs(two).max())


# Many states ------------------------------------------------------------------------------------


@pytest.mark.usefixtures("flags_of_users")
@pytest.mark.parametrize("structure", [SMALL[0], SMALL[2], SMALL[6], LONG[1], TIMED], ids=short)
def test_batch_is_row_by_row(built: Built, point: type, structure: Structure) -> None:
    """With no row, one, and around whole blocks of eight; with p for all and for each."""
    rod, p = built(structure, "c"), point(built(structure, "c")).p
    for count, shared in product((0, 1, 7, 8, 9, 21), (True, False)):
        draw = np.random.default_rng(count)
        Y = draw.standard_normal((count, len(rod.STATE)))
        P = p if shared else p * draw.uniform(0.5, 2.0, (count, len(p)))
        rates = rod.rhs_batch(0.3, Y, P)
        one = [rod.rhs(0.3, y, p if shared else P[row]) for row, y in enumerate(Y)]
        expected = np.reshape(one, Y.shape)
        # One rod at a time is eliminated in another order: rounding times the condition of M.
        limit = 1e-11 * np.abs(expected).max(initial=0)
        np.testing.assert_allclose(rates, expected, rtol=0, atol=limit, err_msg=f"{count} rows")
        out = np.full_like(Y, np.nan)
        assert rod.rhs_batch(0.3, Y, P, out) is out
        np.testing.assert_array_equal(out, rates)


def test_rod_of_a_batch_does_not_see_its_neighbours(built: Built, point: type) -> None:
    rod = built(LONG[1], "c")
    Y = np.random.default_rng(1).standard_normal((11, len(rod.STATE)))
    p = point(rod).p
    before = rod.rhs_batch(0.0, Y, p)
    Y[4] = np.nan
    after = rod.rhs_batch(0.0, Y, p)
    assert np.isnan(after[4]).any()
    others = np.arange(11) != 4
    np.testing.assert_array_equal(after[others], before[others])


def test_batches_that_are_none_are_refused(built: Built, point: type) -> None:
    rod = built(SMALL[4], "c")
    p, size = point(rod).p, len(rod.STATE)
    Y = np.zeros((3, size))
    for wrong in (np.zeros(size), np.zeros((3, size + 1)), np.zeros((2, 3, size))):
        with pytest.raises(ValueError, match="Y has shape"):
            rod.rhs_batch(0.0, wrong, p)
    for wrong in (p[:-1], np.tile(p, (2, 1)), np.tile(p, (3, 2))):
        with pytest.raises(ValueError, match="P has shape"):
            rod.rhs_batch(0.0, Y, wrong)
    with pytest.raises(ValueError, match="shares memory"):
        rod.rhs_batch(0.0, Y, p, Y)
    with pytest.raises(TypeError, match="Y has dtype complex"):
        rod.rhs_batch(0.0, Y.astype(complex), p)


# What comes in and where it goes ----------------------------------------------------------------


@pytest.fixture(scope="module")
def rod(built: Built) -> ModuleType:
    return built(LONG[1], "c")


def test_threads_do_not_disturb_each_other(rod: ModuleType, point: type) -> None:
    """cffi lets go of the interpreter: two calls run at the same time."""
    at = point(rod)
    states = np.random.default_rng(5).standard_normal((2, len(at.y)))
    expected = [rod.rhs(0.0, y, at.p) for y in states]
    jacobians = [rod.jac(0.0, y, at.p) for y in states]

    def work(which: int) -> bool:
        y = states[which]
        same = all(np.array_equal(rod.rhs(0.0, y, at.p), expected[which]) for _ in range(5000))
        return same and all(
            np.array_equal(rod.jac(0.0, y, at.p), jacobians[which]) for _ in range(100)
        )

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, [0, 1, 0, 1]))


@pytest.mark.parametrize("angle", [1e16, -1e16, 1e300])
def test_angles_without_digits_after_the_point_give_no_numbers(
    rod: ModuleType, point: type, angle: float
) -> None:
    at = point(rod)
    at.y[2] = angle
    assert np.isnan(rod.rhs(0.0, at.y, at.p)).any()
