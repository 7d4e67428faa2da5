"""rodgen cycle-branch: periodic motions along one number of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from rodgen.cli.curve_options import file_hash, find_start, follow_curve
from rodgen.cli.options import (
    AsJson,
    Bounds,
    CheckMesh,
    LongestStep,
    MostPoints,
    OutFolder,
    ResumeFile,
    Segments,
    Vary,
    parse_both_bounds,
    point_number,
)
from rodgen.errors import InputError
from rodgen.scene import Scene

CYCLES = "cycles"  # files of a branch


def cycle_branch(
    scene: Scene,
    vary: Vary,
    bounds: Bounds,
    start: Annotated[
        str,
        typer.Option(
            help="Start of the branch: hopf (a Hopf point, which is looked for from A on) or run "
            "(SCENE's cycle)."
        ),
    ] = "hopf",
    equilibria: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE",
            help="A branch of equilibria that rodgen branch has written: begin in its Hopf point "
            "--point (1 is the first special point).",
        ),
    ] = None,
    point: Annotated[
        int | None,
        typer.Option(
            "--point",
            help="Number of a special point of --from, or of a point of --resume. Default: the "
            "last point of --resume.",
        ),
    ] = None,
    branch_point: Annotated[
        int | None,
        typer.Option(
            metavar="NUMBER",
            help="Follow the branch that begins in the special point of this number. This is a "
            "branch point, or a period doubling, where cycles of twice the period begin.",
        ),
    ] = None,
    resume: ResumeFile = None,
    segments: Segments = 4,
    step: LongestStep = 0.1,
    max_points: MostPoints = 200,
    check_mesh: CheckMesh = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Follow the periodic motions of SCENE, stable or not, while one of its numbers changes.

    Folds, branch points, period doublings and Neimark-Sacker points are located, and the amplitudes
    are drawn.
    """
    from rodgen.analyse.branches.equilibrium_data import FORMAT as EQUILIBRIA
    from rodgen.analyse.cycles.cycle_continuation import continue_cycles
    from rodgen.analyse.cycles.cycle_data import FORMAT

    between = parse_both_bounds(bounds)
    if equilibria is not None and resume is not None:
        raise InputError("--from", str(equilibria), "absent beside --resume")
    if equilibria is not None and point is None:
        raise InputError("--point", point, "given with --from: the number of a Hopf point")
    point_number(equilibria or resume, point, "--from or --resume")
    how: dict[str, Any] = {"branch_point": branch_point, "segments": segments}
    how |= {"step": step, "max_points": max_points, "check_mesh": check_mesh}
    name = CYCLES if branch_point is None else f"{CYCLES}_{branch_point}"
    file = out_folder / scene.name / f"{name}.nc"
    options: dict[str, Any] = {"vary": vary, "bounds": between, **how}
    options |= (
        {"start": file_hash(equilibria), "start_point": point} if equilibria else {"start": start}
    )
    number = None if equilibria else point
    begun = find_start("cycle-branch", scene, options, file, as_json, resume, number, FORMAT.read)
    if begun.curve is not None:
        how |= {"resume": begun.curve, "point": begun.point}
    elif equilibria:
        how |= {"start": EQUILIBRIA.read(equilibria), "point": point}
    else:
        how["start"] = start
    follow_curve(
        "the branch of cycles",
        f"{scene.name}: cycles along {vary}",
        file,
        as_json,
        begun,
        lambda said: continue_cycles(
            scene, vary, between, callback=lambda value: said(f"{vary} = {value:.6g}"), **how
        ),
    )
