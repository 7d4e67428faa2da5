"""rodgen linearise: matrices between inputs and outputs of a scene, for its control."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import show_work
from rodgen.cli.options import AsJson, AtTime, OutFolder, Speed
from rodgen.cli.result_folders import delivery
from rodgen.errors import InputError
from rodgen.scene import Scene


def linearise(
    scene: Scene,
    inputs: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            metavar="KEY",
            help="What acts: a number of a load, such as loads.follower.angle or air.wind.0, an "
            "added state, such as states.gimbal, or a number of [parameters]. Can be given several "
            "times.",
        ),
    ] = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option(
            "--output",
            metavar="NAME",
            help="What is measured: a state, such as phi_3, a quantity, such as tip_x or "
            'bending_moment_3, or an expression of sensors, such as "omega(0.3)". Can be given '
            "several times. Default: all states.",
        ),
    ] = None,
    about: Annotated[
        str, typer.Option(metavar="steady|start", help="About which state of SCENE.")
    ] = "steady",
    t: AtTime = None,
    speed: Speed = None,
    after: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="About the state of a run of SCENE after this time."),
    ] = None,
    minimal: Annotated[
        bool,
        typer.Option("--minimal", help="Leave out what no input reaches or no output sees."),
    ] = False,
    modes: Annotated[
        int | None,
        typer.Option(help="Reduce the model to its lowest modes. The static gain is kept."),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option(
            "--csv",
            metavar="FILE",
            help="Write A, B, C and D as one table: a row for each state and output, a column for "
            "each state and input.",
        ),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Linearise SCENE: matrices A, B, C and D between inputs and outputs, and their frequency
    response."""
    from rodgen.analyse.linearisation import linearise as linear_model

    with delivery(scene, out_folder, as_json) as deliver:
        with show_work("linearising"):
            found = linear_model(
                scene, inputs or (), outputs, about=about, t=t, speed=speed, after=after
            )
            found = found.minimal() if minimal else found
            found = found if modes is None else found.reduce(modes)
        if csv is not None:
            try:
                found.to_csv(csv)
            except OSError as error:
                reason = error.strerror or str(error)
                raise InputError("--csv", str(csv), f"a file to write ({reason})") from None
        deliver("linear model", found, {"linear_model": "response"})
