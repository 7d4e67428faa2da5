"""rodgen animate: a result as a film."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import err, out, show_run, show_work, warn
from rodgen.cli.exits import treat_signals_as_ctrl_c
from rodgen.cli.options import parse_bounds
from rodgen.cli.result_folders import make_writable
from rodgen.show.animation.frame_times import LEAST_PIXELS, MOST_PIXELS

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
    from rodgen.integrate.files.file_layout import native_copy
    from rodgen.integrate.files.reader import solution_of
    from rodgen.integrate.files.result_file import ResultFile
    from rodgen.loading import build_fastest
    from rodgen.show.animation.film import write_film
    from rodgen.show.animation.film_files import check_file
    from rodgen.show.animation.frame_times import FilmSettings, plan_frames

    between = (None, None) if bounds is None else parse_bounds(bounds)
    settings = FilmSettings(fps, speed, view, width, height, between)
    check_file(out_file, settings)
    make_writable(out_file.parent)  # before the frames are drawn, which takes long
    with ResultFile(result, strict=not damaged) as file:
        records, good = file.samples()
        planned = plan_frames(native_copy(records["time"][good]), settings)
        solution = solution_of(file, records, good[planned.kept])
    for note in file.notes:
        warn(note)
    with show_work("generating"):
        solution.model = build_fastest(solution.scene)
    treat_signals_as_ctrl_c()
    times = planned.times
    with show_run(out_file.name, float(times[0]), float(times[-1])) as update:
        made = write_film(solution, planned, out_file, settings, update)
    for note in made.notes:
        err.print(f"rodgen: {note}")
    taken = f"speed {made.speed:g}{'' if speed else ' (chosen)'}"
    taken += f", view {made.view}{'' if view else ' (chosen)'}"
    frames = f"{made.frames} frames of {width} x {height}, {made.seconds:.4g} s"
    out.print(f"Written: {out_file}: {frames}, {taken}.")
