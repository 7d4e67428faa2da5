"""rodgen branch: equilibria and steady motions along one number of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodgen.cli.console import finite, out, print_json, print_values, warn, working, write_picture
from rodgen.cli.errors import FAILED_RUN, fail
from rodgen.cli.options import AsJson, AtTime, OutFolder, SceneFile
from rodgen.cli.results import promised

if TYPE_CHECKING:
    import xarray

LAST = -1


def branch(
    scene_file: SceneFile,
    vary: Annotated[
        str, typer.Option(metavar="KEY", help="The number that is varied: loads.follower.force.")
    ],
    first: Annotated[float, typer.Option("--from", help="Where it begins, and the branch.")],
    last: Annotated[float, typer.Option("--to", help="Where it ends.")],
    start: Annotated[
        float | None,
        typer.Option(
            help="Begin at this value between, and follow the branch both ways; --from, if not "
            "given."
        ),
    ] = None,
    switch: Annotated[
        int | None,
        typer.Option(
            metavar="NUMBER",
            help="Follow the other branch, both ways, from the branch point of this number among "
            "the special points.",
        ),
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Go on from the branch in this file, written before."),
    ] = None,
    at: Annotated[
        int | None,
        typer.Option(help="Number of the point of FILE to go on from; the last, if not given."),
    ] = None,
    imperfection: Annotated[
        float | None,
        typer.Option(
            metavar="RADIANS",
            help="Begin with the bent equilibrium that rodgen static finds with it.",
        ),
    ] = None,
    step: Annotated[
        float, typer.Option(help="The longest step: a share of the range, and rad of the angles.")
    ] = 0.02,
    most: Annotated[int, typer.Option(help="Points at most.")] = 2000,
    t: AtTime = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Follow the equilibria, or the steady motion, of SCENE while one of its numbers changes:
    through folds, with branch points, Hopf points and how many motions are unstable; draw the
    diagram."""
    from rodgen.analyse.branches import branch_data
    from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
    from rodgen.analyse.curves import files
    from rodgen.scene import Scene, SceneError

    if at is not None and resume is None:
        raise SceneError("--at", at, "absent without --resume")
    for option, value in (("--from", first), ("--to", last), ("--t", t)):
        finite(option, value)
    scene = Scene.from_toml(scene_file)
    before = None if resume is None else branch_data.read(resume)
    given: dict[str, Any] = {
        "start": start,
        "resume": before,
        "at": LAST if at is None else at,
        "imperfection": imperfection,
        "step": step,
        "most": most,
        "t": t,
    }
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("following the branch") as said:

            def follow(number: int | None) -> xarray.Dataset:
                return continue_equilibria(
                    scene,
                    vary,
                    (first, last),
                    switch=number,
                    watch=lambda value: said(f"{vary} = {value:.6g}"),
                    **given,
                )

            found = follow(switch)
            others = [] if switch is None or as_json else [follow(None)]
        for note in filter(None, found.attrs["notes"].split("\n")):
            warn(note)
        if as_json:
            print_json(_object(found))
        else:
            name = "branch" if switch is None else f"branch_{switch}"
            files.save(found, folder / f"{name}.nc")
            print_values(f"{scene.name}: branch along {vary}", _rows(found))
            out.print(f"Written: {folder / name}.nc")
            from rodgen.show.branch_pictures import bifurcation_diagram

            write_picture(lambda: bifurcation_diagram([*others, found], scene), folder, name)
    if not found.attrs["complete"]:
        fail(f"the branch ends before it leaves the range: {found.attrs['end']}", FAILED_RUN)


def _object(found: xarray.Dataset) -> dict[str, Any]:
    """One JSON object, whose numbers are those of the Dataset."""
    unstable = [None if number < 0 else number for number in found["unstable"].values.tolist()]
    points = zip(
        found["value"].values.tolist(),
        unstable,
        found["tip"].values.tolist(),
        found["phi"].values.tolist(),
        strict=True,
    )
    special = zip(
        found["special_kind"].values.tolist(),
        found["special_value"].values.tolist(),
        found["special_frequency"].values.tolist(),
        strict=True,
    )
    return {
        "points": [
            dict(zip(("value", "unstable", "tip", "phi"), row, strict=True)) for row in points
        ],
        "special": [dict(zip(("kind", "value", "frequency"), row, strict=True)) for row in special],
        "key": found.attrs["key"],
        "complete": bool(found.attrs["complete"]),
        "end": found.attrs["end"],
        "notes": list(filter(None, found.attrs["notes"].split("\n"))),
        "t": found.attrs["t"],
    }


def _rows(found: xarray.Dataset) -> dict[str, str]:
    values, unstable = found["value"].values, found["unstable"].values
    rows = {
        "points": f"{len(values)}, from {values[0]:.9g} to {values[-1]:.9g}",
        "ends": found.attrs["end"],
        "unstable directions": f"{_number(unstable[0])} at its start, {_number(unstable[-1])} at "
        "its end",
    }
    parts = (found[f"special_{name}"].values for name in ("kind", "value", "frequency", "note"))
    for number, (kind, value, frequency, note) in enumerate(zip(*parts, strict=True), 1):
        words = f"{kind} point at {value:.12g}" if kind != "fold" else f"fold at {value:.12g}"
        words = words.replace("hopf", "Hopf")
        if frequency:
            words += f", {frequency:.12g} Hz"
        rows[f"special {number}"] = f"{words} ({note})" if note else words
    return rows


def _number(unstable: int) -> str:
    return "unknown" if unstable < 0 else str(unstable)
