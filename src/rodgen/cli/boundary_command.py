"""rodgen boundary: where flutter or divergence begins, in the plane of two numbers of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodgen.cli.console import check_finite
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
from rodgen.cli.result_folders import output_folder
from rodgen.scene import Scene

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

NAME = "boundary"  # of its files


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
    at: PointNumber = None,
    step: LongestStep = 0.1,
    most: MostPoints = 1000,
    t: AtTime = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Follow the boundary of stability of SCENE while two of its numbers change, and draw it.

    The boundary includes the limit of vanishing damping.
    """
    from rodgen.analyse.branches.stability_boundary import read, stability_boundary
    from rodgen.errors import InputError

    keys = vary.split(",")
    if len(keys) != 2:
        raise InputError("--vary", vary, "two numbers of the scene with a comma between them")
    check_finite("--t", t)
    given = [_parse_range(text) for text in bounds or ()]
    if len(given) > len(keys):
        raise InputError("--bounds", bounds, "given once for each number, twice at most")
    ranges = (*given, None, None)[:2]
    file = None if as_json else out_folder / scene.name / f"{NAME}.nc"
    command: dict[str, Any] = {"command": NAME, "scene": scene.to_dict(), "vary": vary}
    command |= {"bounds": ranges, "step": step, "most": most, "t": t}
    going = find_start(resume, at, read, file, command)
    with output_folder(None if as_json else out_folder / scene.name) as folder:
        made = follow_curve(
            "the boundary",
            lambda said: stability_boundary(
                scene,
                (keys[0], keys[1]),
                bounds=(ranges[0], ranges[1]),
                step=step,
                most=most,
                t=t,
                resume=going.curve,
                at=going.at,
                watch=lambda point: said(f"{point[0]:.6g}, {point[1]:.6g}"),
            ),
            going.journal,
        )
        found = made.data
        title = f"{scene.name}: boundary of stability"
        made.print_and_write(title, file and folder / file.name, lambda: _draw_curve(found, scene))
        made.exit_if_incomplete(file)


def _draw_curve(found: xarray.Dataset, scene: Scene) -> Figure:
    from rodgen.show.branch_pictures import boundary_curve

    return boundary_curve(found, scene)


def _parse_range(text: str) -> tuple[float, float] | None:
    """Parse the range of a number; None where neither end is given."""
    return None if parse_bounds(text) == (None, None) else parse_both_bounds(text)
