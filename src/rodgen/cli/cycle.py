"""rodgen cycle: the periodic motion that a scene settles on, and its stability."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import print_json, print_values, warn, working, write_picture
from rodgen.cli.options import AsJson, OutFolder, SceneFile
from rodgen.cli.results import promised

if TYPE_CHECKING:
    from rodgen.analyse.cycles.cycle import Cycle

SHOWN = 10  # multipliers
UNSURE = 1e-6  # error of the trivial multiplier, beyond which all of them are doubtful


def cycle(
    scene_file: SceneFile,
    segments: Annotated[
        int, typer.Option(help="How many segments of the period are shot one by one.")
    ] = 4,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Show the periodic motion that SCENE settles on, and its Floquet multipliers; draw both."""
    from rodgen.analyse.cycles.cycle import find_cycle
    from rodgen.scene import Scene

    scene = Scene.from_toml(scene_file)
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("looking for a cycle"):
            found = find_cycle(scene, segments=segments)
        if not found.stable:
            warn(f"this cycle is unstable: {found.unstable} multipliers are larger than 1")
        if found.trivial_error > UNSURE:
            warn(f"the multipliers are right to {found.trivial_error:.1e} only")
        if as_json:
            print_json(_object(found))
            return
        print_values(f"{scene.name}: cycle", _rows(found))
        from rodgen.show.cycle_pictures import film_strip, unit_circle

        write_picture(lambda: film_strip(found), folder, "cycle")
        write_picture(lambda: unit_circle(found), folder, "multipliers")


def _object(found: Cycle) -> dict[str, object]:
    return {
        "period": found.period,
        "multipliers": [[mu.real, mu.imag] for mu in found.multipliers.tolist()],
        "energy": found.energy,
        "y0": found.y0.tolist(),
    }


def _rows(found: Cycle) -> dict[str, str]:
    of = ", that of the loads" if found.forced else ""
    rows = {
        "period": f"{found.period:.12g} s{of}",
        "frequency": f"{1 / found.period:.10g} Hz",
        "amplitude of the angles": f"{found.amplitude:.8g} rad",
        "energy of y0": f"{found.energy:.10g} J",
        **{f"work of {name} a period": f"{work:.8g} J" for name, work in found.work.items()},
    }
    if found.angle:
        rows["turned after a period by"] = (
            f"{found.angle:.10g} rad = {math.degrees(found.angle):.6g} degrees"
        )
    if found.drift.any():
        rows["moved after a period by"] = f"({found.drift[0]:.8g}, {found.drift[1]:.8g}) m"
    multipliers = found.nontrivial[:SHOWN].tolist()
    for at, mu in enumerate(multipliers):
        sign = f" {'+-'[mu.imag < 0]} {abs(mu.imag):.8g} i" if mu.imag else ""
        rows[f"multiplier {at + 1}"] = f"{mu.real:.8g}{sign}   (size {abs(mu):.8g})"
    left = len(found.nontrivial) - len(multipliers)
    rows["further multipliers"] = f"{left}, smaller" if left else "none"
    rows["multipliers that are 1"] = f"{found.trivial}, found with an error of " * bool(
        found.trivial
    ) + (f"{found.trivial_error:.1e}" if found.trivial else "none: the loads give the phase")
    rows["stable"] = "yes" if found.stable else "NO"
    rows["found"] = (
        f"after a run of {found.after:g} s, by {found.iterations} iterations of Newton's method; "
        f"closes to {found.residual:.1e} of its size"
    )
    return rows
