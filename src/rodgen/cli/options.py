"""Options that several commands share."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.completion import complete_keys

AtTime = Annotated[
    float | None,
    typer.Option(
        "--t",
        help="Time within the span at which loads are taken [s]. Default: the start of the span.",
    ),
]
CheckMesh = Annotated[
    bool,
    typer.Option(
        "--check-mesh",
        help="Also compute with twice as many links, and say what changes by more than 1 %.",
    ),
]
Speed = Annotated[
    float | None,
    typer.Option(
        help="Speed of a free rod along its axis, nose first [m/s]. Default: that of the initial "
        "state."
    ),
]
After = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Take loads, speed and direction from a run of SCENE after this time.",
    ),
]
OutFolder = Annotated[
    Path,
    typer.Option(
        "--out", help="Folder for results. A folder of the scene's or study's name is made in it."
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object instead of tables and pictures.")
]
Bounds = Annotated[str, typer.Option("--bounds", metavar="A,B", help="Range of the number.")]
Vary = Annotated[
    str,
    typer.Option(
        metavar="KEY",
        help="Number that is varied, such as loads.follower.force.",
        autocompletion=complete_keys,
    ),
]
ResumeFile = Annotated[
    Path | None,
    typer.Option(
        "--resume",
        metavar="FILE",
        help="Continue the same command, which was stopped and writes FILE, where it was; or the "
        "curve in FILE of such a command from its last point.",
    ),
]
PointNumber = Annotated[
    int | None, typer.Option("--at", help="Number of a point of FILE. Default: the last.")
]
LongestStep = Annotated[
    float, typer.Option("--step", help="Longest step along the curve, as a share of the range.")
]
Segments = Annotated[int, typer.Option(help="Number of parts into which the period is cut.")]
MostPoints = Annotated[int, typer.Option("--most", help="Largest number of points, to each side.")]
LAST = -1  # the number of a point, if not given


def parse_bounds(text: str) -> tuple[float | None, float | None]:
    """Parse a range that is given as A,B, either of which may be left out. Raises InputError."""
    from rodgen.errors import InputError

    parts = text.split(",")
    try:
        low, high = (float(part) if part.strip() else None for part in parts)
    except ValueError:
        raise InputError("--bounds", text, "two numbers, as 0,20") from None
    if any(one is not None and not math.isfinite(one) for one in (low, high)):
        raise InputError("--bounds", text, "two finite numbers, as 0,20")
    return low, high


def parse_both_bounds(text: str) -> tuple[float, float]:
    """Parse a range that is given as A,B, both of which are needed. Raises InputError."""
    from rodgen.errors import InputError

    low, high = parse_bounds(text)
    if low is None or high is None:
        raise InputError("--bounds", text, "two numbers, as 0,20: the range of the number")
    return low, high


def point_number(file: Path | None, at: int | None, option: str) -> int:
    """Number of a point of a file, by default the last; option: gives the file. Raises InputError
    for a number without a file."""
    from rodgen.errors import InputError

    if at is not None and file is None:
        raise InputError("--at", at, f"given with {option}, the file whose point it is")
    return LAST if at is None else at
