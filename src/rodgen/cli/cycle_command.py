"""rodgen cycle: the periodic motion that a scene settles on, and its stability."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import show_work
from rodgen.cli.options import AsJson, CheckMesh, OutFolder, point_number
from rodgen.cli.result_folders import delivery
from rodgen.scene import Scene


def cycle(
    scene: Scene,
    method: Annotated[
        str | None,
        typer.Option(
            help="collocation (on a mesh of the period), shooting, or newton_picard (the leading "
            "multipliers alone). Default: collocation, for many links newton_picard."
        ),
    ] = None,
    multipliers: Annotated[
        int | None,
        typer.Option(metavar="K", help="Number of multipliers of newton_picard. Default: 10."),
    ] = None,
    segments: Annotated[
        int | None,
        typer.Option(help="Number of segments of shooting. Default: 4."),
    ] = None,
    start: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE",
            help="A branch of cycles that rodgen cycle-branch has written: begin with its cycle "
            "--point, stable or not, instead of a run. Without --point, begin with the cycle "
            "nearest to SCENE's own value, and find the cycle at this value.",
        ),
    ] = None,
    point: Annotated[
        int | None, typer.Option("--point", help="Number of a cycle of FILE, from 0. See --from.")
    ] = None,
    check_mesh: CheckMesh = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Find and draw the periodic motion that SCENE settles on, and its Floquet multipliers."""
    from rodgen.analyse.cycles.cycle_data import FORMAT
    from rodgen.analyse.cycles.periodic_motion import find_cycle

    point_number(start, point, "--from")
    with delivery(scene, out_folder, as_json) as deliver:
        with show_work("looking for a cycle"):
            found = find_cycle(
                scene,
                method=method,
                segments=segments,
                multipliers=multipliers,
                start=None if start is None else FORMAT.read(start),
                point=point,
                check_mesh=check_mesh,
            )
        deliver("cycle", found, {"cycle": "film", "multipliers": "multipliers"})
