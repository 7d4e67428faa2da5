"""rodgen thesis: the tables and figures of the thesis, rebuilt."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from rodgen.cli.console import out, show_work
from rodgen.cli.result_folders import make_writable


def thesis(
    out_folder: Annotated[
        Path, typer.Option("--out", help="Folder for the page, tables and figures.")
    ] = Path("results/thesis"),
) -> None:
    """Rebuild the tables and figures of the thesis beside exact values, in one to five minutes."""
    from rodgen_evidence.pages.thesis_page import deviations, summary, write_thesis
    from rodgen_evidence.thesis.rebuild import TABLES, rebuild

    folder = make_writable(out_folder)
    begin = time.perf_counter()
    with show_work("rebuilding", len(TABLES)) as step:
        tables = rebuild(lambda number: step(f"table {number}"))
    page = write_thesis(folder, tables, time.perf_counter() - begin)
    shown = Table(title="the thesis rebuilt")
    for column in ("table", "what it has", "to all printed digits", "deviations"):
        shown.add_column(column)
    for table in tables:
        shown.add_row(table.number, table.title, summary(table), deviations(table))
    out.print(shown)
    out.print(f"written: {page}")
