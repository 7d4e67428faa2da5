"""rodgen animate: a result as a film."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import err, out, progress, warn, working
from rodgen.cli.options import bounds_of
from rodgen.cli.results import writable
from rodgen.cli.signals import end_as_by_ctrl_c
from rodgen.show.animation.times import LEAST_PIXELS, MOST_PIXELS

PIXELS = f"Number of pixels, even, from {LEAST_PIXELS} to {MOST_PIXELS}."


def animate(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="A result, in NetCDF.")],
    out_file: Annotated[Path, typer.Option("--out", help="File of the film, .mp4 or .gif.")],
    fps: Annotated[float, typer.Option(help="Frames a second.")] = 30.0,
    speed: Annotated[
        float | None,
        typer.Option(
            help="Simulated seconds in a second of film. Default: 1, if the film then takes 3 to "
            "60 s."
        ),
    ] = None,
    width: Annotated[int, typer.Option(help=PIXELS)] = 1280,
    height: Annotated[int, typer.Option(help=PIXELS)] = 720,
    view: Annotated[
        str | None,
        typer.Option(
            help="fixed, centre (moves with the centre of gravity) or axes (also turns with the "
            "principal axes). Default: fixed, if the rod is then large enough."
        ),
    ] = None,
    bounds: Annotated[
        str | None,
        typer.Option(
            metavar="A,B", help="Times between which the film shows the run [s]. Default: all."
        ),
    ] = None,
    damaged: Annotated[
        bool, typer.Option("--damaged", help="Draw the readable part of a damaged result.")
    ] = False,
) -> None:
    """Draw the run in RESULT as a film: a GIF, or an MP4, which needs ffmpeg."""
    from rodgen.integrate.files.reader import Excerpt
    from rodgen.loading import build_fastest
    from rodgen.show.animation.files import check_file
    from rodgen.show.animation.film import film
    from rodgen.show.animation.times import Settings, plan

    between = (None, None) if bounds is None else bounds_of(bounds)
    settings = Settings(fps, speed, view, width, height, between)
    check_file(out_file, settings)
    writable(out_file.parent)  # before the frames are drawn, which takes long
    stored = Excerpt(result, strict=not damaged)
    for note in stored.notes:
        warn(note)
    times = plan(stored.t, settings).times
    with working("generating"):
        stored.model = build_fastest(stored.scene)
    end_as_by_ctrl_c()
    with progress(out_file.name, float(times[0]), float(times[-1])) as update:
        made = film(stored.t, stored.at, out_file, settings, update)
    for note in made.notes:
        err.print(f"rodgen: {note}")
    taken = f"speed {made.speed:g}{'' if speed else ' (chosen)'}"
    taken += f", view {made.view}{'' if view else ' (chosen)'}"
    frames = f"{made.frames} frames of {width} x {height}, {made.seconds:.4g} s"
    out.print(f"Written: {out_file}: {frames}, {taken}.")
