"""Observed orders from rows of work-precision sets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from rodgen.judge.unit import Row

FLOOR, CEILING = 1e-12, 0.1  # errors between which an order shows: above rounding, below chaos
LEAST, MOST = 3, 5  # points of a fit: the tightest
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

    @property
    def order(self) -> float | None:
        """Of the method; None where the quantity has nothing to do with it."""
        return {"step": self.exponent, "rhs": -self.exponent}.get(self.against)


def families(rows: Iterable[Row]) -> Iterator[list[Row]]:
    """Rows by scene, who, method, target and kind of setting, in the order of settings: loose to
    tight."""
    for _, group in groupby(sorted(rows, key=_key), key=_key):
        yield sorted(group, key=lambda row: -_value(row, "setting"))


def fits(rows: Iterable[Row], measure: str = "error_phi", floor: float = FLOOR) -> list[Fit]:
    """One for every family of fixed steps, two for every adaptive one, where there are enough
    points with errors above the floor."""
    found: list[Fit] = []
    for family in families(rows):
        for against in ("step",) if family[0].get("kind") == "step" else ("rhs", "rtol"):
            one = fit(family, measure, against, floor)
            found += [one] if one else []
    return found


def fit(family: list[Row], measure: str, against: str, floor: float = FLOOR) -> Fit | None:
    """Least squares in logarithms over the tightest points of a family, or None."""
    quantity = "rhs" if against == "rhs" else "setting"
    points = [
        (_value(row, quantity), _value(row, measure))
        for row in family
        if not row.get("failed")
        and floor < _value(row, measure) < CEILING
        and _value(row, quantity) > 0
    ][-MOST:]
    if len({x for x, _ in points}) < LEAST:
        return None
    x, y = np.log(np.array(points)).T
    exponent = float(np.polyfit(x, y, 1)[0])
    first = family[0]
    names = {key: str(first[key]) for key in ("scene", "who", "method", "target")}
    nominal = first.get("order")
    order = float(nominal) if isinstance(nominal, int | float) else None
    return Fit(
        **names,
        measure=measure,
        against=against,
        exponent=exponent,
        nominal=order,
        points=len(points),
    )


def _key(row: Row) -> tuple[str, ...]:
    return tuple(str(row.get(key)) for key in KEYS)


def _value(row: Row, name: str) -> float:
    """A number of a row; not-a-number where it has none."""
    value = row.get(name)
    return float(value) if isinstance(value, int | float) else float("nan")
