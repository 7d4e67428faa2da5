"""rodgen study: a scene at many values, its results in a store."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import out, picture_settings, print_json, print_result, show_work
from rodgen.cli.exits import (
    BAD_INPUT,
    FAILED_RUN,
    INTERRUPTED,
    fail,
    ignore_ctrl_c,
    treat_signals_as_ctrl_c,
)
from rodgen.cli.options import AsJson, OutFolder

if TYPE_CHECKING:
    from rodgen.show.picture_settings import PictureSettings
    from rodgen.studies.counts import PointCounts

STORE = "study.zarr"
SHOW = "show"


def study(
    given: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE | show STORE",
            help="A study, in TOML; or show and a store, whose pictures are drawn again.",
        ),
    ],
    out_folder: OutFolder = Path("results"),
    workers: Annotated[
        int | None,
        typer.Option(
            help="Worker processes. Default: one for each processor; for short studies 1, "
            "without Dask."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Address of a Dask scheduler, whose workers compute the study."
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue the store of FILE, if there is one.")
    ] = False,
    adaptive: Annotated[
        float | None,
        typer.Option(
            metavar="WIDTH",
            help="For a map of two axes: compute only the points that locate where neighbours "
            "differ, to this share of an axis.",
        ),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(
            help="With --adaptive: the quantity in which neighbours differ, such as stable or "
            "'max(x) > 1'."
        ),
    ] = None,
    time_limit: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Time that a point may take. Default: that of FILE, or no limit.",
        ),
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="Compute a study of more than 1e8 points.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Compute the study in FILE: a scene at many values of its keys.

    The study runs on all processors or on a cluster. Results are kept in a Zarr store, and drawn.
    """
    from rodgen.errors import StudyError
    from rodgen.studies.engine import check_extra, run_study
    from rodgen.studies.study import Study
    from rodgen.studies.time_limit import check_limit

    try:
        check_extra()
    except ImportError as error:
        fail(str(error), BAD_INPUT)
    if given[0] == SHOW and len(given) == 2:
        store = Path(given[1])
        _report_store(store.absolute().parent.name, store, as_json)
        return
    if len(given) != 1:
        fail("one study is computed at a time: rodgen study FILE, or rodgen study show STORE", 2)
    with show_work("checking"):
        made = Study.from_toml(given[0])
        if time_limit is not None:
            made = replace(made, time_limit=check_limit(time_limit, "--time-limit"))
    store = out_folder / made.name / STORE
    treat_signals_as_ctrl_c()
    why, status = "", 0
    try:
        run_study(
            *(made, store),
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            adaptive=adaptive,
            by=by,
            yes=yes,
            said=out.print,
        )
    except StudyError as error:
        why, status = str(error), FAILED_RUN
    except KeyboardInterrupt:
        ignore_ctrl_c()
        why, status = "interrupted", INTERRUPTED
    if status:
        fail(f"{why}; {_describe_store(store)}", status)
    found = _report_store(made.name, store, as_json)
    if found.failed + found.too_long == found.computed:
        ((why, _),) = found.reasons.most_common(1)
        fail(f"all {found.computed} points failed; the most frequent reason: {why}", FAILED_RUN)


def _describe_store(store: Path) -> str:
    """Words on what an unfinished study leaves."""
    from rodgen.studies.counts import count_points

    if not store.exists():
        return "nothing was computed yet"
    found = count_points(store)
    what = f"{found.computed} of {found.points} points are kept in {store}"
    return f"{what}; --resume goes on with them"


def _report_store(name: str, store: Path, as_json: bool) -> PointCounts:
    """Count the points of a store, print the counts, and draw its pictures beside it."""
    from rodgen.studies.counts import count_points

    found = count_points(store)
    if not as_json:
        print_result(f"{name}: points", found)
    settings = picture_settings()
    pictures = _draw_store(store, settings) if settings else []
    if as_json:
        files = {"store": str(store), "pictures": [str(path) for path in pictures]}
        print_json(found.to_dict() | files)
    else:
        out.print(f"Written: {', '.join(map(str, [store, *pictures]))}")
    return found


def _draw_store(store: Path, settings: PictureSettings) -> list[Path]:
    """Draw pictures of a store beside it."""
    from rodgen.show.study_pictures import save_study_pictures
    from rodgen.studies.store import read_store

    with show_work("drawing"):
        return save_study_pictures(read_store(store), store.parent, settings)
