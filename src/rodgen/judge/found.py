"""What is looked for among rows: the fastest, fronts, failures, defects, what was saved."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from statistics import median

from rodgen.judge.rows import Contents, curve, fine, grouped, label, number, of, setting, text
from rodgen.judge.unit import Row

OFF = 0.05  # from theory, from which on a largest stable step is named
SATURATED = 0.1  # [rad], from which on an error hardly grows
CHAOTIC = 1e3  # times that errors grow in the span, from which on that is exponential
PLAIN, WHOLE = "as the scene", "every term, at zero"  # variants of a module
PARTS = ("operations", "source_bytes", "object_bytes", "generate", "compile", "rhs")
RUNS = ("run", "run_dop853")
FAILED = "failed"
# Starts of reasons that are no failures of who gives them.
KINDS = {
    "not tried, as time was up": "not tried",
    "stopped, as they took too long": r"stopped after [\d.e+-]+ s$",
    "not installed": "not installed",
    "not modelled": "not modelled: ",
    "without a reference": "no reference: ",
    "without an opponent within the error": r".* missed this error in the time of a run",
}
ORDERS_OF = "free_n20"  # the scene on which orders are looked at
FORMS = {"c": "C", "numpy chain": "NumPy", "numpy dense": "NumPy, dense form"}
LOSES = 10.0  # times what another form and rounded input come to, from which on digits are lost


def trusted(contents: Contents, scene: str, measure: str = "error_phi") -> float:
    """The reference's own estimate: smaller errors mean nothing. 0 where there is none."""
    key = measure.replace("error_", "estimate_")
    found = [number(row, key) for row in of(contents, "references", scene=scene) if fine(row)]
    return max((value for value in found if math.isfinite(value)), default=0.0)


def fixed_steps_of(contents: Contents) -> dict[str, list[Row]]:
    """Runs in C with fixed steps, by method."""
    rows = of(contents, "precision", scene=ORDERS_OF, kind="step", who="rodgen", target="c")
    return grouped(filter(fine, rows), lambda row: text(row, "method"))


def judged(contents: Contents, scene: str) -> bool:
    """Whether a scene has a reference solution, or is not known to have none."""
    rows = of(contents, "references", scene=scene)
    return not rows or any(map(fine, rows))


def failures(contents: Contents) -> list[Row]:
    """Units and rows that failed, with the reason; at the end what the report cut short."""
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
    return sorted(lines, key=lambda line: line["kind"] != FAILED)


def kind_of(failed: str) -> str:
    """Of a reason: what was left out or cut short by the report itself is no failure."""
    return next((kind for kind, start in KINDS.items() if re.match(start, failed)), FAILED)


def _failure(section: str, scene: str, what: str, failed: str) -> Row:
    return {
        "section": section,
        "scene": scene,
        "what": what,
        "failed": failed,
        "kind": kind_of(failed),
    }


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


def unseen(rows: Iterable[Row]) -> list[Row]:
    """Extreme cases in which a fixed step is off and nothing tells, with their names."""
    return [{**row, "label": label(row)} for row in rows if row.get("outcome") == "unseen"]


def case_named(row: Row) -> str:
    """An extreme case and who was tried on it."""
    return ", ".join(filter(None, (text(row, "group"), text(row, "case"), label(row))))


def far_from_theory(contents: Contents) -> list[Row]:
    """Largest stable steps that are not where theory has them."""
    return [row for row in of(contents, "steps") if abs(number(row, "off")) > OFF]


def excess(row: Row) -> float:
    """An error of rhs over what rounded input makes unavoidable, at least a unit."""
    return number(row, "ulps") / max(1.0, number(row, "ulps_input"))


def losing(rows: Sequence[Row]) -> list[Row]:
    """Rows of forms of rhs that lose digits which another form keeps, and rounded input leaves."""
    lost: list[Row] = []
    for some in grouped(filter(fine, rows), _place).values():
        least = min((number(row, "ulps") for row in some), default=0.0)
        for row in some:
            explained = max(1.0, least, number(row, "ulps_input"))
            if number(row, "ulps") > LOSES * explained:
                lost.append(row)
    return lost


def _place(row: Row) -> str:
    return "\0".join(text(row, key) for key in ("kind", "n", "group", "case"))


def grows(row: Row) -> bool:
    """Whether errors grow exponentially: so much in the span that it is no other growth."""
    t, rate = curve(row, "t"), number(row, "rate")
    return fine(row) and bool(t) and rate * (t[-1] - t[0]) > math.log(CHAOTIC)


def growth_line(row: Row) -> tuple[list[float], list[float]] | None:
    """Times and values of the fitted exponential, through the middle of what it is fitted to."""
    if not grows(row):
        return None
    rate = number(row, "rate")
    points = [
        (t, error)
        for t, error in zip(curve(row, "t"), curve(row, "error"), strict=True)
        if error > 0 and math.isfinite(error)
    ]
    rising = [(t, error) for t, error in points if error < SATURATED]
    if not rising:
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
            for key in (*PARTS, *RUNS)
            if number(by[PLAIN], key) > 0
        }
    return ratios


def _named(row: Row) -> str:
    keys = ("scene", "group", "case", "what", "variant", "form", "damping")
    start = [text(row, key) for key in keys if row.get(key)]
    start += [f"n = {row['n']}"] if row.get("n") is not None else []
    return ", ".join([*start, *filter(None, (label(row), setting(row)))])
