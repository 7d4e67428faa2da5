"""The tables of the thesis as one HTML page that needs no network, with CSV and pictures."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rodgen.loading.cache import write_whole
from rodgen_evidence.page_tables import table as shown
from rodgen_evidence.pages.folder import PAGE, put_whole, render
from rodgen_evidence.pages.thesis_figures import FIGURES, save_figures
from rodgen_evidence.report.contents import records
from rodgen_evidence.report.surroundings import processor
from rodgen_evidence.thesis import scenes
from rodgen_evidence.thesis.table import INCOMPARABLE, ThesisTable, by_size

TEMPLATE = "thesis.html.jinja"
INTRODUCTION = (
    "Every table of chapters 3 and 4 of J. Mašek, Modelling of free beam loaded by follower load "
    "(Brno 2014), beside what its own model gives: by its own method, a simulation, and exactly, "
    "by eigenvalues or in equilibrium; and beside the continuum that the links approximate.",
    "Verdicts are computed from the numbers of each row. A printed value agrees to k digits where "
    "it differs from ours by no more than half a unit of its k-th digit, its own rounding allowed "
    "for. It counts as reproduced where all its digits agree, that is, where ours rounds to it: "
    "the one limit that the print itself sets. Else the verdict says by how much it is off, and "
    "how many digits agree; how many deviations are how large is counted in decades.",
)


ROUNDED = "Reproduced: the column '{}', rounded to the printed digits."
RULES = {
    "4.1": "Reproduced: the theory's limit, damped as assumed, rounded down to the printed digits.",
    "4.2": "Run times on another machine and over a span that is not given: nothing is called "
    "reproduced.",
}
OPEN = (
    f"The mass of the rod in 3.3 and 4.2: {scenes.MASS:g} kg, from a fit to table 4.1. It does not "
    "enter a critical force without damping, only how fast flutter grows.",
    "Damping, everywhere: none, but where a table says otherwise below it.",
    "How the rod is disturbed, how much, and what counts as unstable: said below each table.",
    "How frequencies are read from the FFT: a sine^6 window, peaks between the bins.",
    "The span of the runs in 4.2: 200 s, that of 3.3.",
    f"The axial stiffness of the mass-spring model: EA = {scenes.AXIAL_STIFFNESS:.4g} N, from the "
    "section of 3.1.",
    "The machine and the version of Java: run times are compared in their growth alone.",
)
MEANINGS = {
    "shown": "follows from the numbers here",
    "estimated": "rests on run times that were measured over less and multiplied, as is said",
    "consistent": "a hypothesis that fits; others may fit as well",
    "refuted": "a hypothesis that was tried and does not give the printed values",
    "open": "not explained",
    "found": "what was found about the print itself",
}


def write_thesis(folder: Path, tables: Sequence[ThesisTable], seconds: float) -> Path:
    """Write index.html, a CSV file for each table and the figures; returns the page.

    seconds: what the tables took. Everything is made before anything is put into the folder, and
    the page comes last.
    """
    with put_whole(folder) as made:
        figures = save_figures({table.number: table for table in tables}, made)
        for table in tables:
            write_whole(made / csv_name(table), csv_text(table))
        write_whole(made / PAGE, html(tables, figures, seconds))
    return folder / PAGE


def html(tables: Sequence[ThesisTable], figures: dict[str, str], seconds: float) -> str:
    """The page; figures: files by number."""
    return render(
        TEMPLATE,
        introduction=INTRODUCTION,
        open=OPEN,
        meanings=MEANINGS,
        tables=[_table(table, figures) for table in tables],
        made=made_with(seconds),
    )


def csv_text(table: ThesisTable) -> str:
    """A table with all digits; the head has the titles and units."""
    titles = {column.key: column.title for column in table.columns}
    return str(table.rows[list(titles)].rename(columns=titles).to_csv(index=False))


def csv_name(table: ThesisTable) -> str:
    """Name the file of a table beside the page."""
    return f"table_{table.number.replace('.', '_')}.csv"


def made_with(seconds: float) -> str:
    """Versions, processor and time, in a line."""
    packages = ", ".join(
        f"{name} {version(name)}" for name in ("rodgen", "numpy", "scipy", "mpmath")
    )
    return (
        f"Made with {packages}, Python {platform.python_version()} on {processor()}, "
        f"{os.cpu_count()} cores, in {seconds:.0f} s."
    )


def _table(table: ThesisTable, figures: dict[str, str]) -> dict[str, Any]:
    numbered = table.number[0].isdigit()
    compared = (
        ROUNDED.format(c.title.split(" [")[0]) for c in table.columns if c.key == "discrete"
    )
    return {
        "number": table.number,
        "anchor": f"table-{table.number.replace('.', '-')}",
        "title": table.title,
        "heading": f"Table {table.number}: {table.title}" if numbered else table.title,
        "reproduced": summary(table),
        "deviations": deviations(table),
        "conditions": table.conditions,
        "assumed": table.assumed,
        "rule": next(compared, RULES.get(table.number, "")),
        "shown": shown("", records(table.rows), table.columns),
        "notes": table.notes,
        "figures": [
            {"number": number, "file": figures[number], "caption": picture.caption}
            for number, picture in FIGURES.items()
            if picture.below == table.number and number in figures
        ],
        "csv": csv_name(table),
        "seconds": f"{table.seconds:.1f}",
    }


def deviations(table: ThesisTable) -> str:
    """Describe how many printed values are off by how much from the discrete model."""
    return by_size(table.rows["deviation"].dropna()) if "deviation" in table.rows else ""


def summary(table: ThesisTable) -> str:
    """Describe how many rows are reproduced to all printed digits."""
    if "verdict" in table.rows:
        verdicts = table.rows["verdict"].dropna()
        comparable = verdicts[~verdicts.str.startswith(INCOMPARABLE)]
        if len(comparable):
            return f"{comparable.str.startswith('reproduced').sum()} of {len(comparable)}"
    return "no values to reproduce"  # run times, or no printed values
