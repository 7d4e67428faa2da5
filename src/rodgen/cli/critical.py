"""rodgen critical: the follower force from which small motions grow."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from rodgen.cli.console import out, working
from rodgen.cli.errors import finite
from rodgen.cli.folders import writable
from rodgen.cli.options import AsJson, AtTime, OutFolder, SceneFile
from rodgen.scene import Scene, SceneError

if TYPE_CHECKING:
    from rodgen.analyse.critical import Critical
    from rodgen.analyse.growth import SimulatedCritical

SPAN = 200.0  # s


def critical(
    scene_file: SceneFile,
    span: Annotated[
        float | None,
        typer.Argument(metavar="SPAN", help=f"Seconds that --simulate takes; {SPAN:g}."),
    ] = None,
    lowest: Annotated[float, typer.Option(help="Where the search begins [N].")] = 0.0,
    highest: Annotated[
        float | None, typer.Option(help="Where it ends [N]; 1000 EI/L^2, if not given.")
    ] = None,
    t: AtTime = None,
    simulate: Annotated[
        bool,
        typer.Option("--simulate", help="Also find it by simulations of [SPAN] s. Takes long."),
    ] = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Find the smallest follower force under which SCENE flutters or diverges, whatever force it
    has itself; draw frequencies and growth against the force."""
    from rodgen.analyse.critical import critical_force, family_of

    if span is not None and not simulate:
        raise SceneError("SPAN", span, "given together with --simulate")
    for option, value in (("--lowest", lowest), ("--highest", highest), ("--t", t)):
        finite(option, value)
    scene = Scene.from_toml(scene_file)
    with working("searching"):
        found = critical_force(scene, lowest=lowest, highest=highest, t=t)
        family = family_of(scene, t)
    simulated = (
        _simulated(family.system.scene, SPAN if span is None else span) if simulate else None
    )
    if as_json:
        print(json.dumps(_object(found, simulated), allow_nan=False))
        return
    out.print(_table(found, simulated, scene.name))
    from rodgen.view.analysis_pictures import save_picture, stability_curves

    with working("drawing"):
        figure = stability_curves(found, family)
        picture = save_picture(figure, writable(out_folder / scene.name), "critical")
    out.print(f"Written: {picture}")


def _simulated(scene: Scene, span: float | None) -> SimulatedCritical:
    """scene: with the same loads at every time."""
    from rodgen.analyse.growth import simulated_critical_force

    span = SPAN if span is None else span
    with working(f"simulating {span:g} s at every force"):
        return simulated_critical_force(scene, span=span)


def _object(found: Critical, simulated: SimulatedCritical | None) -> dict[str, Any]:
    return asdict(found) | ({"simulated": asdict(simulated)} if simulated else {})


def _table(found: Critical, simulated: SimulatedCritical | None, name: str) -> Table:
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
        "searched": f"{low:g} to {high:g} N, {forces} forces",
        "modes looked at": "all" if found.complete else "the lowest 16",
    }
    if found.turning:
        rows["apart from that"] = f"the rod turns as a whole, with {found.turning:.4g} 1/s"
    if simulated:
        away = simulated.force / found.force - 1 if found.force else 0.0
        limit = f"bending beyond {simulated.growth:g} times its start"
        rows |= {
            "by simulation": f"{simulated.force:.6g} N, {away:+.2%}",
            "between": f"{simulated.low:.6g} N (no growth) and {simulated.high:.6g} N (growth)",
            "growth": f"{limit} in {simulated.span:g} s",
            "simulations": f"{simulated.runs} in {simulated.seconds:.3g} s",
        }
    table = Table(title=f"{name}: critical follower force", show_header=False)
    for row in rows.items():
        table.add_row(*row)
    return table
