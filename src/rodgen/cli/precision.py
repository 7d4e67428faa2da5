"""rodgen precision: error against run time of methods on a scene."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from rodgen.cli.console import out, print_json, working, write_picture
from rodgen.cli.options import AsJson, OutFolder
from rodgen.cli.results import promised
from rodgen.scene import Scene
from rodgen.scene.structure import choose

if TYPE_CHECKING:
    from rodgen.analyse.precision.work_precision import WorkPrecision

ASKED = (1e-3, 1e-6, 1e-9)  # rad or m
# Of errors, by the name that is asked for: the measure, its unit, and what it is of.
MEASURES = {
    "end": ("error_phi", "rad", "the angles at the end"),
    "angles": ("error_angles", "rad", "the angles over time"),
    "rates": ("error_rates", "rad/s", "the rates over time"),
    "tail": ("error_tail", "m", "the tail over time"),
}


def precision(
    scene: Scene,
    seconds: Annotated[
        float, typer.Option(help="Approximate duration, without building the module [s].")
    ] = 40.0,
    of: Annotated[
        str | None,
        typer.Option(
            help=f"Errors to hold methods by: {', '.join(MEASURES)} [default: end; of a rod that "
            "does not turn: tail]."
        ),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Measure error against run time on SCENE, for methods of rodgen and SciPy, and draw it."""
    from rodgen.analyse.precision.work_precision import work_precision

    if of is not None:
        choose("--of", of, MEASURES)
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("measuring") as step:
            found = work_precision(scene, seconds=seconds, progress=step)
        if of is not None:
            found = replace(found, measure=MEASURES[of][0])
        if as_json:
            print_json(found.to_dict())
            return
        estimate = found.trusted[found.measure] or 0.0
        made, unit = found.reference, _of(found)[1]
        method = f"{made['method']}, order {made['order']}, checked by {made['checked_by']}"
        out.print(f"reference: {method}; good to {estimate:.1e} {unit}")
        out.print(_table(found))
        from rodgen.show.precision_pictures import work_precision as diagram

        figure = diagram(found.rows, found.measure, estimate)
        if figure is not None:
            write_picture(lambda: figure, folder, "precision")


def _of(found: WorkPrecision) -> tuple[str, str, str]:
    """The measure that a result is held by, its unit, and what it is of."""
    return next(one for one in MEASURES.values() if one[0] == found.measure)


def _table(found: WorkPrecision) -> Table:
    """A line for every method: its cheapest settings, least error and largest stable step."""
    from rodgen.analyse.precision.rows import grouped, number, setting, short
    from rodgen.progress import duration

    measure, unit, of = _of(found)
    table = Table(title=f"{found.scene.name}: run time for an error of {of}")
    titles = [f"{short(error, '.0e')} {unit}" for error in ASKED]
    for title in ("method", *titles, "least error", "stable up to"):
        table.add_column(title)
    for name, some in grouped(found.rows, lambda row: f"{row['who']}\0{row['method']}").items():
        who, method = name.split("\0")
        own = who == "rodgen"
        best = [found.cheapest(error, who=who, method=method) for error in ASKED]
        cells = [
            f"{duration(number(row, 'seconds'))}\n{setting(row)}" if row else "-" for row in best
        ]
        least = min((e for row in some if (e := number(row, measure)) >= 0), default=math.inf)
        limit = found.limits.get(method, math.inf) if own else math.inf
        step = f"{limit:.3g} s" if 0 < limit < math.inf else "none" if limit == 0 else "-"
        shown = f"{least:.1e} {unit}" if least < math.inf else "-"
        table.add_row(method if own else f"{who} {method}", *cells, shown, step)
    return table
