"""rodgen nonlinear-mode: a periodic motion of a scene without dissipation, by its energy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import picture_settings, show_work, write_picture
from rodgen.cli.options import AsJson, OutFolder, Segments
from rodgen.cli.result_folders import delivery
from rodgen.scene import Scene


def nonlinear_mode(
    scene: Scene,
    energy: Annotated[
        float, typer.Option(metavar="JOULES", help="Energy of the motion above that of rest.")
    ],
    mode: Annotated[int, typer.Option(help="Number of the mode; 1 is the slowest.")] = 1,
    segments: Segments = 4,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Find the periodic motion of a nonlinear mode of SCENE, which has no dissipation.

    The motion, its Floquet multipliers and the family from small motions on are drawn.
    """
    from rodgen.analyse.cycles import nonlinear_modes as modes

    with delivery(scene, out_folder, as_json) as deliver:
        with show_work("following the mode"):
            found = modes.nonlinear_mode(scene, mode, energy, segments=segments)
        deliver(f"nonlinear mode {mode}", found, {"cycle": "film", "multipliers": "multipliers"})
        if picture_settings() is None:
            return
        from rodgen.show.cycle_pictures import frequency_energy_plot

        with show_work("following the family of the mode"):
            data = modes.continue_mode(scene, mode, energy, segments=segments)
        write_picture(lambda: frequency_energy_plot(data, scene), out_folder / scene.name, "mode")
