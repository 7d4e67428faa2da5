"""rodgen modes: natural frequencies and mode shapes of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import show_work
from rodgen.cli.options import After, AsJson, AtTime, OutFolder, Speed
from rodgen.cli.result_folders import delivery
from rodgen.scene import Scene


def modes(
    scene: Scene,
    count: Annotated[int, typer.Option(help="Number of modes, from the lowest on.")] = 10,
    t: AtTime = None,
    speed: Speed = None,
    after: After = None,
    frozen: Annotated[
        bool,
        typer.Option(
            "--frozen/--steady",
            help="Whether to take the shape at the start, or --after a run, as if the rod stood"
            " still in it.",
        ),
    ] = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Compute the natural frequencies of SCENE about its steady state, and draw the mode shapes."""
    from rodgen.analyse.modes import natural_modes

    with delivery(scene, out_folder, as_json) as deliver:
        with show_work("linearising"):
            found = natural_modes(scene, count, t=t, speed=speed, after=after, frozen=frozen)
        deliver("natural frequencies", found, {"modes": "shapes"})
