"""rodgen critical: the follower force from which small motions grow."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import show_work
from rodgen.cli.exits import FAILED_RUN, fail
from rodgen.cli.options import After, AsJson, AtTime, OutFolder, Speed, complete_words, parse_bounds
from rodgen.cli.result_folders import delivery
from rodgen.model.terms import TERMS
from rodgen.scene import Scene

SCALABLE = [term.table for term in TERMS.values() if term.size_parameters]


def critical(
    scene: Scene,
    bounds: Annotated[
        str | None,
        typer.Option(
            metavar="A,B",
            help="Range of sizes that is searched, in the load's unit. Default of A: 0; of B: 1000 "
            "EI/L^2.",
        ),
    ] = None,
    load: Annotated[
        str | None,
        typer.Option(
            autocompletion=complete_words([*SCALABLE, "followers", "all"]),
            help=f"Load that is scaled: {', '.join(SCALABLE)}, or a name such as follower_2 if "
            "there are several; followers or all scales several by one factor. Default: the first "
            "load that follows the rod.",
        ),
    ] = None,
    end: Annotated[
        str,
        typer.Option(
            help="upper: force at which stability is lost. lower: force at which it is regained.",
            autocompletion=complete_words(["upper", "lower"]),
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
    from rodgen.analyse.critical import critical_load
    from rodgen.analyse.scaled_load import label_of

    between = parse_bounds(bounds) if bounds is not None else (None, None)
    with delivery(scene, out_folder, as_json) as deliver:
        with show_work("searching") as step:
            found = critical_load(
                scene,
                bounds=between,
                t=t,
                speed=speed,
                after=after,
                load=load,
                end=end,
                windows=windows,
                elastic=elastic,
                simulate=simulate,
                progress=lambda force, grew: step(
                    f"simulating: {force:.6g} N {'grows' if grew else 'stays'}"
                ),
            )
        deliver(f"critical {label_of(found.load)}", found, {"critical": "curves"})
    if simulate is not None and found.simulated is None:
        fail("simulations find no critical force", FAILED_RUN)
