"""rodgen branch: equilibria and steady motions along one number of a scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

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
    branch_point: Annotated[
        int | None,
        typer.Option(
            metavar="NUMBER",
            help="From the special point of this number, a branch point, follow the other branch "
            "both ways.",
        ),
    ] = None,
    resume: ResumeFile = None,
    point: PointNumber = None,
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
    max_points: MostPoints = 2000,
    t: AtTime = None,
    check_mesh: CheckMesh = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Follow the equilibria, or the steady motion, of SCENE while one of its numbers changes.

    The branch goes through folds. The command locates branch points and Hopf points, counts
    unstable motions, and draws the diagram.
    """
    from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
    from rodgen.analyse.branches.equilibrium_data import FORMAT

    between = parse_both_bounds(bounds)
    given: dict[str, Any] = {
        "start": start,
        "imperfection": imperfection,
        "motion": motion,
        "step": step,
        "max_points": max_points,
        "t": t,
        "check_mesh": check_mesh,
    }
    options = {"vary": vary, "branch_point": branch_point, **given, "bounds": between}
    file = out_folder / scene.name / f"{_file_stem(branch_point)}.nc"
    begun = find_start("branch", scene, options, file, as_json, resume, point, FORMAT.read)

    def follow(
        said: Callable[[str], None], branch_point: int | None = branch_point
    ) -> xarray.Dataset:
        return continue_equilibria(
            scene,
            vary,
            between,
            branch_point=branch_point,
            resume=begun.curve,
            point=begun.point,
            callback=lambda value: said(f"{vary} = {value:.6g}"),
            **given,
        )

    def draw_diagram(found: xarray.Dataset) -> Figure:
        """Draw the branch, with the one that it leaves."""
        from rodgen.show.branch_pictures import bifurcation_diagram

        others = [follow(lambda _: None, None)] if found.attrs["branch_point"] else []
        return bifurcation_diagram([*others, found], scene)

    follow_curve(
        "the branch",
        f"{scene.name}: branch along {vary}",
        file,
        as_json,
        begun,
        follow,
        draw_diagram,
        lambda found: _file_stem(found.attrs["branch_point"]),  # 0 where Ctrl-C came before
    )


def _file_stem(branch_point: int | None) -> str:
    """Stem of the files of a branch; branch_point: number of the branch point that it leaves."""
    return f"branch_{branch_point}" if branch_point else "branch"
