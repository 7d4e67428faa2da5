"""rodgen boundary: where flutter or divergence begins, in the plane of two numbers of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodgen.cli.console import finite, print_json, print_values
from rodgen.cli.curves import followed, going_on, numbers
from rodgen.cli.options import (
    AsJson,
    AtTime,
    LongestStep,
    MostPoints,
    OutFolder,
    PointNumber,
    ResumeFile,
)
from rodgen.cli.results import promised
from rodgen.scene import Scene

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

RANGE = "FROM:TO"
NAME = "boundary"  # of its files
_SPECIAL = ("kind", "a", "b", "frequency")


def boundary(
    scene: Scene,
    vary: Annotated[
        str,
        typer.Option(
            metavar="A,B",
            help="Both numbers, such as loads.follower.force,loads.material_damping.time.",
        ),
    ],
    first: Annotated[
        str | None,
        typer.Option("--a", metavar=RANGE, help="Range of A. Default: from 0 on."),
    ] = None,
    second: Annotated[
        str | None,
        typer.Option("--b", metavar=RANGE, help="Range of B. Default: from 0 on."),
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
    from rodgen.analyse.branches.boundary import read, stability_boundary
    from rodgen.errors import InputError

    keys = vary.split(",")
    if len(keys) != 2:
        raise InputError("--vary", vary, "two numbers of the scene with a comma between them")
    finite("--t", t)
    given = (("--a", first), ("--b", second))
    ranges = [(text and numbers(option, text, ":")) or None for option, text in given]
    file = None if as_json else out_folder / scene.name / f"{NAME}.nc"
    command: dict[str, Any] = {"command": NAME, "scene": scene.to_dict(), "vary": vary}
    command |= {"ranges": ranges, "step": step, "most": most, "t": t}
    going = going_on(resume, at, read, file, command)
    with promised(None if as_json else out_folder / scene.name) as folder:
        made = followed(
            "the boundary",
            lambda said: stability_boundary(
                scene,
                (keys[0], keys[1]),
                ranges=(ranges[0], ranges[1]),
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
        made.warn()
        if file is None:
            print_json(_object(found))
        else:
            from rodgen.show.dataset_tables import of_boundary

            print_values(f"{scene.name}: boundary of stability", of_boundary(found))
            made.write(folder, NAME, lambda: _curve(found, scene))
        made.stop(file)


def _curve(found: xarray.Dataset, scene: Scene) -> Figure:
    from rodgen.show.branch_pictures import boundary_curve

    return boundary_curve(found, scene)


def _object(found: xarray.Dataset) -> dict[str, Any]:
    names = ("a", "b", "frequency")
    rows = zip(*(found[name].values.tolist() for name in names), strict=True)
    attributes = {name: found.attrs[name] for name in ("a", "b", "kind", "end", "t")}
    points = [list(row) for row in rows]
    special = zip(*(found[f"special_{name}"].values.tolist() for name in _SPECIAL), strict=True)
    named = [dict(zip(_SPECIAL, one, strict=True)) for one in special]
    return {
        "points": points,
        "special": named,
        "complete": bool(found.attrs["complete"]),
        **attributes,
    }
