"""rodgen exponents: Lyapunov exponents of the motion of a scene."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import (
    finite_or_none,
    out,
    print_json,
    print_notes,
    print_table,
    progress,
    write_picture,
)
from rodgen.cli.options import AsJson, OutFolder
from rodgen.cli.results import promised
from rodgen.scene import Scene

if TYPE_CHECKING:
    from rodgen.analyse.chaos.exponents import Exponents

VERDICT = {True: "chaotic", False: "not chaotic", None: "cannot be told; take a longer span"}


def exponents(
    scene: Scene,
    count: Annotated[
        int | None,
        typer.Option(help="Number of exponents, from the largest on. Default: all."),
    ] = None,
    span: Annotated[
        float | None,
        typer.Option(
            help="Length of the motion from the start of SCENE [s]. Default: the scene's span."
        ),
    ] = None,
    transient: Annotated[
        float | None,
        typer.Option(help="Time at the start that is left out [s]. Default: a tenth of the span."),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Compute the Lyapunov exponents of SCENE: how fast neighbouring motions come apart."""
    from rodgen.analyse.chaos.exponents import lyapunov_exponents

    start, end = scene.integrate.span
    length = end - start if span is None else span
    with promised(None if as_json else out_folder / scene.name) as folder:
        with progress(scene.name, start, start + length) as step:
            found = lyapunov_exponents(
                scene, count=count, span=span, transient=transient, progress=step
            )
        if as_json:
            print_json(_object(found))
            return
        print_notes(found.notes)
        from rodgen.show.exponent_pictures import convergence
        from rodgen.show.result_tables import of_exponents

        print_table(f"{scene.name}: Lyapunov exponents", of_exponents(found))
        for line in _words(found):
            out.print(line)
        write_picture(lambda: convergence(found, scene.name), folder, "exponents")


def _object(found: Exponents) -> dict[str, object]:
    return {
        "exponents": found.exponents.tolist(),
        "errors": found.errors.tolist(),
        "zero_one": finite_or_none(found.zero_one),
        "divergence": finite_or_none(found.divergence),
        "transient": found.transient,
        "zeros": found.zeros,
        "notes": list(found.notes),
    }


def _words(found: Exponents) -> list[str]:
    """What the numbers mean."""
    largest = float(found.exponents[0])
    lines = [f"The motion: {VERDICT[found.chaotic]}."]
    if found.chaotic is False:
        most = largest + float(found.errors[0])
        lines[0] += f" No exponent is above {most:.2g} 1/s by these {found.t[-1]:.4g} s."
    if found.chaotic:
        lines[0] += f" Errors grow tenfold in {math.log(10) / largest:.3g} s."
    if math.isfinite(found.zero_one):
        lines.append(f"0-1 test: {found.zero_one:.3f} (0: regular, 1: chaotic).")
    else:
        lines.append("0-1 test: too few independent samples.")
    if found.zeros:
        parts = (f"{number} by {reason}" for reason, number in found.zeros.items())
        lines.append(f"Zero whatever the motion, unless it comes to rest: {', '.join(parts)}.")
    if math.isfinite(found.divergence):
        total = float(found.exponents.sum())
        lines.append(f"Their sum: {total:.3g} 1/s; mean divergence: {found.divergence:.3g} 1/s.")
    return lines
