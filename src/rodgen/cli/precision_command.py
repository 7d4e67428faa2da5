"""rodgen precision: error against run time of methods on a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import show_work
from rodgen.cli.options import AsJson, OutFolder
from rodgen.cli.result_folders import delivery
from rodgen.scene import Scene

HELD_BY = "end", "angles", "rates", "tail"


def precision(
    scene: Scene,
    seconds: Annotated[
        float, typer.Option(help="Approximate duration, without building the module [s].")
    ] = 40.0,
    of: Annotated[
        str | None,
        typer.Option(
            help=f"Errors to hold methods by: {', '.join(HELD_BY)} [default: end; of a rod that "
            "does not turn: tail]."
        ),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Measure error against run time on SCENE, for methods of rodgen and SciPy, and draw it."""
    from rodgen.analyse.precision.work_precision import work_precision

    with delivery(scene, out_folder, as_json) as deliver:
        with show_work("measuring") as step:
            found = work_precision(scene, seconds=seconds, of=of, progress=step)
        deliver("error against run time", found, {"precision": "diagram"})
