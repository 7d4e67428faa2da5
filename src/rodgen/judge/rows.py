"""Looking at rows: their numbers and texts, and what a row is called."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence

from rodgen.judge.unit import Measured, Row

Contents = Mapping[str, Sequence[Measured]]  # what was measured, by section
TARGETS = {"c": "C", "numpy": "NumPy"}
OTHERS = {"rodgen's c": "rodgen's C", **TARGETS}


def number(row: Row, key: str) -> float:
    """An entry as a number; nan where it is none."""
    value = row.get(key)
    return float(value) if isinstance(value, (int, float)) else math.nan


def text(row: Row, key: str) -> str:
    """An entry as text; empty where there is none."""
    value = row.get(key)
    return "" if value is None else str(value)


def curve(row: Row, key: str) -> list[float]:
    """An entry that is a list; empty where there is none."""
    value = row.get(key)
    return [float(entry) for entry in value] if isinstance(value, list) else []


def of(contents: Contents, section: str, **what: object) -> list[Row]:
    """A section's rows, those with these entries."""
    rows = [row for measured in contents.get(section, ()) for row in measured.rows]
    return [row for row in rows if all(row.get(key) == value for key, value in what.items())]


def grouped(rows: Iterable[Row], name: Callable[[Row], str]) -> dict[str, list[Row]]:
    """Rows by a name of them, in their order."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(name(row), []).append(row)
    return groups


def label(row: Row) -> str:
    """Who took which method, and on what equations: dop853 in C; SciPy RK45 on rodgen's C."""
    who, method, target = (text(row, key) for key in ("who", "method", "target"))
    if who in ("", "rodgen"):
        return f"{method} in {TARGETS.get(target, target)}" if target else method
    name = " ".join(filter(None, (who, method if method.lower() != who.lower() else "")))
    return name if target in ("", who) else f"{name} on {OTHERS.get(target, target)}"


def short(value: float, spec: str = ".3g") -> str:
    """A number without zeros before its exponent: 1e-5."""
    return re.sub(r"e([+-])0", r"e\1", format(value, spec)).replace("e+", "e")


def fine(row: Row) -> bool:
    """A row that came to something."""
    return not row.get("failed")


def setting(row: Row) -> str:
    """A step or tolerance: step 1e-3 s, rtol 1e-6."""
    value = row.get("setting")
    if value is None:
        return ""
    unit = " s" if row.get("kind") == "step" else ""
    shown = f"{short(value)}{unit}" if isinstance(value, float) else str(value)
    return f"{text(row, 'kind')} {shown}".strip()
