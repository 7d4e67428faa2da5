"""Richardson extrapolation of sequences whose limit and expansion are known."""

from __future__ import annotations

from dataclasses import replace
from math import e, inf, isnan, pi, sin

import numpy as np
import pytest

from rodgen.analyse.extrapolation import richardson
from rodgen.errors import AnalysisError, DoubtWarning
from tests.analyse.rods import rod

N = (4, 6, 9, 13, 20, 31)


def _polygon(n: int) -> float:
    """Half the length of a polygon of n sides in the unit circle: pi, and even powers of 1/n."""
    return n * sin(pi / n)


def _compound(n: int) -> float:
    """Tends to e with all powers of 1/n."""
    return (1 + 1 / n) ** n


def _trapezoid(n: int) -> float:
    """Integral of sqrt(x) over (0, 1) by the trapezoidal rule: 2/3, and powers 3/2, 2, 4 of 1/n
    (Euler-Maclaurin of Lyness and Ninham, Math. Comp. 21 (1967) 162-178)."""
    x = np.sqrt(np.arange(n + 1) / n)
    return float((x.sum() - (x[0] + x[-1]) / 2) / n)


def test_scenes_in_place_of_their_numbers_of_links() -> None:
    """Rods whose damping does not go with the number of links are told of."""
    one = rod(10, "free", {"internal_damping": {"coefficient": 0.5}})
    scenes = [one.with_links(n) for n in (10, 20, 40)]
    values = [_polygon(scene.rod.links) for scene in scenes]
    expected = richardson((10, 20, 40), values)
    assert richardson(scenes, values) == expected
    unlike = [scene.model_copy(update={"loads": one.loads}) for scene in scenes]
    with pytest.warns(DoubtWarning, match=r"loads\.internal_damping\.coefficient"):
        found = richardson(unlike, values)
    assert replace(found, notes=()) == expected
    assert [note.kind for note in found.notes] == ["doubt"]


@pytest.mark.parametrize(
    ("sequence", "limit", "order", "step", "digits"),
    [(_polygon, pi, 2, 2, 1e-9), (_compound, e, 1, 1, 1e-5)],
)
def test_table_over_any_n(sequence, limit, order, step, digits) -> None:
    n = [int(k) for k in np.array(N) * (1 if order == 2 else 2)]
    found = richardson(n, [sequence(k) for k in n])
    assert found.order == order
    assert found.orders[-1] == pytest.approx(order, abs=0.1)
    assert np.all(np.diff(found.exponents) == step)
    assert abs(found.value - limit) < found.error
    assert abs(found.value - limit) < digits
    # The sequence of the values in the call is nobody's business.
    assert richardson(n[::-1], [sequence(k) for k in n[::-1]]) == found


def test_error_is_estimated_from_any_number_of_values() -> None:
    coarse, fine = _polygon(10), _polygon(20)  # by hand, of two
    found = richardson((10, 20), (coarse, fine), order=2)
    assert found.value == pytest.approx((4 * fine - coarse) / 3, rel=1e-15)
    assert abs(found.value - pi) < found.error
    for m in (3, 4, 5, 6):
        for sequence, limit in ((_polygon, pi), (_compound, e), (_trapezoid, 2 / 3)):
            n = [2 * k for k in N[-m:]]
            found = richardson(n, [sequence(k) for k in n])
            assert abs(found.value - limit) < found.error
            # Better than the finest value, by how much depends on whether the order is whole.
            share = 1.5 if sequence is _trapezoid else 0.3
            assert found.error < share * abs(sequence(n[-1]) - limit)


def test_fractional_order() -> None:
    n = (20, 40, 80, 160)
    values = [_trapezoid(k) for k in n]
    found = richardson(n, values)
    assert found.order == pytest.approx(1.5, abs=0.06)
    known = richardson(n, values, order=(1.5, 2, 4))
    assert known.exponents == (1.5, 2.0, 4.0)
    assert abs(known.value - 2 / 3) < min(known.error, 1e-9)


def test_observed_order_is_exact_for_one_term() -> None:
    """n of no common ratio; v = 3 + 2 n^-p."""
    for p in (0.5, 1.0, 2.0, 3.7):
        values = [3 + 2 * n**-p for n in (5, 7, 11, 24)]
        np.testing.assert_allclose(richardson((5, 7, 11, 24), values).orders, p, rtol=1e-9)


def test_noise_is_not_extrapolated() -> None:
    """Values with an error of 1e-6: terms whose elimination amplifies it are left in, and the
    estimate holds with few exceptions, as the noise may exceed what is stated."""
    random = np.random.default_rng(5)
    hits = 0
    for _ in range(200):
        values = [_polygon(n) + 1e-6 * random.standard_normal() for n in N]
        found = richardson(N, values, order=(2, 4, 6, 8, 10), noise=2e-6)
        hits += abs(found.value - pi) < found.error
    assert hits > 190
    assert found.error < 1e-4


def test_values_that_do_not_change() -> None:
    found = richardson((5, 10, 20), (2.0, 2.0, 2.0))
    assert (found.value, found.order) == (2.0, inf)
    assert 0 < found.error < 1e-14
    assert isnan(found.orders[0])


@pytest.mark.parametrize(
    "values", [(1.0, 2.0, 1.0), (1.0, 2.0, 4.0), (1.0, 2.0, 3.0), (0.0, 1e-3, 1.0)]
)
def test_divergence_is_told(values: tuple[float, ...]) -> None:
    with pytest.raises(AnalysisError):
        richardson((10, 20, 40), values)


def test_terms_of_odd_and_even_order() -> None:
    """(1 - 1/n)^-2 - 3 n^-2 + n^-4 hides its term of second order: after an odd order none is
    skipped, and the error must allow for it. An odd term after an even order is seen."""
    for n in ((5, 10, 20, 40), (10, 20, 40, 80), (20, 40, 80, 160)):
        found = richardson(n, [(1 - 1 / k) ** -2 - 3 / k**2 + k**-4 for k in n])
        assert abs(found.value - 1) <= found.error
    found = richardson(n, [1 + k**-2.0 + k**-3.0 for k in n])
    assert found.exponents[:2] == (2.0, 3.0)
    assert found.value == pytest.approx(1.0, abs=1e-12)
