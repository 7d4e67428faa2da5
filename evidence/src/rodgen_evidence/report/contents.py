"""Contents of a report by section: rows, frames of them, and what failed or was left out."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from pandas import DataFrame

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import format_label, format_setting, has_result, read_text
from rodgen_evidence.report.unit import Measured

Contents = Mapping[str, Sequence[Measured]]

TEXTS = (
    *("scene", "who", "method", "target", "kind", "label", "group", "case", "form", "variant"),
    *("damping", "what", "outcome", "said", "section", "failed"),
)
NUMBERS = (
    *("n", "seconds", "setting", "order", "error_phi", "estimate_phi", "events", "rate", "off"),
    *("found", "theory", "digits", "ulps", "ulps_input", "condition", "ratio", "exponent"),
)
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


def of(contents: Contents, section: str, **what: object) -> list[Measurement]:
    """A section's rows, those with these entries."""
    rows = [row for measured in contents.get(section, ()) for row in measured.rows]
    return [row for row in rows if all(row.get(key) == value for key, value in what.items())]


def frame(rows: Iterable[Measurement]) -> DataFrame:
    """Rows with a label of who took which method: text is "", a number nan where there is none."""
    made = DataFrame([{**row, "label": format_label(row)} for row in rows])
    for key in TEXTS:
        made[key] = made[key].fillna("").astype(str) if key in made else ""
    for key in NUMBERS:
        made[key] = made[key].astype(float) if key in made else float("nan")
    return made


def records(made: DataFrame) -> list[Measurement]:
    """The rows of a frame; None where there is no number."""
    rows: list[Measurement] = made.astype(object).where(made.notna(), None).to_dict("records")
    return rows


def reference_error(contents: Contents, scene: str, measure: str = "error_phi") -> float:
    """Error estimate of the reference: smaller errors mean nothing. 0 where there is none."""
    known = frame(filter(has_result, of(contents, "references", scene=scene)))
    key = measure.replace("error_", "estimate_")
    found = known[key].astype(float).max() if key in known else 0.0
    return float(found) if found < float("inf") else 0.0


def may_have_reference(contents: Contents, scene: str) -> bool:
    """Whether a scene has a reference solution, or is not known to have none."""
    rows = of(contents, "references", scene=scene)
    return not rows or any(map(has_result, rows))


def failures(contents: Contents) -> DataFrame:
    """Units and rows that failed, with the reason; at the end what the report cut short."""
    lines = [
        line
        for section, several in contents.items()
        for one in several
        for line in (
            (section, "", one.name, one.failed),
            *(
                (section, read_text(r, "scene"), _row_name(r), read_text(r, "failed"))
                for r in one.rows
            ),
        )
        if line[-1]
    ]
    made = DataFrame(lines, columns=["section", "scene", "what", "failed"], dtype=object)
    made["kind"] = made["failed"].map(kind_of)
    return made.sort_values("kind", key=lambda kind: kind != FAILED, kind="stable")


def kind_of(failed: str) -> str:
    """Kind of a reason: what was left out or cut short by the report itself is no failure."""
    return next((kind for kind, start in KINDS.items() if re.match(start, failed)), FAILED)


def failed_of(contents: Contents, scene: str) -> DataFrame:
    """Failures of a scene: rows, and units that have its name in theirs."""
    lines, its = failures(contents), rf"(?:^|-){re.escape(scene)}(?:-|$)"
    unit = (lines["scene"] == "") & lines["what"].astype(str).str.contains(its)
    return lines[(lines["scene"] == scene) | unit]


def case_name(row: Measurement) -> str:
    """Name an extreme case and who was tried on it."""
    return ", ".join(filter(None, (read_text(row, key) for key in ("group", "case", "label"))))


def _row_name(row: Measurement) -> str:
    keys = ("scene", "group", "case", "what", "variant", "form", "damping")
    start = [read_text(row, key) for key in keys if row.get(key)]
    start += [f"n = {row['n']}"] if row.get("n") is not None else []
    return ", ".join([*start, *filter(None, (format_label(row), format_setting(row)))])
