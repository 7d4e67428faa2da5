"""rodgen exponents: Lyapunov exponents of the motion of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import print_json, print_result, show_run, write_picture
from rodgen.cli.options import AsJson, OutFolder
from rodgen.cli.result_folders import output_folder
from rodgen.scene import Scene


def exponents(
    scene: Scene,
    count: Annotated[
        int | None,
        typer.Option(help="Number of exponents, from the largest on. Default: all."),
    ] = None,
    span: Annotated[
        float | None,
        typer.Option(
            help="Length of the motion from the start of SCENE [s]. Default: the scene's span."
        ),
    ] = None,
    transient: Annotated[
        float | None,
        typer.Option(help="Time at the start that is left out [s]. Default: a tenth of the span."),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Compute the Lyapunov exponents of SCENE: how fast neighbouring motions come apart."""
    from rodgen.analyse.chaos.lyapunov import lyapunov_exponents

    start, end = scene.integrate.span
    length = end - start if span is None else span
    with output_folder(None if as_json else out_folder / scene.name) as folder:
        with show_run(scene.name, start, start + length) as step:
            found = lyapunov_exponents(
                scene, count=count, span=span, transient=transient, progress=step
            )
        if as_json:
            print_json(found.to_dict())
            return
        print_result(f"{scene.name}: Lyapunov exponents", found)
        from rodgen.show.exponent_pictures import convergence

        write_picture(lambda: convergence(found, scene.name), folder, "exponents")
