"""Table 3.5: the general mass-spring program beside the special model, error and time."""

from __future__ import annotations

import numpy as np
from pandas import DataFrame
from scipy.optimize import brentq

from rodgen.analyse.critical import critical_load
from rodgen.analyse.extrapolation import richardson
from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.critical_forces import continuum_load, growth
from rodgen_evidence.thesis.mass_spring import MassSpring, grow, simulated_critical_load
from rodgen_evidence.thesis.percentages import base_of
from rodgen_evidence.thesis.special_times import STEPS, largest_step, special_seconds, times
from rodgen_evidence.thesis.table import LINKS, VERDICT, Remark, ThesisTable, beside, column

SIMULATED = (10, 20)  # links of which the critical force is simulated as well
SPAN, FACTOR = 20.0, 30.0  # s, of growth
BOUNDS = (0.97, 1.06)  # of the critical force by eigenvalues, between which it is looked for
TIMED = 0.05  # s of motion whose run time is measured
STIFFER = (1.0, 2.0, 4.0, 8.0)  # EA in which the agreement with rigid links is looked at
SOFTEST, STIFFEST = 5e3, 1e7  # N, between which the EA that fits is looked for

COLUMNS = (
    LINKS,
    column("thesis", "thesis: FyDiK", "N", ".2f"),
    column("simulated", "mass-spring, simulated 20 s", "N", ".2f"),
    column("discrete", "mass-spring, eigenvalues", "N", ".5f"),
    column("lumped", "special model, lumped links", "N", ".5f"),
    column("uniform", "special model, uniform links", "N", ".5f"),
    column("continuum", "continuum", "N", ".3f"),
    column("deviation", "thesis against mass-spring", "%", "+.3f"),
    column("fitted", "EA that would give it", "N", ".4g"),
    column("growth", "growth rate at the thesis's force", "1/s", ".3f"),
    column("thesis_seconds", "run time, FyDiK", "s", ".0f"),
    column("seconds", "200 s, mass-spring, NumPy", "s", ".3g"),
    column("special_numpy", "200 s, special, NumPy", "s", ".3g"),
    column("special_c", "200 s, special, C", "s", ".3g"),
    VERDICT,
)


def rod(links: int, axial_stiffness: float = scenes.AXIAL_STIFFNESS) -> MassSpring:
    """The rod of 3.3 as points and springs."""
    return MassSpring(links, **scenes.LONG, axial_stiffness=axial_stiffness)


def table_3_5() -> ThesisTable:
    """Rebuilt: eigenvalues, simulations of few links, run times."""
    printed = data.TABLE_3_5
    pairs = zip(printed["links"], printed["simulated"].astype(float), strict=True)
    rows = DataFrame([_row(links, force) for links, force in pairs])
    rows = beside(rows, printed["simulated"], "the data of the program are not given, see below")
    rows["links"], rows["thesis_seconds"] = printed["links"], printed["seconds"].astype(float)
    table = ThesisTable("3.5", "Critical force by a general mass-spring program", COLUMNS, rows)
    table.conditions = ["L = 5 m, EI = 100 N m^2, 200 s simulated, by FyDiK"]
    table.assumed = [
        f"m = {scenes.MASS:g} kg, m/n at inner points and m/2n at both ends, no damping.",
        f"EA = {scenes.AXIAL_STIFFNESS:.4g} N, from EI and the section of table 3.1.",
        f"Simulated: {SPAN:g} s at twelve forces side by side; critical where a bend grows "
        f"{FACTOR:g} times. Semi-implicit Euler steps of 0.9 of the largest stable one.",
        f"Run times: of one rod at one force, on one core, multiplied to {scenes.WATCHED:g} s of "
        f"motion: the mass-spring model was measured over {TIMED:g} s, multiplied "
        f"{times([scenes.WATCHED / TIMED])}; the special model over {STEPS['numpy']} steps in "
        f"NumPy, {times(_time_factors(rows, 'numpy'))}, and {STEPS['c']} steps in C, "
        f"{times(_time_factors(rows, 'c'))}.",
    ]
    table.notes = [*_notes(rows), Remark("found", base_of("3.5"))]
    return table


def _row(n: int, force: float) -> dict[str, float]:
    model = rod(n)
    exact = model.critical_load()
    low, high = (bound * exact for bound in BOUNDS)
    ours = n in SIMULATED and simulated_critical_load(model, low, high, SPAN, FACTOR)
    timed = grow(model, np.array([force]), TIMED)
    return {
        "simulated": ours or np.nan,
        "discrete": exact,
        "lumped": critical_load(scenes.thrust(n, inertia="lumped")).value,
        "uniform": critical_load(scenes.thrust(n)).value,
        "continuum": continuum_load("free"),
        "fitted": fitted_stiffness(n, force),
        "growth": growth(n, "free", force, "lumped"),
        "seconds": timed.seconds_per_second * scenes.WATCHED,
        "special_numpy": special_seconds(n, "semi_implicit_euler", "numpy") * scenes.WATCHED,
        "special_c": special_seconds(n, "semi_implicit_euler", "c") * scenes.WATCHED,
    }


def _time_factors(rows: DataFrame, target: str) -> list[float]:
    """Lengths of the runs whose times are given, over those that were measured."""
    return [scenes.WATCHED / (largest_step(links) * STEPS[target]) for links in rows["links"]]


def fitted_stiffness(links: int, force: float) -> float:
    """The EA [N] at which the eigenvalues give a critical force [N]; not a number for none."""

    def excess(log: float) -> float:
        return rod(links, float(np.exp(log))).critical_load() - force

    ends = np.log(SOFTEST), np.log(STIFFEST)
    if excess(ends[0]) * excess(ends[1]) > 0:
        return np.nan
    return float(np.exp(brentq(excess, *ends, xtol=1e-6)))


def compliance(links: int) -> tuple[float, float, float]:
    """Approach of the model to rigid links as EA grows: deviation from them [N] at the assumed EA,
    the observed order in 1/EA, and what remains of the deviation in the limit [N]."""
    lumped = critical_load(scenes.thrust(links, inertia="lumped")).value
    softer = [rod(links, scenes.AXIAL_STIFFNESS / 100 * k).critical_load() for k in STIFFER]
    limit = richardson(STIFFER, softer)
    at_assumed = rod(links).critical_load() - lumped
    return at_assumed, limit.orders[-1], limit.value - lumped


def _notes(rows: DataFrame) -> list[Remark]:
    links = rows["links"]
    off, order, rest = compliance(links[0])
    above, rates, fits = rows["deviation"], rows["growth"], rows["fitted"]
    ratios = ", ".join(f"{ratio:.0f}" for ratio in rows["seconds"] / rows["special_numpy"])
    special = data.TABLE_3_4.set_index("links")["seconds"].astype(float)
    printed = rows["thesis_seconds"] / links.map(special)
    return [
        Remark(
            "shown",
            f"The two models agree: with n = {links[0]}, points on springs are {off:+.2g} N from "
            f"lumped rigid links; the difference vanishes with the order {order:.3f} in 1/EA, to "
            f"{rest:+.1g} N in the limit. They share no equation.",
        ),
        Remark(
            "shown",
            f"FyDiK's values are {above.min():.2f} to {above.max():.2f} % above those of lumped "
            "links: one factor and the convergence of lumped mass explain the column, which is "
            "why it crosses that of the special model. Where the factor comes from is open:",
        ),
        Remark(
            "consistent",
            f"(a) Soft axial springs: EA between {fits.min():.3g} and {fits.max():.3g} N, some "
            f"{scenes.AXIAL_STIFFNESS / fits.max():.0f} times softer than the steel "
            "section, would raise the critical force so far (the compressed rod is shorter), and "
            "allow longer steps.",
        ),
        Remark(
            "consistent",
            "(b) Damping or late detection: at the printed forces flutter grows at "
            f"{rates.min():.3f} to {rates.max():.3f} 1/s with {scenes.MASS:g} kg; a damping of "
            "twice that rate on every mass would just hold it.",
        ),
        Remark(
            "estimated",
            "Why a special model: the axial springs are the fastest part of the general one, and "
            f"its steps are shorter for them: {ratios} times the run time of the special "
            f"model, both in NumPy (n = {', '.join(map(str, links))}), each from "
            f"a time that was multiplied, {times([scenes.WATCHED / TIMED])} and "
            f"{times(_time_factors(rows, 'numpy'))}: a step costs the same at any time.",
        ),
        Remark(
            "shown",
            "The printed run times of FyDiK are those of table 3.4 times "
            f"{printed.min():.3f} to {printed.max():.3f}, for every n: two programs measured one "
            "by one would scatter, and their steps would not grow alike. Why is open; they are no "
            "independent measurements.",
        ),
    ]
