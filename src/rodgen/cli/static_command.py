"""rodgen static: the equilibrium of a scene under loads that do not change."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import print_json, print_table, show_work, write_picture
from rodgen.cli.options import AsJson, AtTime, OutFolder
from rodgen.cli.result_folders import delivery, picture_folder
from rodgen.result import ResultTable
from rodgen.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rodgen.analyse.statics import Equilibrium

COMPARED = "tip x", "tip y", "tip angle", "stable"  # columns of the list of all equilibria


def static(
    scene: Scene,
    t: AtTime = None,
    imperfection: Annotated[
        float | None,
        typer.Option(
            metavar="RADIANS",
            help="Load a rod whose tail is turned by this angle, then make it straight. Beyond a "
            "buckling load this finds the bent state instead of the straight, unstable one.",
        ),
    ] = None,
    every: Annotated[
        bool,
        typer.Option(
            "--all",
            help="Find equilibria on all branches and by deflation, list them and draw them.",
        ),
    ] = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Find the static equilibrium of SCENE, and draw the deflected rod."""
    from rodgen.analyse.statics import static_equilibrium
    from rodgen.errors import InputError

    if every:
        if imperfection is not None:
            raise InputError("--imperfection", imperfection, "absent beside --all")
        _list_equilibria(scene, t, out_folder, as_json)
        return
    with delivery(scene, out_folder, as_json) as deliver:
        with show_work("balancing"):
            rest = static_equilibrium(scene, t=t, imperfection=imperfection)
        deliver("static equilibrium", rest, {"static": "shape"})


def _list_equilibria(scene: Scene, t: float | None, out_folder: Path, as_json: bool) -> None:
    """Find, list and draw all equilibria."""
    from rodgen.analyse.branches.deflation import static_equilibria

    with picture_folder(scene, out_folder) as folder:
        with show_work("looking for equilibria"):
            found = static_equilibria(scene, t=t)
        if as_json:
            print_json({"equilibria": [one.to_dict() for one in found]})
        else:
            rows = [
                (str(at), *(text for name, text in one.tables()[0].rows if name in COMPARED))
                for at, one in enumerate(found, 1)
            ]
            compared = ResultTable.of_rows(("", *COMPARED), rows)
            print_table(f"{scene.name}: {len(found)} equilibria were found", compared)
        write_picture(partial(_draw, found, scene), folder, "equilibria")


def _draw(found: list[Equilibrium], scene: Scene) -> Figure:
    from rodgen.show.branch_pictures import equilibrium_shapes

    return equilibrium_shapes(found, scene)
