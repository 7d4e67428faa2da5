"""rodgen static: the equilibrium of a scene under loads that do not change."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from rodgen.cli.console import err, out, working
from rodgen.cli.errors import finite
from rodgen.cli.folders import promised
from rodgen.cli.options import AsJson, AtTime, OutFolder, SceneFile

if TYPE_CHECKING:
    from rodgen.analyse.statics import Equilibrium

STABLE = {"": "yes", None: "not looked at (more than 200 links)"}
ROUNDING = 1e-15  # of the largest coordinate


def static(
    scene_file: SceneFile,
    t: AtTime = None,
    imperfection: Annotated[
        float | None,
        typer.Option(
            metavar="RADIANS",
            help="Load a rod whose tail is turned by so much, then make it straight: beyond a "
            "buckling load this finds the bent state instead of the straight, unstable one.",
        ),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Show the static equilibrium of SCENE; draw the deflected rod."""
    from rodgen.analyse.instant import in_words, silent
    from rodgen.analyse.statics import static_equilibrium
    from rodgen.analyse.system import System
    from rodgen.scene import Scene

    scene = Scene.from_toml(scene_file)
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("balancing"):
            rest = static_equilibrium(scene, t=finite("--t", t), imperfection=imperfection)
        if rest.instability:
            err.print(f"rodgen: warning: {_warning(rest.instability, imperfection)}")
        if as_json:
            print(json.dumps(_object(rest) | {"silent": silent(scene, rest.t)}, allow_nan=False))
            return
        out.print(f"{scene.name}: {in_words(scene, rest.t)}")
        out.print(_table(rest, scene.name))
        from rodgen.view.analysis_pictures import equilibrium_shape, save_picture

        with working("drawing"):
            figure = equilibrium_shape(rest, System.of(scene, t))
            picture = save_picture(figure, folder, "static")
        out.print(f"Written: {picture}")


def _warning(instability: str, imperfection: float | None) -> str:
    """That the state is unstable, and how a stable one beside it is found."""
    from rodgen.analyse.instability import DIVERGENCE

    words = f"this equilibrium is unstable ({instability}): small motions about it grow"
    if instability != DIVERGENCE:
        return words
    larger = "a larger --imperfection" if imperfection else "--imperfection 0.01"
    return f"{words}; {larger} looks for a stable one beside it"


def _object(rest: Equilibrium) -> dict[str, object]:
    return {
        "tip": rest.tip.tolist(),
        "phi": rest.phi.tolist(),
        "stable": rest.stable,
        "instability": rest.instability,
        "iterations": rest.iterations,
        "stages": list(rest.stages),
        "t": rest.t,
    }


def _table(rest: Equilibrium, name: str) -> Table:
    x, y = (0.0 if abs(c) < ROUNDING * abs(rest.joints).max() else c for c in rest.tip)
    angle = float(rest.phi[-1])
    stages = len(rest.stages)
    rows = {
        "tip x": f"{x:.12g} m",
        "tip y": f"{y:.12g} m",
        "tip angle": f"{angle:.12g} rad = {math.degrees(angle):.6g} degrees",
        "Newton iterations": f"{rest.iterations}, the last correction {rest.change:.1e} rad",
        "load stages": str(stages) if stages > 1 else "1 (the whole load at once)",
        "stable": STABLE.get(rest.instability, f"NO ({rest.instability})"),
    }
    table = Table(title=f"{name}: static equilibrium", show_header=False)
    for row in rows.items():
        table.add_row(*row)
    return table
