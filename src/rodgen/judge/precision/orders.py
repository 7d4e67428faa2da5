"""Observed orders from rows of work-precision sets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from math import inf, log

import numpy as np

from rodgen.judge.unit import Row

FLOOR, CEILING = 1e-12, 0.1  # errors between which an order shows: above rounding, below chaos
LEAST = 3  # points of a fit
# How far slopes from setting to setting may be apart in what counts as asymptotic. Evaluations of
# adaptive methods follow their errors in whole steps only, to an exponent of up to 8.
ALIKE = {"step": 0.3, "rtol": 0.3, "rhs": 1.0}
Points = list[tuple[float, float]]  # logarithms of quantity and error
KEYS = ("scene", "who", "method", "target", "kind")


@dataclass(frozen=True)
class Fit:
    """error ~ C quantity^exponent over so many points, of a family and a measure.

    against: "step", of which the exponent is the order of the method; of adaptive methods "rhs",
    of which it is minus the order where steps follow the error alone (and none where they are
    held at the stability limit), or "rtol", of which it is 1 for error control that is in
    proportion.
    """

    scene: str
    who: str
    method: str
    target: str
    measure: str
    against: str
    exponent: float
    nominal: float | None
    points: int
    finest: float | None  # exponent by the two smallest steps alone

    @property
    def order(self) -> float | None:
        """Of the method; None where the quantity has nothing to do with it."""
        return {"step": self.exponent, "rhs": -self.exponent}.get(self.against)


@dataclass(frozen=True)
class NoFit:
    """Why no exponent is seen in a family; points: with errors between floor and ceiling."""

    scene: str
    who: str
    method: str
    target: str
    measure: str
    against: str
    nominal: float | None
    points: int
    finest: float | None
    why: str


def families(rows: Iterable[Row]) -> Iterator[list[Row]]:
    """Rows by scene, who, method, target and kind of setting, in the order of settings: loose to
    tight."""
    for _, group in groupby(sorted(rows, key=_key), key=_key):
        yield _ordered(group)


def fits(rows: Iterable[Row], measure: str = "error_phi", floor: float = FLOOR) -> list[Fit]:
    """One for every family of fixed steps, two for every adaptive one, where slopes are steady.

    floor: errors above which slopes are those of the method: ten times the reference's own, say.
    """
    return [one for one in looked_at(rows, measure, floor) if isinstance(one, Fit)]


def unfitted(rows: Iterable[Row], measure: str = "error_phi", floor: float = FLOOR) -> list[NoFit]:
    """What `fits` leaves out of families with settings that did not fail."""
    return [one for one in looked_at(rows, measure, floor) if isinstance(one, NoFit)]


def looked_at(rows: Iterable[Row], measure: str, floor: float) -> Iterator[Fit | NoFit]:
    """Every family of which a setting did not fail."""
    for family in families(rows):
        if all(row.get("failed") for row in family):
            continue
        for against in ("step",) if family[0].get("kind") == "step" else ("rhs", "rtol"):
            yield fit(family, measure, against, floor)


def fit(family: list[Row], measure: str, against: str, floor: float = FLOOR) -> Fit | NoFit:
    """Least squares in logarithms over the longest run of neighbouring settings between which
    slopes are alike; of runs as long as each other, over the tightest."""
    runs = list(_between(family, measure, against, floor))
    points = sum(map(len, runs))
    best: Points = max((_steady(run, ALIKE[against]) for run in runs), key=len, default=[])
    first = family[0]
    names = {key: str(first[key]) for key in ("scene", "who", "method", "target")}
    nominal = first.get("order")
    order = float(nominal) if isinstance(nominal, int | float) else None
    last = finest(family, measure, floor) if against == "step" else None
    if len(best) < LEAST:
        why = "not asymptotic in the steps tried" if against == "step" else "no steady slope"
        if points < LEAST:
            why = f"less than {LEAST} errors between {floor:.1e} and {CEILING:g}"
        return NoFit(
            **names,
            measure=measure,
            against=against,
            nominal=order,
            points=points,
            finest=last,
            why=why,
        )
    x, y = np.array(best).T
    exponent = float(np.polyfit(x, y, 1)[0])
    return Fit(
        **names,
        measure=measure,
        against=against,
        exponent=exponent,
        nominal=order,
        points=len(best),
        finest=last,
    )


def finest(family: Sequence[Row], measure: str, floor: float = FLOOR) -> float | None:
    """Exponent of the error by the two smallest steps whose errors show one, or None."""
    points = next((run for run in _between(_ordered(family), measure, "step", floor)), [])
    if len(points) < 2:
        return None
    (x, y), (other, above) = points[:2]
    return (above - y) / (other - x)


def _ordered(family: Iterable[Row]) -> list[Row]:
    """From loose to tight."""
    return sorted(family, key=lambda row: -_value(row, "setting"))


def _between(family: list[Row], measure: str, against: str, floor: float) -> Iterator[Points]:
    """Runs of neighbouring settings with errors between floor and ceiling, tightest run first."""
    quantity = "rhs" if against == "rhs" else "setting"
    run: Points = []
    for row in reversed(family):
        x, y = _value(row, quantity), _value(row, measure)
        if not row.get("failed") and x > 0 and floor < y < CEILING:
            run.append((log(x), log(y)))
        elif run:
            yield run
            run = []
    if run:
        yield run


def _steady(run: Points, alike: float) -> Points:
    """Its longest part in which slopes from point to point are alike, the first of several."""
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


def _key(row: Row) -> tuple[str, ...]:
    return tuple(str(row.get(key)) for key in KEYS)


def _value(row: Row, name: str) -> float:
    """A number of a row; not-a-number where it has none."""
    value = row.get(name)
    return float(value) if isinstance(value, int | float) else float("nan")
