"""Tables of errors over tolerances, and the runs of auto that are off by too many of them."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from rodgen_evidence.tolerance.measure.error_kinds import ANGLES, KINDS, RATES
from rodgen_evidence.tolerance.measure.scene_record import AUTO
from rodgen_evidence.tolerance.over_tolerance import Over, over_tolerance

Record = dict[str, Any]

MUST = ANGLES, RATES  # of which 1 scene of 100 may exceed what is allowed, and none FAR
FAR = 50.0
WEAK = 0.01  # of critical damping: of a fastest motion with less, errors of many steps add up
KINKS = "drag", "external_damping"  # whose forces are not smooth where a joint turns back


def show_errors(lines: list[Record], console: Console) -> tuple[int, int]:
    """Print the distribution of errors, and every run of auto that exceeds what is allowed; the
    number of such scenes by angles and rates, and of those that are far off."""
    found = [over for line in lines for over in over_tolerance(line)]
    for place in ("samples", "end"):
        console.print(_distribution(found, place, len(lines)))
    return _exceeding(found, lines, console)


def _distribution(found: list[Over], place: str, scenes: int) -> Table:
    """Median, 95 % and worst of each method, tolerance and kind."""
    cells: dict[tuple[str, float], dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for over in found:
        cells[over.method, over.rtol][over.kind].append(getattr(over, place))
    title = f"error over tolerance at {'all samples' if place == 'samples' else 'the end'}"
    table = Table(title=f"{title}, {scenes} scenes: median / 95 % / worst (runs)")
    for column in ("method", "rtol", *KINDS):
        table.add_column(column, justify="left" if column == "method" else "right")
    for (method, rtol), kinds in sorted(cells.items(), key=lambda one: (one[0][0], -one[0][1])):
        table.add_row(method, f"{rtol:g}", *(_cell(kinds[kind]) for kind in KINDS))
    return table


def _cell(values: list[float]) -> str:
    if not values:
        return ""
    parts = *np.percentile(values, [50, 95]), max(values)
    return " / ".join(f"{part:.2g}" for part in parts) + f" ({len(values)})"


def _exceeding(found: list[Over], lines: list[Record], console: Console) -> tuple[int, int]:
    """Print the runs of auto that exceed what is allowed."""
    mine = [over for over in found if over.method == AUTO]
    beyond = sorted((over for over in mine if over.exceeds), key=lambda over: -over.samples)
    for over in beyond:
        text = f"{over.seed}: {over.kind} off by {over.samples:.3g} tolerances at rtol "
        text += f"{over.rtol:g} ({over.end:.3g} at the end; {over.allowed:.3g} allowed), by "
        text += f"{over.chosen} in {over.steps} steps"
        console.print(text, highlight=False, markup=False, soft_wrap=True)
    console.print(_by_group(mine, lines))
    wrong = {over.seed for over in beyond if over.kind in MUST}
    far = {over.seed for over in beyond if over.kind in MUST and over.samples > FAR}
    judged = {over.seed for over in mine if over.kind in MUST}
    loose = [line for line in lines if line["reference"] and line["reference"]["growth"] > FAR]
    console.print(
        f"auto: angles or rates beyond what is allowed, without a warning: {len(wrong)} of "
        f"{len(judged)} scenes that are judged, {len(far)} beyond {FAR:g} tolerances; all kinds: "
        f"{len({over.seed for over in beyond})}. In {len(loose)} scenes a shift of the start grows "
        f"more than {FAR:g} times. Without a reference: {len(lines) - len(judged)}.",
        soft_wrap=True,
    )
    return len(wrong), len(far)


def _group(features: Record) -> str:
    """Kinds of scenes whose errors have causes of their own."""
    if any(load in KINKS for load in features["loads"]):
        return "drag or external damping"
    damping = features["damping"]
    return "weakly damped" if damping is None or damping < WEAK else "damped"


def _by_group(mine: list[Over], lines: list[Record]) -> Table:
    """Angles and rates of auto: how many runs exceed what is allowed, and by how much a step."""
    known = {line["seed"]: _group(line["features"]) for line in lines}
    table = Table(title="angles and rates of auto, by kind of scene")
    columns = "scenes", "rtol", "runs", "exceed", "over tolerance", "over tolerance a step"
    for column in ("kind", *columns):
        table.add_column(column, justify="right")
    for group in sorted({*known.values()}):
        of = [over for over in mine if over.kind in MUST and known[over.seed] == group]
        scenes = str(len({over.seed for over in of}))
        for rtol in sorted({over.rtol for over in of}, reverse=True):
            at = [over for over in of if over.rtol == rtol]
            exceed = {over.seed for over in at if over.exceeds}
            cells = [f"{rtol:g}", str(len({over.seed for over in at})), str(len(exceed))]
            worst = [_cell([over.samples for over in at])]
            worst.append(_cell([over.samples / max(1, over.steps) for over in at]))
            table.add_row(group, scenes, *cells, *worst)
    return table
