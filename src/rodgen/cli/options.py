"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, in TOML.")]
AtTime = Annotated[
    float | None, typer.Option("--t", help="Time whose loads are taken [s]; the end of the span.")
]
Speed = Annotated[
    float | None,
    typer.Option(
        help="Speed of a free rod along its axis, nose first [m/s]; that of its initial state, if "
        "not given."
    ),
]
After = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Time of a run of SCENE whose loads, speed and direction are taken.",
    ),
]
OutFolder = Annotated[
    Path, typer.Option("--out", help="Folder in which a folder of the scene's name is made.")
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object, and no table and picture.")
]
