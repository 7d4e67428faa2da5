"""rodgen report: error against run time, costs, stability, extremes."""

from __future__ import annotations

import signal
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import out, show_work
from rodgen.cli.exits import FAILED_RUN, fail
from rodgen.cli.result_folders import make_writable
from rodgen.errors import InputError
from rodgen.scene import Scene

if TYPE_CHECKING:
    from rodgen_evidence.report.cases import Case


def report(
    scene_files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[SCENE]...", help="Scenes, in TOML. Default: a fixed set."),
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option(help="Section to measure. Can be given several times.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Measure fewer scenes, settings and cases.")
    ] = False,
    resumed: Annotated[
        bool, typer.Option("--resume", help="Keep the measurements that the folder already has.")
    ] = False,
    out_folder: Annotated[
        Path, typer.Option("--out", help="Folder for the page, tables and pictures.")
    ] = Path("results/report"),
) -> None:
    """Compare methods, steps, forms and other programs, and show how far to trust the numbers.

    Without a SCENE, the report has a fixed set of scenes, costs, stability and extreme cases. It
    takes half an hour on two cores, with --quick three minutes. Other programs take part if
    installed.
    """
    from rodgen_evidence.pages.report_page import write_report
    from rodgen_evidence.report.sections import OF_SCENES, SECTIONS, measure, required_sections
    from rodgen_evidence.report.surroundings import machine, versions
    from rodgen_evidence.report.unit import Measured

    cases = _cases(scene_files or [], quick)
    chosen = only or list(OF_SCENES if scene_files else SECTIONS)
    if unknown := [name for name in chosen if name not in SECTIONS]:
        raise InputError("--only", unknown[0], f"one of {', '.join(SECTIONS)}")
    folder = make_writable(out_folder)
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    begin = time.perf_counter()
    failures: Counter[str] = Counter()
    with show_work("measuring") as step:

        def done(one: Measured) -> None:
            failures[one.section] += bool(one.failed)
            step(f"{one.name}{f': {one.failed}' if one.failed else ''}")

        found = measure(cases, folder, chosen, quick=quick, resume=resumed, done=done)
    made = {
        "versions": versions(),
        "machine": machine(),
        "seconds": time.perf_counter() - begin,
        "quick": quick,
        "scenes": {case.name: case.why for case in cases},
    }
    page = write_report(folder, found, made)
    for section in required_sections(chosen):
        failed = failures[section]
        count = sum(len(one.rows) for one in found[section])
        out.print(f"{section:14} {count:5d} rows{f', {failed} units failed' if failed else ''}")
    out.print(f"written: {page}")
    rows = (row for one in found.get("references", []) for row in one.rows)
    if lost := [str(row["scene"]) for row in rows if row["failed"]]:
        fail(f"without a reference nothing can be judged: {', '.join(lost)}", FAILED_RUN)


def _cases(files: list[Path], quick: bool) -> list[Case]:
    """Cases of scene files, or the fixed set."""
    from rodgen_evidence.report import cases

    if not files:
        return cases.cases(quick)
    scenes = [Scene.from_toml(file) for file in files]
    names = Counter(scene.name for scene in scenes)
    for scene in scenes:
        if names[scene.name] > 1:
            raise InputError("name", scene.name, "another name for every scene of a report")
    found = zip(scenes, files, strict=True)
    return [cases.Case(scene.model_dump(exclude_none=True), file.name) for scene, file in found]
