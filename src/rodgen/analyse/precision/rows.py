"""Rows of work-precision sets: their entries, their labels, and the Pareto front."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby

from rodgen.analyse.precision.contestant import Measurement

TARGETS = {"c": "C", "numpy": "NumPy"}
OTHERS = {"rodgen's c": "rodgen's C", **TARGETS}
FAMILY = ("scene", "who", "method", "target", "kind")  # what a family of settings has in common


def read_number(row: Measurement, key: str) -> float:
    """Read an entry as a number; nan where it is none."""
    value = row.get(key)
    return float(value) if isinstance(value, (int, float)) else math.nan


def read_text(row: Measurement, key: str) -> str:
    """Read an entry as text; empty where there is none."""
    value = row.get(key)
    return "" if value is None else str(value)


def group_rows(
    rows: Iterable[Measurement], name: Callable[[Measurement], str]
) -> dict[str, list[Measurement]]:
    """Group rows by a name, in their order."""
    groups: dict[str, list[Measurement]] = {}
    for row in rows:
        groups.setdefault(name(row), []).append(row)
    return groups


def format_label(row: Measurement) -> str:
    """Label a row by who, method and equations: dop853 in C; SciPy RK45 on rodgen's C."""
    who, method, target = (read_text(row, key) for key in ("who", "method", "target"))
    if who in ("", "rodgen"):
        return f"{method} in {TARGETS.get(target, target)}" if target else method
    name = " ".join(filter(None, (who, method if method.lower() != who.lower() else "")))
    return name if target in ("", who) else f"{name} on {OTHERS.get(target, target)}"


def format_short(value: float, spec: str = ".3g") -> str:
    """Format a number without zeros before its exponent: 1e-5."""
    return re.sub(r"e([+-])0", r"e\1", format(value, spec)).replace("e+", "e")


def has_result(row: Measurement) -> bool:
    """Whether a row has a result."""
    return not row.get("failed")


def format_setting(row: Measurement) -> str:
    """Format the step or tolerance of a row: step 1e-3 s, rtol 1e-6."""
    value = row.get("setting")
    if value is None:
        return ""
    unit = " s" if row.get("kind") == "step" else ""
    shown = f"{format_short(value)}{unit}" if isinstance(value, float) else str(value)
    return f"{read_text(row, 'kind')} {shown}".strip()


def group_families(rows: Iterable[Measurement]) -> Iterator[list[Measurement]]:
    """Yield groups of rows by scene, who, method, target and kind of setting, each in the order of
    settings: loose to tight."""
    for _, group in groupby(sorted(rows, key=_family_key), key=_family_key):
        yield sorted(group, key=lambda row: -read_number(row, "setting"))


def pareto_front(
    rows: Sequence[Measurement], measure: str = "error_phi", trusted: float = 0.0
) -> list[Measurement]:
    """Pareto front of the rows of one scene: none is both faster and closer, by rising seconds.

    trusted: the reference's own estimate. Rows with smaller errors beat others, but are not on the
    front themselves, as such errors mean nothing.
    """
    best = float("inf")
    found: list[Measurement] = []
    for row in sorted(filter(_has_measure(measure), rows), key=_sort_key(measure)):
        if read_number(row, measure) < best:
            best = read_number(row, measure)
            found.append(row)
    return [row for row in found if read_number(row, measure) >= trusted]


def find_cheapest(
    rows: Iterable[Measurement], asked: float, measure: str = "error_phi"
) -> Measurement | None:
    """Find the fastest row within an error, or None.

    The next tighter setting of its family has to be within it too, where there is one that ended:
    an error may be small by chance.
    """
    steady: list[Measurement] = []
    for family in group_families(rows):
        ended = list(filter(_has_measure(measure), family))
        for row, tighter in zip(ended, [*ended[1:], None], strict=False):
            within = read_number(row, measure) <= asked
            if within and (tighter is None or read_number(tighter, measure) <= asked):
                steady.append(row)
    return min(steady, key=_sort_key(measure), default=None)


def _has_measure(measure: str) -> Callable[[Measurement], bool]:
    """Return the test whether a row ended with a time and an error."""
    names = ("seconds", measure)
    return lambda row: (
        not row.get("failed") and all(math.isfinite(read_number(row, n)) for n in names)
    )


def _sort_key(measure: str) -> Callable[[Measurement], tuple[float, float]]:
    return lambda row: (read_number(row, "seconds"), read_number(row, measure))


def _family_key(row: Measurement) -> tuple[str, ...]:
    return tuple(str(row.get(key)) for key in FAMILY)
