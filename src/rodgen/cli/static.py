"""rodgen static: the equilibrium of a scene under loads that do not change."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import finite, out, print_json, print_values, warn, working, write_picture
from rodgen.cli.options import AsJson, AtTime, OutFolder
from rodgen.cli.results import promised
from rodgen.scene import Scene

if TYPE_CHECKING:
    from rodgen.analyse.statics import Equilibrium


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
    from rodgen.analyse.steady_rod import SteadyRod
    from rodgen.errors import InputError
    from rodgen.system.instant import describe_instant, inactive_loads

    if every:
        if imperfection is not None:
            raise InputError("--imperfection", imperfection, "absent beside --all")
        _every(scene, finite("--t", t), out_folder, as_json)
        return
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("balancing"):
            rest = static_equilibrium(scene, t=finite("--t", t), imperfection=imperfection)
        if rest.instability:
            warn(_warning(rest.instability, imperfection))
        if as_json:
            print_json(_object(rest) | {"silent": inactive_loads(scene, rest.t)})
            return
        out.print(f"{scene.name}: {describe_instant(scene, rest.t)}")
        from rodgen.show.analysis_pictures import equilibrium_shape
        from rodgen.show.result_tables import of_equilibrium

        print_values(f"{scene.name}: static equilibrium", of_equilibrium(rest))

        write_picture(lambda: equilibrium_shape(rest, SteadyRod.of(scene, t)), folder, "static")


def _every(scene: Scene, t: float | None, out_folder: Path, as_json: bool) -> None:
    """List all equilibria that are found."""
    from rodgen.analyse.branches.coexistence import static_equilibria
    from rodgen.system.instant import describe_instant, inactive_loads

    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("looking for equilibria"):
            found = static_equilibria(scene, t=t)
        if as_json:
            silence = inactive_loads(scene, found[0].t)
            print_json({"equilibria": [_object(one) for one in found], "silent": silence})
            return
        out.print(f"{scene.name}: {describe_instant(scene, found[0].t)}")
        rows = {f"tip at ({one.tip[0]:.9g}, {one.tip[1]:.9g}) m": _stability(one) for one in found}
        print_values(f"{scene.name}: {len(found)} equilibria were found", rows)
        from rodgen.show.branch_pictures import equilibrium_shapes

        write_picture(lambda: equilibrium_shapes(found, scene), folder, "equilibria")


def _stability(rest: Equilibrium) -> str:
    if rest.instability:
        return f"unstable ({rest.instability})"
    from rodgen.show.result_tables import STABLE

    return "stable" if rest.stable else STABLE[None]


def _warning(instability: str, imperfection: float | None) -> str:
    """That the state is unstable, and how a stable one beside it is found."""
    from rodgen.analyse.modal import DIVERGENCE

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
