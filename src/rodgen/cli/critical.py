"""rodgen critical: the follower force from which small motions grow."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from rodgen.analyse.errors import AnalysisError
from rodgen.cli.console import err, out, print_notes, working
from rodgen.cli.errors import FAILED_RUN, fail, finite
from rodgen.cli.folders import promised
from rodgen.cli.options import AsJson, AtTime, OutFolder, SceneFile
from rodgen.scene import Scene, SceneError

if TYPE_CHECKING:
    from rodgen.analyse.critical import Critical
    from rodgen.analyse.growth import SimulatedCritical

    Simulated = SimulatedCritical | AnalysisError


def critical(
    scene_file: SceneFile,
    lowest: Annotated[float, typer.Option(help="Where the search begins [N].")] = 0.0,
    highest: Annotated[
        float | None, typer.Option(help="Where it ends [N]; 1000 EI/L^2, if not given.")
    ] = None,
    t: AtTime = None,
    simulate: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Also find it by simulations of so many seconds, each from the steady state with "
            "a small disturbance of its own: the scene's initial state is not used. Takes long.",
        ),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Find the smallest follower force under which SCENE flutters or diverges, whatever force it
    has itself; draw frequencies and growth against the force."""
    from rodgen.analyse.critical import critical_force, family_of

    for option, value in (("--lowest", lowest), ("--highest", highest), ("--t", t)):
        finite(option, value)
    if simulate is not None and not 0 < simulate < math.inf:
        raise SceneError("--simulate", simulate, "a positive number of seconds")
    scene = Scene.from_toml(scene_file)
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("searching"):
            found = critical_force(scene, lowest=lowest, highest=highest, t=t)
            family = family_of(scene, t)
        simulated = _simulated(family.system.scene, simulate) if simulate else None
        if as_json:
            print(json.dumps(_object(found, simulated), allow_nan=False))
        else:
            out.print(_table(found, simulated, scene.name))
            print_notes(found.notes)
            from rodgen.view.analysis_pictures import save_picture, stability_curves

            with working("drawing"):
                picture = save_picture(stability_curves(found, family), folder, "critical")
            out.print(f"Written: {picture}")
    if isinstance(simulated, AnalysisError):
        fail(f"by simulation: {simulated}", FAILED_RUN)


def _simulated(scene: Scene, span: float) -> Simulated:
    """The same by simulations, or why there is no result; scene: its loads are numbers."""
    from rodgen.analyse.growth import simulated_critical_force
    from rodgen.loading import build_fastest

    with working("generating"):
        target = build_fastest(scene).PROVENANCE["target"]
    if target == "numpy":
        err.print("rodgen: no C module can be built: simulations use NumPy, which takes long")
    with working(f"simulating {span:g} s at every force") as step:
        try:
            return simulated_critical_force(
                scene,
                span=span,
                progress=lambda force, grew: step(f"{force:.6g} N {'grows' if grew else 'stays'}"),
            )
        except AnalysisError as error:
            return error


def _object(found: Critical, simulated: Simulated | None) -> dict[str, Any]:
    if simulated is None:
        return asdict(found)
    result = None if isinstance(simulated, AnalysisError) else asdict(simulated)
    return asdict(found) | {"simulated": result}


def _table(found: Critical, simulated: Simulated | None, name: str) -> Table:
    low, high, forces = found.searched
    first, second = found.modes
    rows = {
        "critical force": f"{found.force:.10g} N",
        "P L^2/EI": f"{found.factor:.10g}",
        "kind": found.kind,
        "frequency at onset": f"{found.frequency:.10g} Hz",
        "modes": f"{first} and {second}" if first != second else str(first),
        "error, estimated": f"{found.error:.1e} N",
        "grows from the state": found.state,
        "other loads as at": f"t = {found.t:g} s",
        "searched": f"{low:g} to {high:g} N at {forces} forces",
        "modes looked at": "all" if found.complete else "the lowest 16",
    }
    if found.turning:
        rows["apart from that"] = f"the rod turns as a whole, with {found.turning:.4g} 1/s"
    if simulated is not None:
        rows |= _rows(found.force, simulated)
    table = Table(title=f"{name}: critical follower force", show_header=False)
    for row in rows.items():
        table.add_row(*row)
    return table


def _rows(force: float, simulated: Simulated) -> dict[str, str]:
    """What simulations found, beside the force by eigenvalues [N]."""
    if isinstance(simulated, AnalysisError):
        return {"by simulation": str(simulated)}
    away = simulated.force / force - 1 if force else 0.0
    limit = f"bending beyond {simulated.growth:g} times its start"
    module = "C" if simulated.target == "c" else "NumPy"
    return {
        "by simulation": f"{simulated.force:.6g} N, {away:+.2%}",
        "between": f"{simulated.low:.6g} N (no growth) and {simulated.high:.6g} N (growth)",
        "growth": f"{limit} in {simulated.span:g} s",
        "simulations": f"{simulated.runs} in {simulated.seconds:.3g} s, in {module}",
    }
