"""Observed orders from rows of work-precision sets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from math import inf, log

import numpy as np

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import group_families, has_result, read_number

FLOOR, CEILING = 1e-12, 0.1  # errors between which an order shows: above rounding, below chaos
LEAST = 3  # points of a fit
# How far slopes from setting to setting may be apart in what counts as asymptotic. Evaluations of
# adaptive methods follow their errors in whole steps only, to an exponent of up to 8.
ALIKE = {"step": 0.3, "rtol": 0.3, "rhs": 1.0}
# By what the exponent is the order of the method: minus one where steps follow the error alone (and
# none where they are held at the stability limit).
SIGNS = {"step": 1, "rhs": -1}
Points = list[tuple[float, float]]  # logarithms of quantity and error


def looked_at(rows: Iterable[Measurement], floor: float = FLOOR) -> Iterator[Measurement]:
    """One for every family of fixed steps, two for every adaptive one, of which a setting did not
    fail.

    floor: errors above which slopes are those of the method: ten times the reference's own, say.
    """
    for family in group_families(rows):
        if any(map(has_result, family)):
            for against in ("step",) if family[0].get("kind") == "step" else ("rhs", "rtol"):
                yield fit(family, against, floor)


def fit(family: list[Measurement], against: str, floor: float = FLOOR) -> Measurement:
    """error ~ C quantity^exponent, by least squares in logarithms over the longest run of
    neighbouring settings between which slopes are alike; of runs as long as each other, over the
    tightest. Or why no exponent is seen, with the number of errors between floor and ceiling.

    against: "step", of which the exponent is the order of the method; of adaptive methods "rhs",
    or "rtol", of which it is 1 for error control that is in proportion.
    """
    runs = list(_between(family, against, floor))
    points = sum(map(len, runs))
    best: Points = max((_steady(run, ALIKE[against]) for run in runs), key=len, default=[])
    exponent, why = None, ""
    if len(best) >= LEAST:
        x, y = np.array(best).T
        points, exponent = len(best), float(np.polyfit(x, y, 1)[0])
    elif points < LEAST:
        why = f"less than {LEAST} errors between {floor:.1e} and {CEILING:g}"
    else:
        why = "not asymptotic in the steps tried" if against == "step" else "no steady slope"
    sign = SIGNS.get(against)
    known = {key: family[0].get(key) for key in ("scene", "who", "method", "target", "order")}
    return known | {
        "against": against,
        "exponent": exponent,
        "observed": sign * exponent if sign and exponent is not None else None,
        "points": points,
        "finest": finest(family, floor) if against == "step" else None,
        "why": why,
    }


def finest(family: Iterable[Measurement], floor: float = FLOOR) -> float | None:
    """Exponent of the error by the two smallest steps whose errors show one, or None."""
    (ordered,) = group_families(family)
    points = next(_between(ordered, "step", floor), [])
    if len(points) < 2:
        return None
    (x, y), (other, above) = points[:2]
    return (above - y) / (other - x)


def _between(family: list[Measurement], against: str, floor: float) -> Iterator[Points]:
    """Runs of neighbouring settings with errors between floor and ceiling, tightest run first."""
    quantity = "nfev" if against == "rhs" else "setting"
    run: Points = []
    for row in reversed(family):
        x, y = read_number(row, quantity), read_number(row, "error_phi")
        if has_result(row) and x > 0 and floor < y < CEILING:
            run.append((log(x), log(y)))
        elif run:
            yield run
            run = []
    if run:
        yield run


def _steady(run: Points, alike: float) -> Points:
    """Longest part of a run in which slopes from point to point are alike, the first of several."""
    best: Points = []
    for start in range(len(run)):
        slopes: list[float] = []
        for (x, y), (other, above) in pairwise(run[start:]):
            slope = (above - y) / (other - x) if other != x else inf
            if not max([*slopes, slope]) - min([*slopes, slope]) <= alike:
                break
            slopes.append(slope)
        if slopes and len(slopes) + 1 > len(best):
            best = run[start : start + len(slopes) + 1]
    return best
