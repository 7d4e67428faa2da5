"""Critical forces of the thesis beside those of eigenvalues, with notes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pandas import DataFrame

from rodgen.analyse.critical import critical_load
from rodgen.analyse.extrapolation import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references import follower_columns
from rodgen.analyse.simulated_critical import SimulatedCritical, simulated_critical_load
from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.percentages import base_of, beck
from rodgen_evidence.thesis.special_times import fastest
from rodgen_evidence.thesis.table import (
    LINKS,
    VERDICT,
    Remark,
    ThesisTable,
    beside,
    column,
    percent,
)


def continuum_load(boundary: str, length: float = scenes.LENGTH) -> float:
    """Critical force of the continuum [N]."""
    onset = follower_columns.thrust() if boundary == "free" else follower_columns.beck()
    return float(onset.load) * scenes.STIFFNESS / length**2


def on_growth(rows: DataFrame) -> Remark:
    grown = rows["growth"]
    held = 2 * grown / scenes.WATCHED
    count = (rows["deviation"] > 0).sum()
    above = f"All {count}" if count == len(rows) else f"{count} of the {len(rows)}"
    return Remark(
        "consistent",
        f"{above} printed forces lie above the critical one of the discrete model, where flutter "
        f"grows slowly: within 200 s by exp({grown.min():.1f}) to exp({grown.max():.1f}), median "
        f"exp({grown.median():.1f}), with a mass of {scenes.MASS:g} kg. A simulation that starts "
        "from a disturbance too small to see needs such a factor before it calls the rod unstable; "
        f"or a damping of the masses, {held.min():.2f} to {held.max():.2f} 1/s, holds it up to "
        "there. Neither the mass nor the disturbance nor a damping is given: this fits, but is not "
        "shown.",
    )


def on_rounding() -> list[Remark]:
    """Printed values of (3.4) that are not the formula's, rounded."""
    wrong = [
        f"{row.analytical} N at n = {row.links}, of {beck(row.links):.4f} N"
        for row in data.TABLE_3_6.itertuples()
        if f"{beck(row.links):.2f}" != row.analytical
    ]
    text = f"Cut off or misprinted instead of rounded in the analytical column: {'; '.join(wrong)}."
    return [Remark("found", text)] if wrong else []


def on_ours(rows: DataFrame) -> Remark:
    off, early = rows["ours_deviation"], rows["beat"].notna()
    small, large = (", ".join(map(str, rows["links"][some])) for some in (early, ~early))
    text = (
        f"Our simulation, which calls a hundredfold bend unstable, is off by {off.min():+.4f} to "
        f"{off.max():+.4f} %."
    )
    if early.any():
        ends = rows["beat"].min(), rows["beat"].max()
        periods = dict.fromkeys(f"{period:.0f}" for period in ends)
        text += (
            f" With n = {small} its force is too small: nothing grows there, for the two "
            "frequencies have not met. Their shapes are nearly alike, and a bend made of both "
            f"beats: it becomes a hundredfold and goes back again, in {' to '.join(periods)} s."
        )
    if not early.all():
        text += (
            f" With n = {large} it is too large: beyond the onset flutter grows so slowly "
            "that it is seen late."
        )
    return Remark(
        "shown", f"{text} A simulation of {scenes.WATCHED:g} s cannot tell the two apart."
    )


def on_coefficient() -> Remark:
    true = follower_columns.thrust().load
    return Remark(
        "shown",
        f"(3.3) has the coefficient {data.THRUST_COEFFICIENT}; the characteristic equation gives "
        f"{true:.10f}, {percent(float(data.THRUST_COEFFICIENT), float(true)):+.3f} % of "
        f"difference, {continuum_load('free'):.3f} N instead of {data.THRUST} N. The deviations "
        "that the table gives near n = 50 are smaller than this error.",
    )


def on_convergence(rows: DataFrame) -> Remark:
    ours = richardson(list(rows["links"]), list(rows["discrete"]))
    return Remark(
        "shown",
        f"Eigenvalues extrapolated over n: {ours.value:.6f} N, error about {ours.error:.1g} N, "
        f"observed order {ours.orders[-1]:.2f}; the continuum has {continuum_load('free'):.6f} N.",
    )


FLUTTER_AMONG = 4  # the lowest modes, among which the pair that flutters is
BEAT = "beat at our simulated force, where nothing grows"
GROWTH = "ln(growth in 200 s) at the thesis's force"
# Bent as the boundary allows, so that nothing but flutter makes the bending a hundredfold.
BENT = {"free": "1e-5*(cos(pi*s) + cos(2*pi*s))", "cantilever": "1e-5*s**2"}
SAFETY = 0.8  # of the largest stable step of the free rod, at most; held, it is slower
WHOLE = 0.5  # s, of which a step is a whole fraction: a step that changes pumps fast modes up
HUNDREDFOLD = 100.0  # times the bending of the start: what the thesis calls unstable
TOLERANCE = 2e-5  # of the simulated force
AROUND = (0.97, 1.03)  # of the critical force by eigenvalues: there it is looked for by simulation

FORCES = (
    LINKS,
    column("thesis", "thesis: simulated", "N", ".2f"),
    column("simulated", "ours: simulated, 200 s", "N", ".3f"),
    column("discrete", "discrete model, eigenvalues", "N", ".6f"),
)
DEVIATIONS = (
    column("deviation", "thesis against discrete", "%", "+.3f"),
    column("ours_deviation", "our simulation against discrete", "%", "+.4f"),
    column("from_continuum", "thesis against continuum", "%", "+.3f"),
    column("beat", BEAT, "s", ".0f"),
    column("growth", GROWTH, "", ".1f"),
)
COLUMNS_3_4 = (
    *FORCES,
    column("continuum", "continuum", "N", ".4f"),
    *DEVIATIONS,
    column("thesis_seconds", "run time, thesis", "s", ".3f"),
    column("seconds", "one run of 200 s, ours", "s", ".3f"),
    VERDICT,
)
COLUMNS_3_6 = (
    *FORCES,
    column("thesis_analytical", "thesis: 20.05 EI/(L - L/n)^2", "N", ".2f"),
    column("continuum", "continuum, length L - L/n", "N", ".4f"),
    column("clamped", "better clamp, length L", "N", ".4f"),
    *DEVIATIONS,
    VERDICT,
)
CONDITIONS = ["L = 5 m, EI = 100 N m^2, 200 s simulated"]


def growth(links: int, boundary: str, force: float, inertia: str = "uniform") -> float:
    """Rate [1/s] at which flutter grows under a force [N]; 0 where nothing grows."""
    scene = scenes.thrust(links, boundary, inertia, force=force)
    return float(natural_modes(scene, FLUTTER_AMONG).growth.max(initial=0.0))


def beat(links: int, boundary: str, force: float) -> float:
    """Period [s] in which the two of the lowest modes that are next to each other in frequency beat
    under a force [N]; not a number where one grows."""
    modes = natural_modes(scenes.thrust(links, boundary, force=force), FLUTTER_AMONG)
    return np.nan if modes.growth.any() else float(1 / np.diff(modes.frequencies).min())


def table_3_4(links: Sequence[int] | None = None, span: float = scenes.WATCHED) -> ThesisTable:
    """Free rod under thrust; links: those of the rows, or all."""
    every = data.TABLE_3_4
    printed = every if links is None else every[every["links"].isin(links)].reset_index(drop=True)
    rows = _rows("free", printed, span)
    rows["thesis_seconds"] = printed["seconds"].astype(float)
    table = ThesisTable("3.4", "Critical force of the free rod", COLUMNS_3_4, rows, [*CONDITIONS])
    table.assumed = [_assumptions(span)]
    table.notes = [
        on_growth(rows),
        on_ours(rows),
        on_coefficient(),
        Remark("found", base_of("3.4")),
    ]
    if len(rows) > 3:
        table.notes.append(on_convergence(rows))
    return table


def table_3_6() -> ThesisTable:
    """Cantilever under a follower force."""
    printed = data.TABLE_3_6
    rows = _rows("cantilever", printed, scenes.WATCHED)
    rows["thesis_analytical"] = printed["analytical"].astype(float)
    rows["clamped"] = [critical_load(scenes.thrust(n, "clamped")).value for n in rows["links"]]
    table = ThesisTable("3.6", "Critical force of the cantilever", COLUMNS_3_6, rows, [*CONDITIONS])
    table.assumed = [_assumptions(scenes.WATCHED)]
    table.notes = [
        on_growth(rows),
        on_ours(rows),
        Remark(
            "shown",
            "The values fall with n towards 20.05 EI/L^2 as those of the discrete model do, and "
            "lie below (3.4), the analytical column: the first spring, one link from the wall, "
            "makes the rod softer than the continuous one of the length L - L/n, which (3.4) is "
            "for.",
        ),
        Remark("found", base_of("3.6")),
        *on_rounding(),
    ]
    return table


def _rows(boundary: str, printed: DataFrame, span: float) -> DataFrame:
    """Rows for the printed forces."""
    forces = printed["simulated"].astype(float)
    pairs = zip(printed["links"], forces, strict=True)
    rows = DataFrame([_row(links, boundary, force, span) for links, force in pairs])
    return beside(rows, printed["simulated"], "see below").assign(
        links=printed["links"],
        ours_deviation=percent(rows["simulated"], rows["discrete"]),
        from_continuum=percent(forces, rows["continuum"]),
    )


def _row(links: int, boundary: str, force: float, span: float) -> dict[str, float]:
    exact = critical_load(scenes.thrust(links, boundary)).value
    ours = simulate_critical_force(links, boundary, exact, span)
    length = scenes.LENGTH * (1 if boundary == "free" else 1 - 1 / links)
    return {
        "simulated": ours.value,
        "discrete": exact,
        "continuum": continuum_load(boundary, length),
        "beat": beat(links, boundary, ours.value),
        "growth": growth(links, boundary, force) * scenes.WATCHED,
        "seconds": ours.seconds / ours.runs,
    }


def simulate_critical_force(
    links: int, boundary: str, near: float, span: float
) -> SimulatedCritical:
    """Find the critical force as the thesis did, by growth within a span [s], next to `near` [N],
    by the semi-implicit Euler method."""
    scene = scenes.thrust(links, boundary)
    step = WHOLE / np.ceil(WHOLE * fastest(links) / (2 * SAFETY))
    return simulated_critical_load(
        scene,
        span=span,
        growth=HUNDREDFOLD,
        tolerance=TOLERANCE,
        bounds=(AROUND[0] * near, AROUND[1] * near),
        disturbance=BENT[boundary],
        method="semi_implicit_euler",
        step=float(step),
    )


def _assumptions(span: float) -> str:
    return (
        f"m = {scenes.MASS:g} kg, no damping, no gravity. Simulated: bent by 1e-5 rad, called "
        f"unstable if the bending grows a hundred times within {span:g} s; forces halved to "
        f"{TOLERANCE:g} of the force; semi-implicit Euler steps of {SAFETY:g} of the largest "
        "stable one. The mass does not change the critical force, only how fast flutter grows."
    )
