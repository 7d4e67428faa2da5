"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, in TOML.")]
AtTime = Annotated[
    float | None,
    typer.Option(
        "--t", help="Time of the span whose loads are taken [s]; its start, if not given."
    ),
]
OutFolder = Annotated[
    Path, typer.Option("--out", help="Folder in which a folder of the scene's name is made.")
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object, and no table and picture.")
]
