"""rodgen exponents: Lyapunov exponents of the motion of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import show_run
from rodgen.cli.options import AsJson, OutFolder
from rodgen.cli.result_folders import delivery
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
    with delivery(scene, out_folder, as_json) as deliver:
        with show_run(scene.name, start, start + length) as step:
            found = lyapunov_exponents(
                scene, count=count, span=span, transient=transient, progress=step
            )
        deliver("Lyapunov exponents", found, {"exponents": "means"})
