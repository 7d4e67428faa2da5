"""Table 3.5: the general mass-spring program beside the special model, error and time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from rodgen.analyse.critical import critical_force
from rodgen.analyse.extrapolate import richardson
from rodgen.thesis import data, scenes
from rodgen.thesis.critical import growth
from rodgen.thesis.critical_notes import continuum_load
from rodgen.thesis.mass_spring import MassSpring
from rodgen.thesis.mass_spring_runs import grow, simulated_critical_force
from rodgen.thesis.percentages import base_of
from rodgen.thesis.table import Cell, Column, Note, Table, percent, verdict
from rodgen.thesis.timing import STEPS, largest_step, special_seconds, times

SIMULATED = (10, 20)  # links of which the critical force is simulated as well
SPAN, FACTOR = 20.0, 30.0  # s, of growth
BOUNDS = (0.97, 1.06)  # of the critical force by eigenvalues, between which it is looked for
TIMED = 0.05  # s of motion whose run time is measured
STIFFER = (1.0, 2.0, 4.0, 8.0)  # EA in which the agreement with rigid links is looked at
SOFTEST, STIFFEST = 5e3, 1e7  # N, between which the EA that fits is looked for

COLUMNS = (
    Column("links", "links"),
    Column("thesis", "thesis: FyDiK", "N", ".2f"),
    Column("simulated", "mass-spring, simulated 20 s", "N", ".2f"),
    Column("discrete", "mass-spring, eigenvalues", "N", ".5f"),
    Column("lumped", "special model, lumped links", "N", ".5f"),
    Column("uniform", "special model, uniform links", "N", ".5f"),
    Column("continuum", "continuum", "N", ".3f"),
    Column("deviation", "thesis against mass-spring", "%", "+.3f"),
    Column("fitted", "EA that would give it", "N", ".4g"),
    Column("growth", "growth rate at the thesis's force", "1/s", ".3f"),
    Column("thesis_seconds", "run time, FyDiK", "s", ".0f"),
    Column("seconds", "200 s, mass-spring, NumPy", "s", ".3g"),
    Column("special_numpy", "200 s, special, NumPy", "s", ".3g"),
    Column("special_c", "200 s, special, C", "s", ".3g"),
    Column("verdict", "verdict"),
)


def rod(links: int, axial_stiffness: float = scenes.AXIAL_STIFFNESS) -> MassSpring:
    """The rod of 3.3 as points and springs."""
    return MassSpring(links, scenes.MASS, scenes.LENGTH, scenes.STIFFNESS, axial_stiffness)


def table_3_5(
    links: Sequence[int] | None = None, simulated: Sequence[int] = SIMULATED, span: float = SPAN
) -> Table:
    """Rebuilt; links: those of the rows, or all; simulated: those that are simulated as well."""
    printed = [row for row in data.TABLE_3_5 if links is None or row.links in links]
    rows = [_row(row, row.links in simulated, span) for row in printed]
    table = Table("3.5", "Critical force by a general mass-spring program", COLUMNS, rows)
    table.conditions = ["L = 5 m, EI = 100 N m^2, 200 s simulated, by FyDiK"]
    table.assumed = [
        f"m = {scenes.MASS:g} kg, m/n at inner points and m/2n at both ends, no damping.",
        f"EA = {scenes.AXIAL_STIFFNESS:.4g} N, from EI and the section of table 3.1.",
        f"Simulated: {span:g} s at twelve forces side by side; critical where a bend grows "
        f"{FACTOR:g} times. Semi-implicit Euler steps of 0.9 of the largest stable one.",
        f"Run times: of one rod at one force, on one core, multiplied to {scenes.WATCHED:g} s of "
        f"motion: the mass-spring model was measured over {TIMED:g} s, multiplied "
        f"{times([scenes.WATCHED / TIMED])}; the special model over {STEPS['numpy']} steps in "
        f"NumPy, {times(_multiplied(rows, 'numpy'))}, and {STEPS['c']} steps in C, "
        f"{times(_multiplied(rows, 'c'))}.",
    ]
    table.notes = [*_notes(rows), Note("found", base_of("3.5"))]
    return table


def _row(printed: data.Critical, simulated: bool, span: float) -> dict[str, Cell]:
    n, force = printed.links, float(printed.force)
    model = rod(n)
    exact = model.critical_force()
    low, high = (bound * exact for bound in BOUNDS)
    ours = simulated_critical_force(model, low, high, span, FACTOR).force if simulated else None
    timed = grow(model, np.array([force]), TIMED)
    return {
        "links": n,
        "thesis": force,
        "simulated": ours,
        "discrete": exact,
        "lumped": critical_force(scenes.thrust(n, inertia="lumped")).force,
        "uniform": critical_force(scenes.thrust(n)).force,
        "continuum": continuum_load("free"),
        "deviation": percent(force, exact),
        "fitted": fitted_stiffness(n, force),
        "growth": growth(n, "free", force, "lumped"),
        "thesis_seconds": float(printed.seconds),
        "seconds": timed.seconds_per_second * scenes.WATCHED,
        "special_numpy": special_seconds(n, "semi_implicit_euler", "numpy") * scenes.WATCHED,
        "special_c": special_seconds(n, "semi_implicit_euler", "c") * scenes.WATCHED,
        "verdict": verdict(
            printed.force, exact, "the data of the program are not given, see below"
        ),
    }


def _multiplied(rows: list[dict[str, Cell]], target: str) -> list[float]:
    """How many times longer than what was measured the runs are whose times are given."""
    spans = [largest_step(int(row["links"] or 0)) * STEPS[target] for row in rows]
    return [scenes.WATCHED / span for span in spans]


def fitted_stiffness(links: int, force: float) -> float | None:
    """The EA [N] at which the eigenvalues give a critical force [N]; None where none does."""

    def excess(log: float) -> float:
        return rod(links, float(np.exp(log))).critical_force() - force

    ends = np.log(SOFTEST), np.log(STIFFEST)
    if excess(ends[0]) * excess(ends[1]) > 0:
        return None
    return float(np.exp(brentq(excess, *ends, xtol=1e-6)))


def compliance(links: int) -> tuple[float, float, float]:
    """How the model meets rigid links as EA grows: the deviation from them [N] at the assumed EA,
    the observed order in 1/EA, and what remains of the deviation in the limit [N]."""
    lumped = critical_force(scenes.thrust(links, inertia="lumped")).force
    softer = [rod(links, scenes.AXIAL_STIFFNESS / 100 * k).critical_force() for k in STIFFER]
    limit = richardson(STIFFER, softer)
    at_assumed = rod(links).critical_force() - lumped
    return at_assumed, limit.orders[-1], limit.value - lumped


def _notes(rows: list[dict[str, Cell]]) -> list[Note]:
    links = int(rows[0]["links"] or 0)
    off, order, rest = compliance(links)
    above = [float(row["deviation"] or 0) for row in rows]
    rates = [float(row["growth"] or 0) for row in rows]
    fits = [float(row["fitted"]) for row in rows if isinstance(row["fitted"], float)]
    return [
        Note(
            "shown",
            f"The two models agree: with n = {links}, points on springs are {off:+.2g} N from "
            f"lumped rigid links; the difference vanishes with the order {order:.3f} in 1/EA, to "
            f"{rest:+.1g} N in the limit. They share no equation.",
        ),
        Note(
            "shown",
            f"FyDiK's values are {min(above):.2f} to {max(above):.2f} % above those of lumped "
            "links: one factor and the convergence of lumped mass explain the column, which is "
            "why it crosses that of the special model. Where the factor comes from is open:",
        ),
        Note(
            "consistent",
            f"(a) Soft axial springs: EA between {min(fits, default=0):.3g} and "
            f"{max(fits, default=0):.3g} N, some "
            f"{scenes.AXIAL_STIFFNESS / max(fits, default=1.0):.0f} times softer than the steel "
            "section, would raise the critical force so far (the compressed rod is shorter), and "
            "allow longer steps.",
        ),
        Note(
            "consistent",
            f"(b) Damping or late detection: at the printed forces flutter grows at "
            f"{min(rates):.3f} to {max(rates):.3f} 1/s with {scenes.MASS:g} kg; a damping of twice "
            "that rate on every mass would just hold it.",
        ),
        Note(
            "estimated",
            "Why a special model: the axial springs are the fastest part of the general one, and "
            f"its steps are shorter for them: {_ratios(rows)} times the run time of the special "
            f"model, both in NumPy (n = {', '.join(str(row['links']) for row in rows)}), each from "
            f"a time that was multiplied, {times([scenes.WATCHED / TIMED])} and "
            f"{times(_multiplied(rows, 'numpy'))}: a step costs the same at any time.",
        ),
        _note_on_times(rows),
    ]


def _ratios(rows: list[dict[str, Cell]]) -> str:
    pairs = ((float(row["seconds"] or 0), float(row["special_numpy"] or 1)) for row in rows)
    return ", ".join(f"{general / special:.0f}" for general, special in pairs)


def _note_on_times(rows: list[dict[str, Cell]]) -> Note:
    special = {row.links: float(row.seconds) for row in data.TABLE_3_4}
    ratios = [float(row["thesis_seconds"] or 0) / special[int(row["links"] or 0)] for row in rows]
    return Note(
        "shown",
        "The printed run times of FyDiK are those of table 3.4 times "
        f"{min(ratios):.3f} to {max(ratios):.3f}, for every n: two programs measured one by one "
        "would scatter, and their steps would not grow alike. Why is open; they are no independent "
        "measurements.",
    )
