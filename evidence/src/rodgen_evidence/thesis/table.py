"""A table of the thesis rebuilt: columns, rows, verdicts, and what was found about it."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pandas import DataFrame, Series

from rodgen_evidence.page_tables import Column, as_in
from rodgen_evidence.thesis.data import digits, unit

INCOMPARABLE = "not comparable"  # how the verdict on a row begins whose conditions are not known
SIZES = (0.01, 0.1, 1.0)  # %, between which deviations are counted: decades, fitted to no value


def column(key: str, title: str, unit: str = "", spec: str = "") -> Column:
    """Numbers as they are printed by a format, or texts and counts as they are."""
    return Column(key, f"{title} [{unit}]" if unit else title, as_in(spec))


LINKS, VERDICT = column("links", "links"), column("verdict", "verdict")


class Remark(NamedTuple):
    """status: shown, estimated (from run times measured over less and multiplied), refuted,
    consistent (fits, other reasons fit as well), open, or found."""

    status: str
    text: str


@dataclass
class ThesisTable:
    """number: of the thesis, or a name; conditions: as printed; assumed: where it is silent."""

    number: str
    title: str
    columns: tuple[Column, ...]
    rows: DataFrame
    conditions: list[str] = field(default_factory=list)
    assumed: list[str] = field(default_factory=list)
    notes: list[Remark] = field(default_factory=list)
    seconds: float = 0.0
    curve: list[tuple[float, float]] = field(default_factory=list)  # x, y [m] of a figure


def beside(rows: DataFrame, printed: Series[str], reason: str = "") -> DataFrame:
    """Rows of the discrete model with the printed numbers, their deviations and the verdicts."""
    thesis, exact = printed.astype(float), rows["discrete"]
    verdicts = [verdict(*pair, reason) for pair in zip(printed, exact, strict=True)]
    return rows.assign(thesis=thesis, deviation=percent(thesis, exact), verdict=verdicts)


def percent(value: Any, base: Any) -> Any:
    """Deviation of a value from a base [%], or of many."""
    return 100 * (value - base) / base


def matching_digits(printed: str, value: float) -> int:
    """Number of leading digits of a printed number that a value confirms: to k digits, both
    differ by no more than half a unit of the k-th, its own rounding allowed for."""
    number = float(printed)
    if not math.isfinite(value) or number * value <= 0:
        return 0
    first = math.floor(math.log10(abs(number)))
    difference = abs(number - value)
    count = 0
    for k in range(1, digits(printed) + 1):
        half = 10.0 ** (first - k + 1) / 2
        slack = unit(printed) / 2 if k < digits(printed) else 0.0
        if difference <= half * (1 + 1e-9) + slack:
            count = k
    return count


def verdict(printed: str, value: float, reason: str = "") -> str:
    """Reproduced where the value rounds to the printed number, or to how many digits it does; by
    how much it is off, and for what reason."""
    if not math.isfinite(value):
        return "nothing to compare with"
    count, off = matching_digits(printed, value), percent(float(printed), value)
    if count == digits(printed):
        return f"reproduced to all {count} digits"
    agree = f"{count or 'none'} of {digits(printed)} digits"
    return f"off by {off:+.2g} %: {agree}{', ' + reason if reason else ''}"


def by_size(deviations: Iterable[float]) -> str:
    """Describe how many deviations [%] are how large, in decades; nothing for none."""
    names = [*(f"up to {size:g} %" for size in SIZES), f"above {SIZES[-1]:g} %"]
    places = [bisect_left(SIZES, abs(x)) for x in deviations]
    return ", ".join(f"{places.count(k)} {name}" for k, name in enumerate(names) if k in places)
