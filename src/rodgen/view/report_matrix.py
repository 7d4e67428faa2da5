"""Matrices of the report: extreme cases by method, rounding by case and form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rodgen.judge.found import excess, losing
from rodgen.judge.rows import TARGETS, fine, grouped, number, text
from rodgen.judge.unit import Row
from rodgen.view.report_tables import NONE, Cell, Shown, error, three

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


def outcomes(rows: Sequence[Row]) -> list[Shown]:
    """Cases downwards, methods across: what happened, in a word; invalid numbers on their own."""
    invalid = [row for row in rows if text(row, "group") == INVALID]
    valid = [row for row in rows if text(row, "group") != INVALID]
    titles = ("What happened in extreme cases", "What became of invalid numbers")
    return [
        _outcomes(title, some) for title, some in zip(titles, (valid, invalid), strict=True) if some
    ]


def _outcomes(title: str, rows: Sequence[Row]) -> Shown:
    targets = {text(row, "target") for row in rows}
    columns = list(dict.fromkeys(_method(row, len(targets) > 1) for row in rows))
    body = []
    for name, some in _by_case(rows, "case", "n").items():
        by = {_method(row, len(targets) > 1): row for row in some}
        group, case, n = name.split("\0")
        start = [Cell(group), Cell(case, mark="case"), Cell(n or NONE, "number")]
        body.append(start + [_outcome(by[at]) if at in by else Cell(NONE) for at in columns])
    return Shown(title, ["group", "case", "links", *columns], body)


def _outcome(row: Row) -> Cell:
    outcome = _came_to(row)
    digits = number(row, "digits")
    shown = _digits(digits) if outcome == "right" and math.isfinite(digits) else outcome
    shown = shown.upper() if outcome == "wrong" else shown
    return Cell(
        shown, mark=f"outcome {_known(outcome)}", title=text(row, "said") or text(row, "failed")
    )


def _digits(found: float) -> str:
    """Whole ones: 5.9 right digits are no 6."""
    if found < 1:
        return "<1 digit"
    return "1 digit" if found < 2 else f"{math.floor(found)} digits"


def _came_to(row: Row) -> str:
    return text(row, "outcome") or "failed"


def _known(outcome: str) -> str:
    return outcome if outcome in OUTCOMES else "other"


def legend(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The outcomes that there are, what they mean, and how many."""
    counts = {name: len(some) for name, some in grouped(rows, _came_to).items()}
    known = {**OUTCOMES, **{name: "" for name in counts if name not in OUTCOMES}}
    return [
        {"name": name, "mark": _known(name), "meaning": meaning, "count": counts.get(name, 0)}
        for name, meaning in known.items()
        if name == "wrong" or counts.get(name)
    ]


def _method(row: Row, several: bool) -> str:
    target = text(row, "target")
    return (
        f"{text(row, 'method')} in {TARGETS.get(target, target)}"
        if several
        else text(row, "method")
    )


def _by_case(rows: Sequence[Row], *keys: str) -> dict[str, list[Row]]:
    """Those of a group together, in the order of the rows."""
    groups = grouped(rows, lambda row: text(row, "group"))
    return grouped(
        (row for some in groups.values() for row in some),
        lambda row: "\0".join(text(row, key) for key in ("group", *keys)),
    )


def rounding(rows: Sequence[Row]) -> Shown:
    """The largest error of rhs by case and form, beside what no form can avoid there."""
    forms = list(dict.fromkeys(text(row, "form") for row in rows))
    lost = {id(row) for row in losing(rows)}
    body = []
    for name, some in _by_case(rows, "case").items():
        worst = {form: _worst([r for r in some if r.get("form") == form]) for form in forms}
        cells = [_ulps(row, id(row) in lost) if row else Cell(NONE) for row in worst.values()]
        most = [
            max((number(row, key) for row in some if number(row, key) >= 0), default=None)
            for key in ("ulps_input", "condition")
        ]
        last = [Cell(three(most[0]), "number"), Cell(error(most[1]), "number")]
        group, case = name.split("\0")
        body.append([Cell(group), Cell(case, mark="case"), *cells, *last])
    head = ["group", "case", *forms, "unavoidable", "largest condition"]
    return Shown("Largest error of rhs, in units of the last place", head, body)


def _worst(rows: Sequence[Row]) -> Row | None:
    failed = [row for row in rows if not fine(row)]
    return failed[0] if failed else max(rows, key=lambda row: number(row, "ulps"), default=None)


def _ulps(row: Row, lost: bool) -> Cell:
    where = f"{text(row, 'kind')} n = {text(row, 'n')}".strip()
    if not fine(row):
        return Cell("failed", mark="heat unknown", title=f"{where}: {text(row, 'failed')}")
    level = sum(excess(row) > bound for bound in BOUNDS)
    shown = three(row.get("ulps")) + (" !" if lost else "")
    about = f"{where}, condition {error(row.get('condition'))}" + ", loses digits" * lost
    return Cell(shown, "number", f"heat heat{level}", about)
