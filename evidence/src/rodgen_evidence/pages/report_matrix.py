"""Matrices of the report: extreme cases by method, rounding by case and form."""

from __future__ import annotations

import math
from typing import Any

from pandas import DataFrame, Series

from rodgen.analyse.precision.rows import TARGETS
from rodgen_evidence.page_tables import NONE, Cell, Shown, error, three
from rodgen_evidence.report.stability.rounding import excess, losing

# Times the unavoidable error, from which on a cell has the next colour.
BOUNDS = (3.0, 10.0, 100.0, 1e4)
OUTCOMES = {
    "right": "right, to so many digits",
    "stopped": "detected on the way and stopped, with its reason",
    "refused": "refused beforehand, with its reason",
    "warned": "not right, and warned of",
    "lost": "not right, and the run's own energy balance says so: it shows a tenth of the error "
    "or more",
    "unseen": "less than two digits with a fixed step, which has no error estimate, and an energy "
    "balance that shows less than a tenth of the error: halve the step until nothing changes, or "
    "take a method with error control",
    "unfinished": "cut off, as it took too long: nothing is known",
    "wrong": "wrong without warning: a defect",
    "failed": "the trial itself did not come to an end",
}
INVALID = "invalid"  # the group whose rows are of scenes and rhs, hardly any of a method


def outcomes(rows: DataFrame) -> list[Shown]:
    """Cases downwards, methods across: what happened, in a word; invalid numbers on their own."""
    invalid = rows["group"] == INVALID
    titles = ("What happened in extreme cases", "What became of invalid numbers")
    parts = zip(titles, (rows[~invalid], rows[invalid]), strict=True)
    return [_outcomes(title, some) for title, some in parts if len(some)]


def _outcomes(title: str, rows: DataFrame) -> Shown:
    named = rows["method"]
    if rows["target"].nunique() > 1:
        named = named + " in " + rows["target"].replace(TARGETS)
    columns = list(named.unique())
    body = []
    for (group, case, n), some in _together(rows).groupby(
        ["group", "case", "n"], sort=False, dropna=False
    ):
        by = dict(zip(named[some.index], some.index, strict=True))
        start = [Cell(group), Cell(case, mark="case"), Cell(_links(n) or NONE, "number")]
        cells = [_outcome(some.loc[by[at]]) if at in by else Cell(NONE) for at in columns]
        body.append(start + cells)
    return Shown(title, ["group", "case", "links", *columns], body)


def _together(rows: DataFrame) -> DataFrame:
    """Sort the rows of each group together, groups in the order of the rows."""
    order = {group: at for at, group in enumerate(rows["group"].unique())}
    return rows.sort_values("group", key=lambda group: group.map(order), kind="stable")


def _links(n: float) -> str:
    return f"{n:g}" if math.isfinite(n) else ""


def _outcome(row: Series[Any]) -> Cell:
    outcome = row["outcome"] or "failed"
    right = outcome == "right" and math.isfinite(row["digits"])
    shown = _digits(row["digits"]) if right else outcome
    shown = shown.upper() if outcome == "wrong" else shown
    return Cell(shown, mark=f"outcome {_known(outcome)}", title=row["said"] or row["failed"])


def _digits(found: float) -> str:
    """Whole ones: 5.9 right digits are no 6."""
    if found < 1:
        return "<1 digit"
    return "1 digit" if found < 2 else f"{math.floor(found)} digits"


def _known(outcome: str) -> str:
    return outcome if outcome in OUTCOMES else "other"


def legend(rows: DataFrame) -> list[dict[str, Any]]:
    """The outcomes that there are, what they mean, and how many."""
    counts = rows["outcome"].replace("", "failed").value_counts(sort=False).to_dict()
    known = {**OUTCOMES, **{name: "" for name in counts if name not in OUTCOMES}}
    return [
        {"name": name, "mark": _known(name), "meaning": meaning, "count": counts.get(name, 0)}
        for name, meaning in known.items()
        if name == "wrong" or counts.get(name)
    ]


def rounding(rows: DataFrame) -> Shown:
    """The largest error of rhs by case and form, beside what no form can avoid there."""
    forms, lost, beyond = list(rows["form"].unique()), losing(rows).index, excess(rows)
    body = []
    for (group, case), some in _together(rows).groupby(["group", "case"], sort=False):
        cells = []
        for form in forms:
            worst = _worst(some[some["form"] == form])
            of_it = (beyond[worst.name], worst.name in lost) if worst is not None else None
            cells.append(_ulps(worst, *of_it) if of_it else Cell(NONE))
        most = some[["ulps_input", "condition"]].max().astype(object)
        shown = [None if math.isnan(value) else value for value in most]
        last = [Cell(three(shown[0]), "number"), Cell(error(shown[1]), "number")]
        body.append([Cell(group), Cell(case, mark="case"), *cells, *last])
    head = ["group", "case", *forms, "unavoidable", "largest condition"]
    return Shown("Largest error of rhs, in units of the last place", head, body)


def _worst(rows: DataFrame) -> Any:
    """The row of the largest error, before it one that failed; None where there is none."""
    failed = rows[rows["failed"] != ""]
    order = failed if len(failed) else rows.sort_values("ulps", ascending=False, kind="stable")
    return order.iloc[0] if len(order) else None


def _ulps(row: Series[Any], beyond: float, lost: bool) -> Cell:
    where = f"{row['kind']} n = {_links(row['n'])}".strip()
    if row["failed"]:
        return Cell("failed", mark="heat unknown", title=f"{where}: {row['failed']}")
    level = sum(beyond > bound for bound in BOUNDS)
    ulps, condition = (None if math.isnan(row[key]) else row[key] for key in ("ulps", "condition"))
    about = f"{where}, condition {error(condition)}" + ", loses digits" * lost
    return Cell(three(ulps) + " !" * lost, "number", f"heat heat{level}", about)
