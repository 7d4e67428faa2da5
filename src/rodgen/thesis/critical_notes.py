"""What was found about tables 3.4 and 3.6."""

from __future__ import annotations

import numpy as np

from rodgen.analyse import columns
from rodgen.analyse.extrapolate import richardson
from rodgen.thesis import data, scenes
from rodgen.thesis.table import Cell, Note, percent


def continuum_load(boundary: str, length: float = scenes.LENGTH) -> float:
    """Critical force of the continuum [N]."""
    onset = columns.thrust() if boundary == "free" else columns.beck()
    return float(onset.load) * scenes.STIFFNESS / length**2


def on_growth(rows: list[dict[str, Cell]]) -> Note:
    grown = [float(row["growth"] or 0) for row in rows]
    middle = float(np.median(grown))
    held = [2 * exponent / scenes.WATCHED for exponent in grown]
    return Note(
        "consistent",
        f"{_above(rows)} printed forces lie above the critical one of the discrete model, where "
        f"flutter grows slowly: within 200 s by exp({min(grown):.1f}) to exp({max(grown):.1f}), "
        f"median exp({middle:.1f}), with a mass of {scenes.MASS:g} kg. A simulation that starts "
        "from a disturbance too small to see needs such a factor before it calls the rod unstable; "
        f"or a damping of the masses, {min(held):.2f} to {max(held):.2f} 1/s, holds it up to "
        "there. Neither the mass nor the disturbance nor a damping is given: this fits, but is not "
        "shown.",
    )


def _above(rows: list[dict[str, Cell]]) -> str:
    count = sum(float(row["deviation"] or 0) > 0 for row in rows)
    return f"All {count}" if count == len(rows) else f"{count} of the {len(rows)}"


def on_rounding() -> list[Note]:
    """Printed values of (3.4) that are not the formula's, rounded."""
    exact = {
        row.links: float(data.BECK_COEFFICIENT) * scenes.STIFFNESS / (5 - 5 / row.links) ** 2
        for row in data.TABLE_3_6
    }
    wrong = [
        f"{row.analytical} N at n = {row.links}, of {exact[row.links]:.4f} N"
        for row in data.TABLE_3_6
        if f"{exact[row.links]:.2f}" != row.analytical
    ]
    text = f"Cut off or misprinted instead of rounded in the analytical column: {'; '.join(wrong)}."
    return [Note("found", text)] if wrong else []


def on_ours(rows: list[dict[str, Cell]]) -> Note:
    off = [float(row["ours_deviation"] or 0) for row in rows]
    early = [row for row in rows if row["beat"] is not None]
    late = [row for row in rows if row["beat"] is None]
    text = (
        f"Our simulation, which calls a hundredfold bend unstable, is off by {min(off):+.4f} to "
        f"{max(off):+.4f} %."
    )
    if early:
        periods = [float(row["beat"] or 0) for row in early]
        text += (
            f" With n = {_links(early)} its force is too small: nothing grows there, for the two "
            "frequencies have not met. Their shapes are nearly alike, and a bend made of both "
            f"beats: it becomes a hundredfold and goes back again, in {_span(periods)} s."
        )
    if late:
        text += (
            f" With n = {_links(late)} it is too large: beyond the onset flutter grows so slowly "
            "that it is seen late."
        )
    return Note("shown", f"{text} A simulation of {scenes.WATCHED:g} s cannot tell the two apart.")


def _span(values: list[float]) -> str:
    least, most = f"{min(values):.0f}", f"{max(values):.0f}"
    return least if least == most else f"{least} to {most}"


def _links(rows: list[dict[str, Cell]]) -> str:
    return ", ".join(str(row["links"]) for row in rows)


def on_coefficient() -> Note:
    true = columns.thrust().load
    return Note(
        "shown",
        f"(3.3) has the coefficient {data.THRUST_COEFFICIENT}; the characteristic equation gives "
        f"{true:.10f}, {percent(float(data.THRUST_COEFFICIENT), float(true)):+.3f} % of "
        f"difference, {continuum_load('free'):.3f} N instead of {data.THRUST} N. The deviations "
        "that the table gives near n = 50 are smaller than this error.",
    )


def on_convergence(rows: list[dict[str, Cell]]) -> Note:
    counts = [float(row["links"] or 0) for row in rows]
    ours = richardson(counts, [float(row["discrete"] or 0) for row in rows])
    return Note(
        "shown",
        f"Eigenvalues extrapolated over n: {ours.value:.6f} N, error about {ours.error:.1g} N, "
        f"observed order {ours.orders[-1]:.2f}; the continuum has {continuum_load('free'):.6f} N.",
    )
