"""Continuation of curves whose points, folds and branch points are known in closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.sparse import csc_array

from rodgen.analyse.bordered import BorderedMatrix, Matrix
from rodgen.analyse.curves.continuation import continue_curve
from rodgen.analyse.curves.curve import (
    BRANCH,
    FOLD,
    ContinuationProblem,
    Curve,
    CurvePoint,
    start_point,
)
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from tests.told import numbers

Equations = Callable[[Array], tuple[list[float], list[list[float]]]]


class Known(ContinuationProblem):
    """Equations with their derivatives, dense or sparse."""

    def __init__(self, equations: Equations, size: int, sparse: bool = False):
        self.weights, self.equations, self.sparse = np.ones(size), equations, sparse

    def evaluate(self, u: Array) -> tuple[Array, Matrix]:
        F, J = map(np.array, self.equations(u))
        return F, csc_array(J) if self.sparse else J


def followed(
    problem: ContinuationProblem, u: list[float], low: float, high: float, way: float = 1.0
) -> Curve:
    return continue_curve(problem, start_point(problem, np.array(u), way), low, high)


def ellipse(u: Array) -> tuple[list[float], list[list[float]]]:
    return [u[0] ** 2 + 4 * u[1] ** 2 - 1], [[2 * u[0], 8 * u[1]]]


def test_a_closed_curve_is_gone_round_once_with_both_folds() -> None:
    found = followed(Known(ellipse, 2), [1.0, 0.0], -5, 5)
    assert found.complete
    assert [one.kind for one in found.special] == [FOLD, FOLD]
    np.testing.assert_allclose([one.u[-1] for one in found.special], [0.5, -0.5], atol=1e-12)
    angles = np.unwrap([np.arctan2(2 * p.u[1], p.u[0]) for p in found.points])
    assert angles[-1] - angles[0] == pytest.approx(2 * np.pi)


def test_a_curve_ends_at_the_end_of_its_range_wherever_its_steps_lead() -> None:
    """Also where a step is aimed at a point within, as the curve is bent, and found beyond."""

    def bent(u: Array) -> tuple[list[float], list[list[float]]]:
        return [u[1] - np.exp(u[0])], [[-np.exp(u[0]), 1.0]]

    whole = followed(Known(bent, 2), [0.0, 1.0], 0.5, 2.0)
    for point in whole.points[3:]:
        high = point.value - 1e-5  # a step's bend is a hundred times that
        found = followed(Known(bent, 2), [0.0, 1.0], 0.5, high)
        assert found.complete
        assert found.points[-1].value == high
        assert max(point.value for point in found.points) == high


def pitchfork(offset: float) -> Equations:
    """l x - x^3 = offset, with another unknown that bends the branch where nothing happens."""

    def equations(u: Array) -> tuple[list[float], list[list[float]]]:
        x, y, l = u
        F = [l * x - x**3 - offset, y - np.sin(l)]
        return F, [[l - 3 * x * x, 0.0, x], [0.0, 1.0, -np.cos(l)]]

    return equations


@pytest.mark.parametrize("sparse", [False, True])
def test_both_branches_through_a_simple_branch_point(sparse: bool) -> None:
    problem = Known(pitchfork(0.0), 3, sparse)
    trivial = followed(problem, [0.0, np.sin(-1.3), -1.3], -1.3, 1.0)
    assert trivial.points[-1].value == 1.0
    (special,) = trivial.special
    assert special.kind == BRANCH
    np.testing.assert_allclose(special.u, 0.0, atol=1e-10)
    before, after = (trivial.points[special.after + at].value for at in (0, 1))
    assert before < 0 < after
    assert special.ways is not None
    other = CurvePoint(special.u, special.ways[1], None, 0)
    for sign in (1.0, -1.0):
        start = other._replace(tangent=sign * other.tangent)
        bent = continue_curve(problem, start, -1.3, 1.0)
        last = bent.points[-1].u
        assert last[2] == 1.0
        assert abs(last[0]) == pytest.approx(1.0, abs=1e-12)
        assert last[0] * start.tangent[0] > 0


def test_a_branch_point_that_is_none_is_a_fold_beside_another_branch() -> None:
    """With an imperfection e the lower branch turns back at l = 3 (e/2)^(2/3), and is not left for
    the other, which passes close by."""
    e = 1e-4
    found = followed(Known(pitchfork(e), 3), [1.0, np.sin(1.0), 1.0], -2.0, 1.0, way=-1.0)
    assert [one.kind for one in found.special] == [FOLD]
    assert found.special[0].u[-1] == pytest.approx(3 * (e / 2) ** (2 / 3), abs=1e-10)
    assert found.points[-1].u[0] == pytest.approx(e, rel=1e-3)


def test_where_a_curve_ends_what_was_found_is_kept() -> None:
    def equations(u: Array) -> tuple[list[float], list[list[float]]]:
        if u[1] > 0.5:
            raise AnalysisError("nothing is there")
        return [u[0] - u[1] ** 2], [[1.0, -2 * u[1]]]

    found = followed(Known(equations, 2), [0.0, 0.0], 0, 1)
    assert not found.complete
    assert "nothing is there" in found.end  # what the equations said
    assert found.points[-1].value == pytest.approx(0.5, abs=1e-6)


def test_an_unexplained_change_of_stability_is_said() -> None:
    class Unstable(Known):
        def count_unstable(self, u: Array) -> int:
            return 3 * int(u[-1] > 0.25)

    found = followed(Unstable(lambda u: ([u[0]], [[1.0, 0.0]]), 2), [0.0, 0.0], 0, 1)
    assert found.complete
    (note,) = found.notes
    assert {0.0, 3.0, 0.25} <= {round(one, 2) for one in numbers(note)}


@pytest.mark.parametrize("sparse", [False, True])
def test_the_sign_of_a_determinant(sparse: bool) -> None:
    random = np.random.default_rng(7)
    for _ in range(20):
        whole = random.normal(size=(6, 6))
        J = csc_array(whole[:5]) if sparse else whole[:5]
        made = BorderedMatrix(J, whole[5:])
        assert made.determinant_sign == np.sign(np.linalg.det(whole))
        right = random.normal(size=6)
        np.testing.assert_allclose(made.solve(right, True), np.linalg.solve(whole.T, right))
