"""rodgen branch: equilibria and steady motions along one number of a scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodgen.cli.console import check_finite
from rodgen.cli.curve_options import find_start, follow_curve
from rodgen.cli.options import (
    AsJson,
    AtTime,
    Bounds,
    CheckMesh,
    LongestStep,
    MostPoints,
    OutFolder,
    PointNumber,
    ResumeFile,
    Vary,
    parse_both_bounds,
)
from rodgen.cli.result_folders import output_folder
from rodgen.scene import Scene

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


def branch(
    scene: Scene,
    vary: Vary,
    bounds: Bounds,
    start: Annotated[
        float | None,
        typer.Option(
            help="Begin at this value between A and B, and follow the branch both ways. Default: A."
        ),
    ] = None,
    switch: Annotated[
        int | None,
        typer.Option(
            metavar="NUMBER",
            help="From the special point of this number, a branch point, follow the other branch "
            "both ways.",
        ),
    ] = None,
    resume: ResumeFile = None,
    at: PointNumber = None,
    imperfection: Annotated[
        float | None,
        typer.Option(
            metavar="RADIANS",
            help="Begin with the bent equilibrium that rodgen static finds with this imperfection.",
        ),
    ] = None,
    motion: Annotated[
        str | None,
        typer.Option(
            metavar="WHERE",
            help="Follow steady motions, bent or not, of a rod that nothing holds in place. "
            "initial: begin near SCENE's initial state. run: begin with the motion to which a"
            " run of SCENE leads.",
        ),
    ] = None,
    step: LongestStep = 0.02,
    most: MostPoints = 2000,
    t: AtTime = None,
    check_mesh: CheckMesh = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Follow the equilibria, or the steady motion, of SCENE while one of its numbers changes.

    The branch goes through folds. The command locates branch points and Hopf points, counts
    unstable motions, and draws the diagram.
    """
    from rodgen.analyse.branches import equilibrium_data
    from rodgen.analyse.branches.equilibrium_branch import continue_equilibria

    check_finite("--t", t)
    between = parse_both_bounds(bounds)
    given: dict[str, Any] = {
        "start": start,
        "imperfection": imperfection,
        "motion": motion,
        "step": step,
        "most": most,
        "t": t,
        "check_mesh": check_mesh,
    }
    file = None if as_json else out_folder / scene.name / f"{_file_stem(switch)}.nc"
    command = {
        "command": "branch",
        "scene": scene.to_dict(),
        "vary": vary,
        "switch": switch,
        **given,
    }
    command |= {"bounds": between}
    going = find_start(resume, at, equilibrium_data.read, file, command)
    given |= {"resume": going.curve, "at": going.at}
    with output_folder(None if as_json else out_folder / scene.name) as folder:

        def follow(said: Callable[[str], None], switch: int | None) -> xarray.Dataset:
            def report_value(value: float) -> None:
                said(f"{vary} = {value:.6g}")

            return continue_equilibria(
                scene, vary, between, switch=switch, watch=report_value, **given
            )

        made = follow_curve("the branch", lambda said: follow(said, switch), going.journal)
        found = made.data
        name = _file_stem(found.attrs["switch"])  # 0 where Ctrl-C came before
        written = file and folder / f"{name}.nc"
        title = f"{scene.name}: branch along {vary}"
        made.print_and_write(title, written, lambda: _draw_diagram(found, scene, follow))
        made.exit_if_incomplete(written, file)


def _file_stem(switch: int | None) -> str:
    """Stem of the files of a branch; switch: number of the branch point that it leaves."""
    return f"branch_{switch}" if switch else "branch"


def _draw_diagram(
    found: xarray.Dataset,
    scene: Scene,
    follow: Callable[[Callable[[str], None], int | None], xarray.Dataset],
) -> Figure:
    """Draw a branch, with the one that it leaves."""
    from rodgen.show.branch_pictures import bifurcation_diagram

    others = [follow(lambda text: None, None)] if found.attrs["switch"] else []
    return bifurcation_diagram([*others, found], scene)
