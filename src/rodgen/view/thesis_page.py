"""The tables of the thesis as one HTML page that needs no network, with CSV and pictures."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rodgen.judge.surroundings import processor
from rodgen.loading.cache import write_whole
from rodgen.thesis import critical, frequencies, mass_spring_table, scenes, statics
from rodgen.thesis.table import INCOMPARABLE, Column, Table, by_size
from rodgen.view.pages import PAGE, csv_lines, put_whole, render
from rodgen.view.thesis_figures import CAPTIONS, save_figures

TEMPLATE = "pages/thesis.html.jinja"
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


def _rounded(columns: Sequence[Column]) -> str:
    """The rule of a table whose verdicts compare with the discrete model."""
    (title,) = (column.title for column in columns if column.key == "discrete")
    return f"Reproduced: the column '{title}', rounded to the printed digits."


RULES = {
    "3.1": _rounded(frequencies.COLUMNS_3_1),
    "3.2": _rounded(frequencies.COLUMNS_3_2),
    "3.3": _rounded(statics.COLUMNS),
    "3.4": _rounded(critical.COLUMNS_3_4),
    "3.5": _rounded(mass_spring_table.COLUMNS),
    "3.6": _rounded(critical.COLUMNS_3_6),
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
OF_TABLE = {"3.2": ("3.1", "3.2"), "3.3": ("3.3",), "3.5": ("3.4", "3.5"), "3.6": ("3.6",)} | {
    number: (number,) for number in ("4.1", "4.2")
}


def write_thesis(folder: Path, tables: Sequence[Table], seconds: float) -> Path:
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


def html(tables: Sequence[Table], figures: dict[str, str], seconds: float) -> str:
    """The page; figures: files by number."""
    return render(
        TEMPLATE,
        introduction=INTRODUCTION,
        open=OPEN,
        meanings=MEANINGS,
        tables=[_table(table, figures) for table in tables],
        made=made_with(seconds),
    )


def csv_text(table: Table) -> str:
    """A table with all digits; the head has the titles and units."""
    cells = [[row.get(column.key) for column in table.columns] for row in table.rows]
    return csv_lines(_head(table), cells)


def csv_name(table: Table) -> str:
    """Its file beside the page."""
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


def _head(table: Table) -> list[str]:
    return [f"{c.title} [{c.unit}]" if c.unit else c.title for c in table.columns]


def _table(table: Table, figures: dict[str, str]) -> dict[str, Any]:
    numbered = table.number[0].isdigit()
    shown = [number for number in OF_TABLE.get(table.number, ()) if number in figures]
    return {
        "number": table.number,
        "anchor": f"table-{table.number.replace('.', '-')}",
        "title": table.title,
        "heading": f"Table {table.number}: {table.title}" if numbered else table.title,
        "reproduced": summary(table),
        "deviations": deviations(table),
        "conditions": table.conditions,
        "assumed": table.assumed,
        "rule": RULES.get(table.number, ""),
        "head": _head(table),
        "body": [
            [
                {
                    "text": column.text(row.get(column.key)),
                    "kind": "text" if isinstance(row.get(column.key), str) else "number",
                }
                for column in table.columns
            ]
            for row in table.rows
        ],
        "notes": table.notes,
        "figures": [{"number": n, "file": figures[n], "caption": CAPTIONS[n]} for n in shown],
        "csv": csv_name(table),
        "seconds": f"{table.seconds:.1f}",
    }


def deviations(table: Table) -> str:
    """How many printed values are off by how much from the discrete model."""
    return by_size([x for x in table.column("deviation") if not math.isnan(x)])


def summary(table: Table) -> str:
    """How many rows are reproduced to all printed digits, in a few words."""
    verdicts = [str(row["verdict"]) for row in table.rows if row.get("verdict")]
    comparable = [text for text in verdicts if not text.startswith(INCOMPARABLE)]
    if not comparable:  # run times, or no printed values
        return "no values to reproduce"
    return f"{sum(text.startswith('reproduced') for text in comparable)} of {len(comparable)}"
