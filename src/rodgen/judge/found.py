"""What is looked for among rows: the fastest, fronts, failures, defects, what was saved."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from statistics import median

from rodgen.judge.rows import Contents, curve, fine, grouped, label, number, of, setting, text
from rodgen.judge.unit import Row

OFF = 0.05  # from theory, from which on a largest stable step is named
SATURATED = 0.1  # [rad], from which on an error hardly grows
PLAIN, WHOLE = "as the scene", "every term, at zero"  # variants of a module
PARTS = ("operations", "source_bytes", "object_bytes", "generate", "compile", "rhs", "run")
LOSES = 10.0  # times the error that cannot be avoided, from which on a form loses digits


def fastest(rows: list[Row], measure: str, error: float) -> Row | None:
    """The cheapest of those with no larger error."""
    within = [r for r in rows if fine(r) and number(r, measure) <= error]
    timed = [r for r in within if number(r, "seconds") > 0]
    return min(timed, key=lambda r: number(r, "seconds"), default=None)


def trusted(contents: Contents, scene: str, measure: str = "error_phi") -> float:
    """The reference's own estimate: smaller errors mean nothing. 0 where there is none."""
    key = measure.replace("error_", "estimate_")
    found = [number(row, key) for row in of(contents, "references", scene=scene) if fine(row)]
    return max((value for value in found if math.isfinite(value)), default=0.0)


def failures(contents: Contents) -> list[Row]:
    """Units and rows that failed, with the reason."""
    lines: list[Row] = []
    for section, several in contents.items():
        for one in several:
            if one.failed:
                lines.append(_failure(section, "", one.name, one.failed))
            lines += [
                _failure(section, text(row, "scene"), _named(row), text(row, "failed"))
                for row in one.rows
                if row.get("failed")
            ]
    return lines


def _failure(section: str, scene: str, what: str, failed: str) -> Row:
    return {"section": section, "scene": scene, "what": what, "failed": failed}


def failed_of(contents: Contents, scene: str) -> list[Row]:
    """What failed of a scene: rows, and units that have its name in theirs."""
    its = re.compile(rf"(^|-){re.escape(scene)}(-|$)")
    return [
        line
        for line in failures(contents)
        if line["scene"] == scene or (not line["scene"] and its.search(text(line, "what")))
    ]


def wrong(contents: Contents) -> list[Row]:
    """Cases in which a method gave a wrong result and did not say so."""
    return of(contents, "extremes", outcome="wrong")


def far_from_theory(contents: Contents) -> list[Row]:
    """Largest stable steps that are not where theory has them."""
    return [row for row in of(contents, "steps") if abs(number(row, "off")) > OFF]


def loses_digits(row: Row) -> bool:
    """Whether a form's rounding is far beyond what its input's rounding makes of any form."""
    return number(row, "ulps") > LOSES * max(1.0, number(row, "ulps_input"))


def front(rows: list[Row], measure: str) -> list[Row]:
    """Those than which none is both faster and closer, from the fastest on (Pareto)."""
    timed = [r for r in rows if fine(r) and number(r, "seconds") > 0 and number(r, measure) >= 0]
    kept: list[Row] = []
    for row in sorted(timed, key=lambda r: (number(r, "seconds"), number(r, measure))):
        if not kept or number(row, measure) < number(kept[-1], measure):
            kept.append(row)
    return kept


def growth_line(row: Row) -> tuple[list[float], list[float]] | None:
    """Times and values of the fitted exponential, through the middle of what it is fitted to."""
    rate = number(row, "rate")
    points = [
        (t, error)
        for t, error in zip(curve(row, "t"), curve(row, "error"), strict=True)
        if error > 0 and math.isfinite(error)
    ]
    rising = [(t, error) for t, error in points if error < SATURATED]
    if not rising or not math.isfinite(rate):
        return None
    height = median(math.log(error) - rate * t for t, error in rising)
    first, last = rising[0][0], rising[-1][0]
    return [first, last], [math.exp(height + rate * t) for t in (first, last)]


def savings(rows: Sequence[Row]) -> dict[str, Row]:
    """By scene: every term at zero coefficients over the scene's own module."""
    ratios: dict[str, Row] = {}
    for scene, some in grouped(filter(fine, rows), lambda row: text(row, "scene")).items():
        by = {text(row, "variant"): row for row in some}
        if not by.keys() >= {PLAIN, WHOLE}:
            continue
        ratios[scene] = {
            key: number(by[WHOLE], key) / number(by[PLAIN], key)
            for key in PARTS
            if number(by[PLAIN], key) > 0
        }
    return ratios


def _named(row: Row) -> str:
    keys = ("scene", "group", "case", "what", "variant", "form", "damping")
    start = [text(row, key) for key in keys if row.get(key)]
    start += [f"n = {row['n']}"] if row.get("n") is not None else []
    return ", ".join([*start, *filter(None, (label(row), setting(row)))])
