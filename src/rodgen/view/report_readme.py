"""The tables of speed in README, from a report: python -m rodgen.view.report_readme REPORT README

Between the marks below README holds what this makes of the committed report, and nothing else.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from rodgen.judge.precision.duels import side
from rodgen.judge.rows import Contents, fine, number, of, text
from rodgen.judge.summary import duration
from rodgen.judge.unit import Row
from rodgen.loading.cache import write_whole
from rodgen.view.report_page import read_report

BEGIN, END = "<!-- speed: from docs/report/report.json -->", "<!-- /speed -->"
ASKED = 1e-6  # rad
LINKS = (20, 50, 200, 1000)
EVALUATIONS = (
    ("rodgen C", "C, from Python, with an `out` array"),
    ("rodgen C, from C", "C, from C"),
    ("rodgen C, of a batch", "C, `rhs_batch`, one state of many"),
    ("rodgen NumPy", "NumPy"),
    ("rodgen NumPy, dense", "NumPy, dense form"),
)
SHOWN = {"CasADi, generated C": "CasADi, generated C, from C"}
WHOLE = (
    ("jacobian", "rodgen C", "exact Jacobian, C"),
    ("implicit step", "rodgen C, gauss", "a step of `gauss`"),
    ("job: 1000 steps of rk4", "rodgen C", "1000 steps of `rk4`"),
    ("critical force", "rodgen", "critical force"),
    ("ten natural modes", "rodgen", "ten natural modes"),
)


def speed(contents: Contents) -> str:
    """Whole integrations at equal error, and costs against n, as Markdown."""
    duels = [row for row in of(contents, "equal_error", asked=ASKED) if fine(row)]
    costs = [row for row in of(contents, "costs") if fine(row)]
    ours, theirs = ("rodgen", "rhs", "time"), ("fastest of the peers", "rhs", "time")
    head = ("scene", "n", *ours, *theirs, "times faster")
    runs = of(contents, "precision")
    peers = sorted({text(row, "who") for row in costs if not text(row, "who").startswith("rodgen")})
    evaluations = [(who, shown) for who, shown in EVALUATIONS] + [
        (who, SHOWN.get(who, who)) for who in peers
    ]
    lines = [
        *_table(head, (_duel(row, runs) for row in duels)),
        "",
        *_table(
            ("one evaluation of `rhs`", *(f"n={n}" for n in LINKS)),
            (_costs(costs, "rhs", who, shown) for who, shown in evaluations),
        ),
        "",
        *_table(
            ("what else", *(f"n={n}" for n in LINKS)),
            (_costs(costs, *which) for which in WHOLE),
        ),
    ]
    return "\n".join(lines)


def _duel(row: Row, runs: Sequence[Row]) -> list[str]:
    cells = [f"`{text(row, 'scene')}`", text(row, "n")]
    for who in ("ours", "theirs"):
        seconds = duration(number(row, f"{who}_seconds"))
        cells += [text(row, who), _evaluations(row, who, runs), seconds]
    return [*cells, f"{number(row, 'ratio'):.2g}"]


def _evaluations(row: Row, who: str, runs: Sequence[Row]) -> str:
    """How often one side of a duel evaluated rhs, from its run in the section precision."""
    counts = (
        run.get("rhs")
        for run in runs
        if run["scene"] == row["scene"]
        and run.get("setting") is not None
        and side(run, with_who=who == "theirs") == row[who]
    )
    return next((f"{count}" for count in counts if count is not None), "-")


def _costs(rows: Sequence[Row], what: str, who: str, shown: str) -> list[str]:
    found = {row["n"]: row for row in rows if row.get("what") == what and row.get("who") == who}
    return [shown, *(duration(number(found[n], "seconds")) if n in found else "-" for n in LINKS)]


def _table(head: Sequence[str], body: Iterable[Sequence[str]]) -> list[str]:
    rows = [row for row in body if set(row[1:]) != {"-"}]
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]


def renewed(readme: str, contents: Contents) -> str:
    """README with its tables made anew. Raises ValueError where the marks are missing."""
    start, rest = readme.split(BEGIN)
    _, end = rest.split(END)
    return f"{start}{BEGIN}\n\n{speed(contents)}\n\n{END}{end}"


if __name__ == "__main__":
    report, readme = map(Path, sys.argv[1:])
    contents, _ = read_report(report)
    write_whole(readme, renewed(readme.read_text(encoding="utf-8"), contents))
