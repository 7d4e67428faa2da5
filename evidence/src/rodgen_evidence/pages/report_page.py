"""The report as one HTML page that needs no network, with JSON, CSV and pictures beside it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from pandas import DataFrame

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import format_short
from rodgen.loading.cache import write_whole
from rodgen.show.style import style
from rodgen_evidence.page_tables import Column, table, words
from rodgen_evidence.pages.folder import PAGE, Pictures, put_whole, render
from rodgen_evidence.pages.report_parts import parts, scene_part
from rodgen_evidence.pages.report_tables import CUT, FAILURES, SECTIONS
from rodgen_evidence.report.contents import Contents, case_name, failures, frame, of, records
from rodgen_evidence.report.report_summary import ASKED, best_row, scenes, sentences
from rodgen_evidence.report.unit import Measured

TEMPLATE = "report.html.jinja"
DATA = "report.json"
SCENES = "scenes"  # in what the report was made with: why each scene is there
INTRODUCTION = (
    "How much run time every method of rodgen, and of others on their own formulation of the same "
    "scene, takes for how small an error; what things cost against the number of links; and where "
    "the numbers stop being right.",
    "Errors are differences from a reference by a method of another family, which carries its own "
    "error estimate; below it an error means nothing.",
    "What failed is listed with its reason, and generation and compile time stand apart from run "
    "time.",
    "All rows are in report.json, and by section in CSV files.",
)


def write_report(folder: Path, contents: Contents, made: Mapping[str, Any]) -> Path:
    """Write index.html, report.json, a CSV file for each section and the pictures.

    contents: results by section; made: with what, for the end of the page. Everything is made
    before anything is put into the folder, and the page comes last. Returns the page.
    """
    # Small diagrams have places of their own.
    with put_whole(folder) as making, rc_context(style | {"figure.constrained_layout.use": False}):
        write_whole(making / DATA, json_text(contents, made))
        for section, measured in contents.items():
            write_whole(making / csv_name(section), csv_text(measured))
        write_whole(making / PAGE, html(contents, made, Pictures(making)))
    return folder / PAGE


def html(contents: Contents, made: Mapping[str, Any], pictures: Pictures) -> str:
    """The page; its pictures are drawn on the way."""
    asked = [
        Column(error, f"error {error} rad", words)
        for error in (format_short(e, ".0e") for e in ASKED)
    ]
    wrong = frame(of(contents, "extremes", outcome="wrong"))
    run = scenes(contents) if contents.get("precision") else []
    best = [best_row(contents, scene) for scene in run]
    return render(
        TEMPLATE,
        introduction=[" ".join(INTRODUCTION)],
        sentences=sentences(contents),
        wrong=[(case_name(row), row["said"]) for row in records(wrong)],
        best=table("The fastest by scene", best, (Column("scene", "scene", words), *asked)),
        scenes=[
            scene_part(contents, scene, pictures, made.get(SCENES, {}).get(scene, ""))
            for scene in scenes(contents)
        ],
        parts=parts(contents, pictures),
        sections=table("Sections", _sections(contents), SECTIONS),
        failures=table(CUT, records(failures(contents)), FAILURES),
        made=made_lines({name: value for name, value in made.items() if name != SCENES}),
        data=DATA,
        files=[csv_name(section) for section in contents],
    )


def json_text(contents: Contents, made: Mapping[str, Any]) -> str:
    """All rows of all sections, what failed, and with what they were made; a unit a line."""
    sections = [
        f"{json.dumps(name)}: [\n" + ",\n".join(_strict(asdict(one)) for one in several) + "\n]"
        for name, several in contents.items()
    ]
    body = ",\n".join(sections)
    return f'{{"made": {json.dumps(dict(made))},\n"sections": {{\n{body}\n}}}}\n'


def _strict(value: Any) -> str:
    """JSON as others read it, which has neither infinity nor not-a-number: null."""

    def finite(part: Any) -> Any:
        if isinstance(part, dict):
            return {key: finite(one) for key, one in part.items()}
        if isinstance(part, list):
            return [finite(one) for one in part]
        return None if isinstance(part, float) and not math.isfinite(part) else part

    return json.dumps(finite(value), allow_nan=False)


def read_report(file: Path) -> tuple[dict[str, list[Measured]], dict[str, Any]]:
    """Contents and making of a report that was written."""
    stored = json.loads(file.read_text(encoding="utf-8"))
    sections = stored["sections"].items()
    contents = {name: [Measured(**one) for one in several] for name, several in sections}
    return contents, stored["made"]


def csv_name(section: str) -> str:
    """Name the file of a section beside the page."""
    return f"{section}.csv"


def csv_text(measured: Sequence[Measured]) -> str:
    """Rows of a section with all digits, a unit that failed as a row; lists as JSON."""
    lines: list[Measurement] = []
    for one in measured:
        lines += [{"unit": one.name, **row} for row in one.rows]
        lines += [{"unit": one.name, "failed": one.failed}] if one.failed else []
    stored = [
        {
            key: json.dumps(value) if isinstance(value, list) else value
            for key, value in line.items()
        }
        for line in lines
    ]
    return str(DataFrame(stored or {"unit": []}, dtype=object).to_csv(index=False))


def _sections(contents: Contents) -> list[Measurement]:
    failed = list(failures(contents)["section"])
    return [
        {
            "section": name,
            "units": len(several),
            "rows": sum(len(one.rows) for one in several),
            "failures": failed.count(name),
            "seconds": sum(one.seconds for one in several),
            "csv": csv_name(name),
        }
        for name, several in contents.items()
    ]


def made_lines(made: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Names and values: versions in one line, those of another group in a line each."""
    lines: list[tuple[str, str]] = []
    for name, value in made.items():
        if isinstance(value, Mapping) and name != "versions":
            lines += made_lines(value)
        else:
            lines.append((name.replace("_", " "), _in_words(name, value)))
    return lines


def _in_words(name: str, value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {entry}" for key, entry in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(map(str, value))
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.0f} s" if name == "seconds" else str(value)
