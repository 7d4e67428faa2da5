"""rodgen boundary: where flutter or divergence begins, in the plane of two numbers of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodgen.cli.console import finite, out, print_json, print_values, working, write_picture
from rodgen.cli.errors import FAILED_RUN, fail
from rodgen.cli.options import AsJson, AtTime, OutFolder, SceneFile
from rodgen.cli.results import promised

if TYPE_CHECKING:
    import xarray

RANGE = "FROM:TO"


def boundary(
    scene_file: SceneFile,
    vary: Annotated[
        str,
        typer.Option(
            metavar="A,B",
            help="Both numbers: loads.follower.force,loads.material_damping.time.",
        ),
    ],
    first: Annotated[
        str | None,
        typer.Option("--a", metavar=RANGE, help="The range of A; from 0 on, if not given."),
    ] = None,
    second: Annotated[
        str | None,
        typer.Option("--b", metavar=RANGE, help="The range of B; from 0 on, if not given."),
    ] = None,
    step: Annotated[
        float, typer.Option(help="The longest step, where 1 changes the equations by their size.")
    ] = 0.1,
    most: Annotated[int, typer.Option(help="Points to either side at most.")] = 1000,
    t: AtTime = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Follow the boundary of stability of SCENE while two of its numbers change, from the limit of
    no damping to that of much; draw it."""
    from rodgen.analyse.branches.boundary import stability_boundary
    from rodgen.analyse.curves.files import save
    from rodgen.scene import Scene, SceneError

    keys = vary.split(",")
    if len(keys) != 2:
        raise SceneError("--vary", vary, "two numbers of the scene with a comma between them")
    finite("--t", t)
    scene = Scene.from_toml(scene_file)
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("following the boundary") as said:
            found = stability_boundary(
                scene,
                (keys[0], keys[1]),
                ranges=(_range("--a", first), _range("--b", second)),
                step=step,
                most=most,
                t=t,
                watch=lambda point: said(f"{point[0]:.6g}, {point[1]:.6g}"),
            )
        if as_json:
            print_json(_object(found))
        else:
            save(found, folder / "boundary.nc")
            print_values(f"{scene.name}: boundary of stability", _rows(found))
            out.print(f"Written: {folder / 'boundary.nc'}")
            from rodgen.show.branch_pictures import boundary_curve

            write_picture(lambda: boundary_curve(found, scene), folder, "boundary")
    if not found.attrs["complete"]:
        fail(f"the boundary ends before it leaves its ranges: {found.attrs['end']}", FAILED_RUN)


def _range(option: str, text: str | None) -> tuple[float, float] | None:
    """Both ends of a range."""
    from rodgen.scene import SceneError

    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        raise SceneError(option, text, "two numbers with a colon between them, as 0:20") from None
    finite(option, low)
    finite(option, high)
    return low, high


def _object(found: xarray.Dataset) -> dict[str, Any]:
    names = ("a", "b", "frequency")
    rows = zip(*(found[name].values.tolist() for name in names), strict=True)
    attributes = {name: found.attrs[name] for name in ("a", "b", "kind", "end", "t")}
    points = [list(row) for row in rows]
    return {"points": points, "complete": bool(found.attrs["complete"]), **attributes}


def _rows(found: xarray.Dataset) -> dict[str, str]:
    a, b, frequency = (found[name].values for name in ("a", "b", "frequency"))

    def point(at: int) -> str:
        return f"{a[at]:.10g}, {b[at]:.10g}, at {frequency[at]:.8g} Hz"

    return {
        "points": f"{found.attrs['a']}, {found.attrs['b']}: {len(a)}",
        "begins there": found.attrs["kind"],
        "first": point(0),
        "last": point(-1),
        "ends": found.attrs["end"],
    }
