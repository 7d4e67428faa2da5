"""rodgen modes: natural frequencies and mode shapes of a scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import (
    finite,
    out,
    print_json,
    print_notes,
    print_table,
    warn,
    working,
    write_picture,
)
from rodgen.cli.options import After, AsJson, AtTime, OutFolder, Speed
from rodgen.cli.results import promised
from rodgen.scene import Scene

if TYPE_CHECKING:
    from rodgen.analyse.modes import Modes


def modes(
    scene: Scene,
    count: Annotated[int, typer.Option(help="Number of modes, from the lowest on.")] = 10,
    t: AtTime = None,
    speed: Speed = None,
    after: After = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Compute the natural frequencies of SCENE about its steady state, and draw the mode shapes."""
    from rodgen.analyse.modes import natural_modes
    from rodgen.system.instant import describe_instant, inactive_loads

    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("linearising"):
            found = natural_modes(scene, count, t=finite("--t", t), speed=speed, after=after)
        _warn(found)
        if as_json:
            print_json(_object(found) | {"silent": inactive_loads(scene, found.t)})
            return
        print_notes(found.notes)
        out.print(f"{scene.name}: {describe_instant(scene, found.t)}")
        if len(found.frequencies):
            from rodgen.show.result_tables import of_modes

            print_table(f"{scene.name}: natural frequencies", of_modes(found))
        else:
            out.print(f"{scene.name}: no natural frequencies")
        out.print(f"About the state: {found.state}.")
        out.print(f"Left out: {_left_out(found)}.")
        if len(found.frequencies):
            from rodgen.show.analysis_pictures import mode_shapes

            write_picture(lambda: mode_shapes(found, scene), folder, "modes")


def _warn(found: Modes) -> None:
    """Say which modes grow."""
    growing = [str(k + 1) for k, growth in enumerate(found.growth) if growth > 0]
    if growing:
        which = f"mode {growing[0]} grows" if len(growing) == 1 else _several(growing)
        warn(f"this state is unstable: {which}")


def _several(numbers: list[str]) -> str:
    return f"modes {', '.join(numbers[:-1])} and {numbers[-1]} grow"


def _object(found: Modes) -> dict[str, object]:
    return {
        "frequencies": found.frequencies.tolist(),
        "growth": found.growth.tolist(),
        "state": found.state,
        "rigid": found.rigid,
        "overdamped": found.overdamped,
        "t": found.t,
        "speed": found.speed,
        "notes": found.notes,
    }


def _left_out(found: Modes) -> str:
    """Motions without a frequency, in words."""
    ways = {0: "", 1: " (turning)", 2: " (moving along and across)", 3: " (moving and turning)"}
    rigid = f"{found.rigid or 'no'} rigid-body motion{'s' * (found.rigid != 1)}{ways[found.rigid]}"
    if not found.overdamped:
        return rigid
    plural = "s" * (found.overdamped != 1)
    return f"{rigid}, {found.overdamped} overdamped motion{plural} among those computed"
