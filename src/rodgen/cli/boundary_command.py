"""rodgen boundary: where flutter or divergence begins, in the plane of two numbers of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.curve_options import find_start, follow_curve
from rodgen.cli.options import (
    AsJson,
    AtTime,
    LongestStep,
    MostPoints,
    OutFolder,
    PointNumber,
    ResumeFile,
    parse_both_bounds,
    parse_bounds,
)
from rodgen.errors import InputError
from rodgen.scene import Scene

NAME = "boundary"  # of the command and its files


def boundary(
    scene: Scene,
    vary: Annotated[
        str,
        typer.Option(
            metavar="A,B",
            help="Both numbers, such as loads.follower.force,loads.material_damping.time.",
        ),
    ],
    bounds: Annotated[
        list[str] | None,
        typer.Option(
            metavar="A,B",
            help="Range of the first number; given again, of the second. Default: from 0 on, also "
            "where it is a comma alone.",
        ),
    ] = None,
    resume: ResumeFile = None,
    point: PointNumber = None,
    step: LongestStep = 0.1,
    max_points: MostPoints = 1000,
    t: AtTime = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Follow the boundary of stability of SCENE while two of its numbers change, and draw it.

    The boundary includes the limit of vanishing damping.
    """
    from rodgen.analyse.branches.stability_boundary import FORMAT, stability_boundary

    keys = vary.split(",")
    if len(keys) != 2:
        raise InputError("--vary", vary, "two numbers of the scene with a comma between them")
    given = [_parse_range(text) for text in bounds or ()]
    if len(given) > len(keys):
        raise InputError("--bounds", bounds, "given once for each number, twice at most")
    ranges = (*given, None, None)[:2]
    file = out_folder / scene.name / f"{NAME}.nc"
    options = {"vary": vary, "bounds": ranges, "step": step, "max_points": max_points, "t": t}
    begun = find_start(NAME, scene, options, file, as_json, resume, point, FORMAT.read)
    follow_curve(
        "the boundary",
        f"{scene.name}: boundary of stability",
        file,
        as_json,
        begun,
        lambda said: stability_boundary(
            scene,
            (keys[0], keys[1]),
            bounds=(ranges[0], ranges[1]),
            step=step,
            max_points=max_points,
            t=t,
            resume=begun.curve,
            point=begun.point,
            callback=lambda at: said(f"{at[0]:.6g}, {at[1]:.6g}"),
        ),
    )


def _parse_range(text: str) -> tuple[float, float] | None:
    """Parse the range of a number; None where neither end is given."""
    return None if parse_bounds(text) == (None, None) else parse_both_bounds(text)
