"""rodgen audit: every equation and every method of the thesis against what is derived."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from rodgen.cli.console import err, out, show_work
from rodgen.cli.result_folders import make_writable


def audit(
    out_folder: Annotated[
        Path, typer.Option("--out", help="Folder for the page and the tables.")
    ] = Path("results/audit"),
    as_json: Annotated[
        bool, typer.Option("--json", help="Print everything as one JSON object.")
    ] = False,
) -> None:
    """Compare the thesis's equations 2.1 to 2.65 and its listing with what is derived."""
    from rodgen_evidence.pages.audit_page import MEANING, counts, json_object, parts, write_audit
    from rodgen_evidence.thesis.audit import thesis_claims as thesis
    from rodgen_evidence.thesis.audit.java_steppers import stepper_orders

    folder = make_writable(out_folder)
    claims = len(thesis.equation_claims()) + len(thesis.listing_claims())
    with show_work("comparing", claims + 1) as step:
        findings = thesis.audit(step)
        orders = stepper_orders()
        step("orders of the steppers")
    page = write_audit(folder, findings, orders)
    if as_json:
        print(json.dumps(json_object(findings, orders), ensure_ascii=False))
        err.print(f"written: {page}")
        return
    groups = parts(findings)
    table = Table(title="verdicts")
    table.add_column("verdict")
    for part in groups:
        table.add_column(part.lower(), justify="right")
    for verdict in MEANING:
        numbers = (str(counts(some)[verdict]) for some in groups.values())
        table.add_row(verdict.value, *numbers)
    out.print(table)
    out.print(f"written: {page}")
