"""Which settings nothing beats, from rows of work-precision sets."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import isfinite

from rodgen.judge.precision.orders import families
from rodgen.judge.unit import Row


def front(rows: Sequence[Row], measure: str = "error_phi", trusted: float = 0.0) -> list[Row]:
    """Rows of one scene than which none is both faster and closer, by rising seconds.

    trusted: the reference's own estimate. Rows with smaller errors beat others, but are not on the
    front themselves, as such errors mean nothing.
    """
    best = float("inf")
    found: list[Row] = []
    for row in sorted(filter(_usable(measure), rows), key=_place(measure)):
        if _number(row, measure) < best:
            best = _number(row, measure)
            found.append(row)
    return [row for row in found if _number(row, measure) >= trusted]


def cheapest(rows: Iterable[Row], asked: float, measure: str = "error_phi") -> Row | None:
    """The fastest row within an error, or None.

    The next tighter setting of its family has to be within it too, where there is one that ended:
    an error may be small by chance.
    """
    steady: list[Row] = []
    for family in families(rows):
        ended = list(filter(_usable(measure), family))
        for row, tighter in zip(ended, [*ended[1:], None], strict=False):
            within = _number(row, measure) <= asked
            if within and (tighter is None or _number(tighter, measure) <= asked):
                steady.append(row)
    return min(steady, key=_place(measure), default=None)


def _usable(measure: str) -> Callable[[Row], bool]:
    """Whether a row ended with a time and an error."""
    names = ("seconds", measure)
    return lambda row: not row.get("failed") and all(isfinite(_number(row, n)) for n in names)


def _place(measure: str) -> Callable[[Row], tuple[float, float]]:
    return lambda row: (_number(row, "seconds"), _number(row, measure))


def _number(row: Row, name: str) -> float:
    value = row.get(name)
    return float(value) if isinstance(value, int | float) else float("nan")
