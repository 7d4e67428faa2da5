"""rodgen static: the equilibrium of a scene under loads that do not change."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import finite, out, print_json, print_values, warn, working, write_picture
from rodgen.cli.options import AsJson, AtTime, OutFolder, SceneFile
from rodgen.cli.results import promised

if TYPE_CHECKING:
    from rodgen.analyse.statics import Equilibrium
    from rodgen.scene import Scene

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
    every: Annotated[
        bool,
        typer.Option(
            "--all", help="List all equilibria that branches and deflation find, and draw them."
        ),
    ] = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Show the static equilibrium of SCENE; draw the deflected rod."""
    from rodgen.analyse.statics import static_equilibrium
    from rodgen.analyse.system import System, in_words, silent
    from rodgen.scene import Scene, SceneError

    scene = Scene.from_toml(scene_file)
    if every:
        if imperfection is not None:
            raise SceneError("--imperfection", imperfection, "absent beside --all")
        _every(scene, finite("--t", t), out_folder, as_json)
        return
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("balancing"):
            rest = static_equilibrium(scene, t=finite("--t", t), imperfection=imperfection)
        if rest.instability:
            warn(_warning(rest.instability, imperfection))
        if as_json:
            print_json(_object(rest) | {"silent": silent(scene, rest.t)})
            return
        out.print(f"{scene.name}: {in_words(scene, rest.t)}")
        print_values(f"{scene.name}: static equilibrium", _rows(rest))
        from rodgen.show.analysis_pictures import equilibrium_shape

        write_picture(lambda: equilibrium_shape(rest, System.of(scene, t)), folder, "static")


def _every(scene: Scene, t: float | None, out_folder: Path, as_json: bool) -> None:
    """List all equilibria that are found."""
    from rodgen.analyse.branches.coexistence import static_equilibria
    from rodgen.analyse.system import in_words, silent

    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("looking for equilibria"):
            found = static_equilibria(scene, t=t)
        if as_json:
            silence = silent(scene, found[0].t)
            print_json({"equilibria": [_object(one) for one in found], "silent": silence})
            return
        out.print(f"{scene.name}: {in_words(scene, found[0].t)}")
        rows = {f"tip at ({one.tip[0]:.9g}, {one.tip[1]:.9g}) m": _stability(one) for one in found}
        print_values(f"{scene.name}: {len(found)} equilibria were found", rows)
        from rodgen.show.branch_pictures import equilibrium_shapes

        write_picture(lambda: equilibrium_shapes(found, scene), folder, "equilibria")


def _stability(rest: Equilibrium) -> str:
    if rest.instability:
        return f"unstable ({rest.instability})"
    return "stable" if rest.stable else STABLE[None]


def _warning(instability: str, imperfection: float | None) -> str:
    """That the state is unstable, and how a stable one beside it is found."""
    from rodgen.analyse.rest import DIVERGENCE

    words = f"this equilibrium is unstable ({instability}): small motions about it grow"
    if instability != DIVERGENCE:
        return words
    larger = "a larger --imperfection" if imperfection else "--imperfection 0.01"
    return f"{words}; {larger} looks for a stable one beside it"


def _object(rest: Equilibrium) -> dict[str, object]:
    return {
        "tip": rest.tip.tolist(),
        "start": rest.joints[0].tolist(),
        "phi": rest.phi.tolist(),
        "states": rest.states,
        "stable": rest.stable,
        "instability": rest.instability,
        "iterations": rest.iterations,
        "stages": list(rest.stages),
        "t": rest.t,
    }


def _rows(rest: Equilibrium) -> dict[str, str]:
    largest = abs(rest.joints).max()
    x, y, x0, y0 = (0.0 if abs(c) < ROUNDING * largest else c for c in (*rest.tip, *rest.joints[0]))
    angle = float(rest.phi[-1])
    stages = len(rest.stages)
    return {
        "tip x": f"{x:.12g} m",
        "tip y": f"{y:.12g} m",
        "tip angle": f"{angle:.12g} rad = {math.degrees(angle):.6g} degrees",
        "joint 0": f"({x0:.12g}, {y0:.12g}) m",
        **{name: f"{value:.12g}" for name, value in rest.states.items()},
        "Newton iterations": f"{rest.iterations}, the last correction {rest.change:.1e} rad",
        "load stages": str(stages) if stages > 1 else "1 (the whole load at once)",
        "stable": STABLE.get(rest.instability, f"NO ({rest.instability})"),
    }
