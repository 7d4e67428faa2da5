"""rodgen study: a scene at many values, its results in a store."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import drawn, out, print_values, working
from rodgen.cli.errors import BAD_INPUT, FAILED_RUN, INTERRUPTED, fail
from rodgen.cli.options import OutFolder
from rodgen.cli.signals import end_as_by_ctrl_c, hold_back_ctrl_c

STORE = "study.zarr"
SHOW = "show"


def study(
    given: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE | show STORE",
            help="A study, in TOML; or the store of one, whose pictures are drawn again.",
        ),
    ],
    out_folder: OutFolder = Path("results"),
    workers: Annotated[
        int | None,
        typer.Option(help="By default one a processor, of short studies 1, without Dask."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Of a Dask scheduler, whose workers are taken."),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the store of FILE, if there is one.")
    ] = False,
    adaptive: Annotated[
        float | None,
        typer.Option(
            metavar="WIDTH",
            help="Of a map of two axes, compute only what is needed to find where neighbours "
            "differ, to this share of an axis.",
        ),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(help="With --adaptive: in what they differ, such as stable or 'max(x) > 1'."),
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="Also where there are more than 1e8 points.")
    ] = False,
) -> None:
    """Compute the study in FILE: a scene at many values of its keys, on all processors or on a
    cluster; keep what comes out in a Zarr store, and draw it."""
    from rodgen.studies.engine import check_extra, run
    from rodgen.studies.errors import StudyError
    from rodgen.studies.specification import Study

    try:
        check_extra()
    except ImportError as error:
        fail(str(error), BAD_INPUT)
    if given[0] == SHOW and len(given) == 2:
        _draw(Path(given[1]))
        return
    if len(given) != 1:
        fail("one study is computed at a time: rodgen study FILE, or rodgen study show STORE", 2)
    with working("checking"):
        made = Study.from_toml(given[0])
    store = out_folder / made.name / STORE
    end_as_by_ctrl_c()
    why, status = "", 0
    try:
        run(
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
        hold_back_ctrl_c()
        why, status = "interrupted", INTERRUPTED
    if status:
        fail(f"{why}; {_kept(store)}", status)
    _summarise(made.name, store)
    _draw(store)


def _kept(store: Path) -> str:
    """What a study that came to no end leaves."""
    from rodgen.studies.tally import tally

    if not store.exists():
        return "nothing was computed yet"
    found = tally(store)
    what = f"{found.computed} of {found.points} points are kept in {store}"
    return f"{what}; --resume goes on with them"


def _summarise(name: str, store: Path) -> None:
    from rodgen.studies.tally import tally

    print_values(f"{name}: points", tally(store).rows)


def _draw(store: Path) -> None:
    """Draw pictures of a store beside it."""
    from rodgen.show.study_pictures import draw
    from rodgen.studies.store import read

    written = [store]
    if drawn():
        with working("drawing"):
            written += draw(read(store), store.absolute().parent)
    out.print(f"Written: {', '.join(map(str, written))}")
