"""Richardson extrapolation over the number of links, with the order that the values show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.result import Note, Result, Row, doubt, warns_of_doubts
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_dependent_values
from rodgen.system import System

HIGHEST = 50.0  # order that is looked for
WHOLE = 0.15  # an observed order is taken for a whole number within this: by then the next term
# of an expansion in whole powers has become a small part of the leading one
SECOND = 0.4  # the same for the exponent after it, which is 1 or 2 more
SAFETY = 2.0  # the next term, which the estimate knows, is followed by others
SAME = 1e-9  # relative: what two ways to write one and the same damping differ by
ROUNDING = 4 * np.finfo(float).eps  # relative, of a value that is given


@dataclass(frozen=True, repr=False)
class Extrapolation(Result):
    """The limit of v(n) = v + C n^-p + ... for n to infinity.

    value: v, in units of the values; error: estimate of its absolute error, in units of v; order:
    p, dimensionless, inf if the values do not depend on n; orders: orders observed in successive
    triples of values, from coarse to fine, dimensionless, nan if rounding or a coarse grid hides
    them; exponents: of the terms that were eliminated, dimensionless; notes: doubts about damping
    that is not the same for every number of links.

    Examples
    --------
    >>> import rodgen
    >>> rodgen.richardson([10, 20, 40, 80], [1 + 3 / n**2 for n in (10, 20, 40, 80)]).order
    2.0
    """

    value: float
    error: float
    order: float
    orders: tuple[float, ...]
    exponents: tuple[float, ...]
    notes: tuple[Note, ...] = ()

    ROWS = (
        Row("value", "value", error="error"),
        Row("error", "error, estimated", format=".1e"),
        Row("order", "order", format=".4g"),
        Row("orders", "orders observed", format=".4g"),
        Row("exponents", "exponents eliminated", format=".4g"),
    )

    def __repr__(self) -> str:
        return f"<Extrapolation: {self.value:.12g} +- {self.error:.1e}, order {self.order:.4g}>"


@warns_of_doubts
def richardson(
    n: Sequence[float] | Sequence[System | Scene] | Array,
    values: Sequence[float] | Array,
    order: float | Sequence[float] | None = None,
    *,
    noise: float | None = None,
) -> Extrapolation:
    """Return the limit of values that were computed with several numbers of links.

    Terms of v(n) = v + C n^-p + ... are eliminated while this lowers the estimate of the error. The
    estimate is twice the change by the next term (by the last one, if there is no other), and
    the noise times its weights. Source: L. F. Richardson, Phil. Trans. A 226 (1927) 299-361; P. J.
    Roache, J. Fluids Eng. 116 (1994) 405-413.

    Parameters
    ----------
    n
        Numbers of links (m,), dimensionless, in any sequence, or the scenes or Systems
        themselves. Those whose damping is not the same give a doubt (see Scene.with_links).
    values
        The computed values (m,), in units of any kind.
    order
        The order p (dimensionless), if theory knows it, or all exponents, such as (2, 4, 6). By
        default p solves (v1 - v2) / (v2 - v3) = (n1^-p - n2^-p) / (n2^-p - n3^-p) for the three
        finest values, and is rounded if it is close to a whole number. The next exponents are p +
        1, p + 2, ..., or p + 2, p + 4, ... if p is even and four values or more show it.
    noise
        Absolute error of the values, in units of them. By default it is that of rounding.

    Returns
    -------
    Extrapolation
        The limit, an estimate of its error, and the order.

    Raises
    ------
    InputError
        For fewer than three values, or fewer than two if the order is given.
    AnalysisError
        If the finest values do not converge.

    Examples
    --------
    >>> import rodgen
    >>> n = [10, 20, 40, 80]
    >>> found = rodgen.richardson(n, [1 + 3 / k**2 - 2 / k**4 for k in n])
    >>> round(found.value, 9), found.order
    (1.0, 2.0)
    """
    links, notes = _link_counts(n)
    count, v = _check_values(links, values, 3 if order is None else 2)
    if noise is not None and not 0 <= noise < np.inf:
        raise InputError("noise", noise, "a finite number of at least 0")
    floor = max(noise or 0.0, ROUNDING * float(np.abs(v).max()))
    orders = tuple(
        _observed_order(count[i : i + 3], v[i : i + 3], floor) for i in range(len(v) - 2)
    )
    if np.ptp(v[-3:]) <= floor:
        return Extrapolation(float(v[-1]), floor, float("inf"), orders, (), notes)
    _check_convergence(count, v, orders, floor)
    if order is None and abs(orders[-1] - _nearest_whole_order(orders[-1])) > WHOLE:
        value, error = _fit_limit(count, v, orders)
        return Extrapolation(value, float(error + floor), orders[-1], orders, orders[-1:], notes)
    exponents = (
        _following_exponents(count, v, orders) if order is None else _check_order(order, len(v))
    )
    value, error, terms = _best_limit(count, v, exponents, floor)
    return Extrapolation(value, error, exponents[0], orders, exponents[:terms], notes)


def _link_counts(
    n: Sequence[float] | Sequence[System | Scene] | Array,
) -> tuple[Sequence[float] | Array, tuple[Note, ...]]:
    """Numbers of links, also of scenes, with the doubt about scenes of different damping."""
    scenes = [System.of(one).scene for one in n if isinstance(one, System | Scene)]
    if not scenes:
        return n, ()  # type: ignore[return-value]  # none is a scene, as no annotation tells
    if len(scenes) < len(n):
        raise InputError("n", [type(one).__name__ for one in n], "numbers, or scenes, not both")
    links = [one.rod.links for one in scenes]
    if not (unlike := find_unlike_damping(scenes)):
        return links, ()
    text = f"{' and '.join(unlike)}: not the same damping for every number of links"
    return links, (doubt(f"{text}; take Scene.with_links"),)


def find_unlike_damping(scenes: Sequence[Scene]) -> list[str]:
    """Fields by which scenes of different numbers of links do not have the damping of one and the
    same rod."""
    known = [
        {
            one.field: one.after_refinement(1 / s.rod.links) - one.even
            for one in mesh_dependent_values(s)
        }
        for s in scenes
    ]
    fields = dict.fromkeys(field for values in known for field in values)
    return [
        field
        for field in fields
        if any(
            not math.isclose(a.get(field, 0.0), b.get(field, 0.0), rel_tol=SAME)
            for a, b in pairwise(known)
        )
    ]


def _check_values(
    n: Sequence[float] | Array, values: Sequence[float] | Array, least: int
) -> tuple[Array, Array]:
    """Check numbers and values, and return them as arrays, with n rising."""
    count, v = np.asarray(n, dtype=float), np.asarray(values, dtype=float)
    if count.ndim != 1 or len(count) < least:
        raise InputError("n", count.tolist(), f"a list of at least {least} numbers")
    if v.shape != count.shape:
        raise InputError("values", v.tolist(), f"a list of {len(count)} numbers, one for each n")
    if not (np.isfinite(count).all() and (count > 0).all()):
        raise InputError("n", count.tolist(), "finite numbers greater than 0")
    if len(np.unique(count)) < len(count):
        raise InputError("n", count.tolist(), "numbers that all differ")
    if not np.isfinite(v).all():
        raise InputError("values", v.tolist(), "finite numbers")
    rising = np.argsort(count)
    return count[rising], v[rising]


def _observed_order(n: Array, v: Array, noise: float) -> float:
    """Observed order of three values; nan where they show none."""
    coarse, fine = v[0] - v[1], v[1] - v[2]
    if min(abs(coarse), abs(fine)) <= noise:
        return float("nan")
    a, b = np.log(n[1] / n[0]), np.log(n[2] / n[1])

    def excess(p: float) -> float:
        return float(np.expm1(p * a) / -np.expm1(-p * b) - coarse / fine)

    # The ratio of the differences rises with p, from a / b at 0.
    if excess(1e-9) >= 0 or excess(HIGHEST) <= 0:
        return float("nan")
    return float(brentq(excess, 1e-9, HIGHEST, xtol=1e-12))


def _check_convergence(n: Array, v: Array, orders: tuple[float, ...], noise: float) -> None:
    """Raise AnalysisError unless the finest three values show an order, or have come to rest."""
    if orders and np.isnan(orders[-1]) and abs(v[-1] - v[-2]) > noise:
        shown = ", ".join(f"{a:g}: {b:.10g}" for a, b in zip(n[-3:], v[-3:], strict=True))
        raise AnalysisError(
            f"the values do not converge like n^-p with 0 < p <= {HIGHEST:g} (n: value; {shown})"
        )


def _nearest_whole_order(p: float) -> float:
    return max(1.0, float(round(p))) if np.isfinite(p) else p


def _following_exponents(n: Array, v: Array, orders: tuple[float, ...]) -> tuple[float, ...]:
    """Exponents from the first, a whole number: all that follow, or, from an even one on, every
    second (a term that is small after an odd one by chance may still be there)."""
    first = _nearest_whole_order(orders[-1])
    even = len(v) > 3 and first % 2 == 0
    step = (
        2.0 if even and abs(_second_exponent(n[-4:], v[-4:], first) - first - 2) < SECOND else 1.0
    )
    return tuple(first + step * i for i in range(len(v)))


def _second_exponent(n: Array, v: Array, first: float) -> float:
    """Exponent of the second term for which four values have one limit; nan where none has."""

    def difference(q: float) -> float:
        return _limit(n, v, (first, q), 3) - _limit(n, v, (first, q), 2)

    low, high = first + 1 - SECOND, first + 4
    if difference(low) * difference(high) >= 0:
        return float("nan")
    return float(brentq(difference, low, high))


def _check_order(order: float | Sequence[float], most: int) -> tuple[float, ...]:
    exponents = np.atleast_1d(np.asarray(order, dtype=float))
    if exponents.ndim != 1 or not (np.isfinite(exponents).all() and (exponents > 0).all()):
        raise InputError("order", order, "a finite number greater than 0, or a list of such")
    if not (np.diff(exponents) > 0).all():
        raise InputError("order", order, "a list of rising numbers")
    return tuple(map(float, exponents[:most]))


def _fit_limit(n: Array, v: Array, orders: tuple[float, ...]) -> tuple[float, float]:
    """Limit with the observed order, and its error: the change by the order of the triple before,
    or without one by the nearest whole order."""
    last = len(v) - 1
    value = _limit(n, v, orders[-1:], last)
    if len(orders) > 1 and np.isfinite(orders[-2]):
        before = _limit(n, v, orders[-2:-1], last - 1)
        other = _limit(n, v, orders[-2:-1], last)
        return value, SAFETY * (abs(value - before) + abs(value - other))
    return value, SAFETY * abs(value - _limit(n, v, (_nearest_whole_order(orders[-1]),), last))


def _weights(n: Array, exponents: tuple[float, ...]) -> Array:
    """Weights (m,) of the values at n (m,) in the limit that eliminates m - 1 terms."""
    powers = np.array([(n / n[-1]) ** -p for p in (0.0, *exponents)])
    weights: Array = np.linalg.solve(powers, np.eye(len(n))[0])
    return weights


def _limit(n: Array, v: Array, exponents: tuple[float, ...], at: int) -> float:
    """Limit from value number ``at`` and those before it, one for each exponent."""
    used = slice(at - len(exponents), at + 1)
    return float(_weights(n[used], exponents) @ v[used])


def _best_limit(
    n: Array, v: Array, exponents: tuple[float, ...], noise: float
) -> tuple[float, float, int]:
    """Limit, error and number of eliminated terms for which the error is smallest."""
    # The exponent after the last one only serves the estimate of the error.
    all_of_them = (*exponents, exponents[-1] + 1)[: len(v) - 1]
    values = [_limit(n, v, all_of_them[:i], len(v) - 1) for i in range(len(all_of_them) + 1)]
    changes = np.abs(np.diff(values))
    best = (values[0], float("inf"), 0)
    for terms in range(1, min(len(exponents), len(v) - 1) + 1):
        weights = _weights(n[len(v) - terms - 1 :], exponents[:terms])
        truncation = SAFETY * changes[min(terms, len(changes) - 1)]
        error = float(truncation + noise * np.abs(weights).sum())
        # The last two have the same estimate but for the noise: then the one with more terms.
        if error <= 1.01 * best[1]:
            best = (values[terms], error, terms)
    return best
