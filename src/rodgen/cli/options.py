"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

AtTime = Annotated[
    float | None,
    typer.Option(
        "--t", help="Time of the span whose loads are taken [s]; its start, if not given."
    ),
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
    Path,
    typer.Option("--out", help="Folder in which a folder of the scene's or study's name is made."),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object, and no table and picture.")
]
Vary = Annotated[
    str, typer.Option(metavar="KEY", help="The number that is varied: loads.follower.force.")
]
ResumeFile = Annotated[
    Path | None,
    typer.Option(
        "--resume",
        metavar="FILE",
        help="Go on with the curve in this file of the same command, from its last point.",
    ),
]
PointNumber = Annotated[
    int | None, typer.Option("--at", help="Number of the point of FILE; its last, if not given.")
]
LongestStep = Annotated[
    float, typer.Option("--step", help="The longest step along the curve, as a share of its range.")
]
MostPoints = Annotated[int, typer.Option("--most", help="Points at most, to either side.")]
LAST = -1  # the number of a point, if not given


def point_of(file: Path | None, at: int | None, option: str) -> int:
    """The number of a point of a file, given with that option. Raises SceneError for one without a
    file."""
    from rodgen.scene import SceneError

    if at is not None and file is None:
        raise SceneError("--at", at, f"given with {option}, the file whose point it is")
    return LAST if at is None else at
