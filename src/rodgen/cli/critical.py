"""rodgen critical: the follower force from which small motions grow."""

from __future__ import annotations

import math
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodgen.cli.completion import words
from rodgen.cli.console import (
    err,
    finite,
    finite_or_none,
    out,
    print_json,
    print_notes,
    print_values,
    warn,
    working,
    write_picture,
)
from rodgen.cli.errors import FAILED_RUN, fail
from rodgen.cli.options import After, AsJson, AtTime, OutFolder, Speed
from rodgen.cli.results import promised
from rodgen.errors import AnalysisError, InputError
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    from rodgen.analyse.critical import Critical
    from rodgen.analyse.family import Family
    from rodgen.analyse.growth import SimulatedCritical
    from rodgen.analyse.steady_rod import SteadyRod

    Simulated = SimulatedCritical | AnalysisError


SCALABLE = ", ".join(term.table for term in TERMS.values() if term.sizes)


def critical(
    scene: Scene,
    lowest: Annotated[
        float | None, typer.Option(help="Force at which the search begins [N]. Default: 0.")
    ] = None,
    highest: Annotated[
        float | None, typer.Option(help="Force at which the search ends [N]. Default: 1000 EI/L^2.")
    ] = None,
    load: Annotated[
        str | None,
        typer.Option(
            autocompletion=words(
                [*(term.table for term in TERMS.values() if term.sizes), "followers", "all"]
            ),
            help=f"Load that is scaled: {SCALABLE}, or a name such as follower_2 if there are "
            "several; followers or all scales several by one factor. Default: the first load that "
            "follows the rod.",
        ),
    ] = None,
    end: Annotated[
        str,
        typer.Option(
            help="upper: force at which stability is lost. lower: force at which it is regained.",
            autocompletion=words(["upper", "lower"]),
        ),
    ] = "upper",
    windows: Annotated[
        bool, typer.Option("--windows", help="Also list all windows of stability in the range.")
    ] = False,
    elastic: Annotated[
        bool, typer.Option("--elastic", help="Leave out motions that rotate a free rod as a whole.")
    ] = False,
    t: AtTime = None,
    speed: Speed = None,
    after: After = None,
    simulate: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Also find the force by simulations of this length. Each begins with the steady "
            "state and a small disturbance. Of the scene's initial state only the speed is "
            "used.",
        ),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Find the smallest follower force, or other load, at which SCENE flutters or diverges.

    The force of the scene itself does not matter. Frequencies and growth are drawn against the
    force.
    """
    from rodgen.analyse.critical import critical_force, family_of
    from rodgen.analyse.family import FOLLOWER, GROUPS, label_of
    from rodgen.analyse.steady_rod import state_after
    from rodgen.system.instant import describe_instant, inactive_loads

    for option, value in (("--lowest", lowest), ("--highest", highest), ("--t", t)):
        finite(option, value)
    if simulate is not None and not 0 < simulate < math.inf:
        raise InputError("--simulate", simulate, "a positive number of seconds")
    if simulate is not None and load not in (None, FOLLOWER):
        raise InputError("--simulate", simulate, "absent: runs find a follower force alone")
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("searching"):
            system, t = state_after(System(scene), t, speed, after)
            found = critical_force(
                system,
                lowest=lowest,
                highest=highest,
                t=t,
                speed=speed,
                load=load,
                end=end,
                windows=windows,
                elastic=elastic,
            )
            family = family_of(system, t, speed, load=load)
            own = () if found.load in GROUPS else tuple(family.load.parts)
        simulated = _simulated(family.rod, simulate) if simulate else None
        doubted = _doubt(found, simulated, family)
        if as_json:
            inactive = inactive_loads(system.source, found.t, own)
            print_json(_object(found, simulated, doubted) | {"silent": inactive})
        else:
            print_notes(found.notes)
            out.print(f"{scene.name}: other {describe_instant(system.source, found.t, own)}")
            from rodgen.show.analysis_pictures import stability_curves
            from rodgen.show.result_tables import of_critical

            rows = of_critical(found) | _simulated_rows(found.force, simulated)
            print_values(f"{scene.name}: critical {label_of(found.load)}", rows)

            write_picture(lambda: stability_curves(found, family), folder, "critical")
    if isinstance(simulated, AnalysisError):
        fail(f"by simulation: {simulated}", FAILED_RUN)


def _simulated(rod: SteadyRod, span: float) -> Simulated:
    """The critical force by simulations, or why there is none."""
    from rodgen.analyse.growth import simulated_critical_force
    from rodgen.loading import build_fastest

    scene = rod.scene
    with working("generating"):
        target = build_fastest(scene).PROVENANCE["target"]
    if target == "numpy":
        err.print("rodgen: no C module can be built: simulations use NumPy, which takes long")
    with working(f"simulating {span:g} s at every force") as step:
        try:
            return simulated_critical_force(
                scene,
                span=span,
                speed=rod.speed if rod.base else None,
                progress=lambda force, grew: step(f"{force:.6g} N {'grows' if grew else 'stays'}"),
            )
        except AnalysisError as error:
            return error


def _doubt(found: Critical, simulated: Simulated | None, family: Family) -> str | None:
    """Say which of two results is not to be trusted, where they differ."""
    from rodgen.analyse.growth import doubt

    if simulated is None or isinstance(simulated, AnalysisError):
        return None
    words = doubt(found, simulated, family)
    if words:
        warn(words)
    return words


def _object(found: Critical, simulated: Simulated | None, doubted: str | None) -> dict[str, Any]:
    told = {one.name: getattr(found, one.name) for one in fields(found) if one.name != "scene"}
    told["stiffness"] = found.stiffness
    told |= {name: finite_or_none(getattr(found, name)) for name in ("applied", "load_ratio")}
    if simulated is None:
        return told
    result = None if isinstance(simulated, AnalysisError) else asdict(simulated)
    return told | {"simulated": result, "doubt": doubted}


def _simulated_rows(force: float, simulated: Simulated | None) -> dict[str, str]:
    """What simulations found, where there are any, beside the force by eigenvalues [N]."""
    if simulated is None:
        return {}
    if isinstance(simulated, AnalysisError):
        return {"by simulation": str(simulated)}
    away = simulated.force / force - 1 if force else 0.0
    limit = "growth of 1 %, measured,"
    if simulated.growth:
        limit = f"bending beyond {simulated.growth:g} times its start"
    module = "C" if simulated.target == "c" else "NumPy"
    return {
        "by simulation": f"{simulated.force:.6g} N, {away:+.2%}",
        "between": f"{simulated.low:.6g} N (no growth) and {simulated.high:.6g} N (growth)",
        "growth": f"{limit} in {simulated.span:g} s",
        "simulations": f"{simulated.runs} in {simulated.seconds:.3g} s, in {module}",
    }
