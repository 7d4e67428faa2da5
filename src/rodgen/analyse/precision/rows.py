"""Rows of work-precision sets: their numbers, what a row is called, and which nothing beats."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby

from rodgen.analyse.precision.contestant import Measurement

TARGETS = {"c": "C", "numpy": "NumPy"}
OTHERS = {"rodgen's c": "rodgen's C", **TARGETS}
FAMILY = ("scene", "who", "method", "target", "kind")  # what a family of settings has in common


def number(row: Measurement, key: str) -> float:
    """An entry as a number; nan where it is none."""
    value = row.get(key)
    return float(value) if isinstance(value, (int, float)) else math.nan


def text(row: Measurement, key: str) -> str:
    """An entry as text; empty where there is none."""
    value = row.get(key)
    return "" if value is None else str(value)


def grouped(
    rows: Iterable[Measurement], name: Callable[[Measurement], str]
) -> dict[str, list[Measurement]]:
    """Rows by a name of them, in their order."""
    groups: dict[str, list[Measurement]] = {}
    for row in rows:
        groups.setdefault(name(row), []).append(row)
    return groups


def label(row: Measurement) -> str:
    """Who took which method, and on what equations: dop853 in C; SciPy RK45 on rodgen's C."""
    who, method, target = (text(row, key) for key in ("who", "method", "target"))
    if who in ("", "rodgen"):
        return f"{method} in {TARGETS.get(target, target)}" if target else method
    name = " ".join(filter(None, (who, method if method.lower() != who.lower() else "")))
    return name if target in ("", who) else f"{name} on {OTHERS.get(target, target)}"


def short(value: float, spec: str = ".3g") -> str:
    """A number without zeros before its exponent: 1e-5."""
    return re.sub(r"e([+-])0", r"e\1", format(value, spec)).replace("e+", "e")


def fine(row: Measurement) -> bool:
    """A row that came to something."""
    return not row.get("failed")


def setting(row: Measurement) -> str:
    """A step or tolerance: step 1e-3 s, rtol 1e-6."""
    value = row.get("setting")
    if value is None:
        return ""
    unit = " s" if row.get("kind") == "step" else ""
    shown = f"{short(value)}{unit}" if isinstance(value, float) else str(value)
    return f"{text(row, 'kind')} {shown}".strip()


def families(rows: Iterable[Measurement]) -> Iterator[list[Measurement]]:
    """Rows by scene, who, method, target and kind of setting, in the order of settings: loose to
    tight."""
    for _, group in groupby(sorted(rows, key=_family), key=_family):
        yield sorted(group, key=lambda row: -number(row, "setting"))


def front(
    rows: Sequence[Measurement], measure: str = "error_phi", trusted: float = 0.0
) -> list[Measurement]:
    """Rows of one scene than which none is both faster and closer, by rising seconds.

    trusted: the reference's own estimate. Rows with smaller errors beat others, but are not on the
    front themselves, as such errors mean nothing.
    """
    best = float("inf")
    found: list[Measurement] = []
    for row in sorted(filter(_usable(measure), rows), key=_place(measure)):
        if number(row, measure) < best:
            best = number(row, measure)
            found.append(row)
    return [row for row in found if number(row, measure) >= trusted]


def cheapest(
    rows: Iterable[Measurement], asked: float, measure: str = "error_phi"
) -> Measurement | None:
    """The fastest row within an error, or None.

    The next tighter setting of its family has to be within it too, where there is one that ended:
    an error may be small by chance.
    """
    steady: list[Measurement] = []
    for family in families(rows):
        ended = list(filter(_usable(measure), family))
        for row, tighter in zip(ended, [*ended[1:], None], strict=False):
            within = number(row, measure) <= asked
            if within and (tighter is None or number(tighter, measure) <= asked):
                steady.append(row)
    return min(steady, key=_place(measure), default=None)


def _usable(measure: str) -> Callable[[Measurement], bool]:
    """Whether a row ended with a time and an error."""
    names = ("seconds", measure)
    return lambda row: not row.get("failed") and all(math.isfinite(number(row, n)) for n in names)


def _place(measure: str) -> Callable[[Measurement], tuple[float, float]]:
    return lambda row: (number(row, "seconds"), number(row, measure))


def _family(row: Measurement) -> tuple[str, ...]:
    return tuple(str(row.get(key)) for key in FAMILY)
