"""Tables 3.4 and 3.6: critical follower forces of the free rod and of the cantilever."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rodgen.analyse.critical import critical_force
from rodgen.analyse.growth import SimulatedCritical, simulated_critical_force
from rodgen.analyse.modes import natural_modes
from rodgen.thesis import critical_notes, data, scenes
from rodgen.thesis.percentages import base_of
from rodgen.thesis.table import Cell, Column, Note, Table, percent, verdict
from rodgen.thesis.timing import fastest

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

COLUMNS_3_4 = (
    Column("links", "links"),
    Column("thesis", "thesis: simulated", "N", ".2f"),
    Column("simulated", "ours: simulated, 200 s", "N", ".3f"),
    Column("discrete", "discrete model, eigenvalues", "N", ".6f"),
    Column("continuum", "continuum", "N", ".4f"),
    Column("deviation", "thesis against discrete", "%", "+.3f"),
    Column("ours_deviation", "our simulation against discrete", "%", "+.4f"),
    Column("from_continuum", "thesis against continuum", "%", "+.3f"),
    Column("beat", BEAT, "s", ".0f"),
    Column("growth", GROWTH, "", ".1f"),
    Column("thesis_seconds", "run time, thesis", "s", ".3f"),
    Column("seconds", "one run of 200 s, ours", "s", ".3f"),
    Column("verdict", "verdict"),
)
COLUMNS_3_6 = (
    Column("links", "links"),
    Column("thesis", "thesis: simulated", "N", ".2f"),
    Column("simulated", "ours: simulated, 200 s", "N", ".3f"),
    Column("discrete", "discrete model, eigenvalues", "N", ".6f"),
    Column("thesis_analytical", "thesis: 20.05 EI/(L - L/n)^2", "N", ".2f"),
    Column("continuum", "continuum, length L - L/n", "N", ".4f"),
    Column("clamped", "better clamp, length L", "N", ".4f"),
    Column("deviation", "thesis against discrete", "%", "+.3f"),
    Column("ours_deviation", "our simulation against discrete", "%", "+.4f"),
    Column("from_continuum", "thesis against continuum", "%", "+.3f"),
    Column("beat", BEAT, "s", ".0f"),
    Column("growth", GROWTH, "", ".1f"),
    Column("verdict", "verdict"),
)
CONDITIONS = ["L = 5 m, EI = 100 N m^2, 200 s simulated"]


def growth(links: int, boundary: str, force: float, inertia: str = "uniform") -> float:
    """Rate [1/s] at which flutter grows under a force [N]; 0 where nothing grows."""
    scene = scenes.thrust(links, boundary, inertia, force=force)
    return float(natural_modes(scene, FLUTTER_AMONG).growth.max(initial=0.0))


def beat(links: int, boundary: str, force: float) -> float | None:
    """Period [s] in which the two of the lowest modes that are next to each other in frequency beat
    under a force [N]; None where one grows."""
    modes = natural_modes(scenes.thrust(links, boundary, force=force), FLUTTER_AMONG)
    return None if modes.growth.any() else float(1 / np.diff(modes.frequencies).min())


def table_3_4(links: Sequence[int] | None = None, span: float = scenes.WATCHED) -> Table:
    """Free rod under thrust; links: those of the rows, or all."""
    printed = [row for row in data.TABLE_3_4 if links is None or row.links in links]
    rows = [
        _row(row.links, "free", row.force, span) | {"thesis_seconds": float(row.seconds)}
        for row in printed
    ]
    table = Table("3.4", "Critical force of the free rod", COLUMNS_3_4, rows, [*CONDITIONS])
    table.assumed = [_assumed(span)]
    table.notes = [
        critical_notes.on_growth(rows),
        critical_notes.on_ours(rows),
        critical_notes.on_coefficient(),
        Note("found", base_of("3.4")),
    ]
    if len(rows) > 3:
        table.notes.append(critical_notes.on_convergence(rows))
    return table


def table_3_6(links: Sequence[int] | None = None, span: float = scenes.WATCHED) -> Table:
    """Cantilever under a follower force; links: those of the rows, or all."""
    printed = [row for row in data.TABLE_3_6 if links is None or row.links in links]
    rows = [
        _row(row.links, "cantilever", row.simulated, span)
        | {
            "thesis_analytical": float(row.analytical),
            "clamped": critical_force(scenes.thrust(row.links, "clamped")).force,
        }
        for row in printed
    ]
    table = Table("3.6", "Critical force of the cantilever", COLUMNS_3_6, rows, [*CONDITIONS])
    table.assumed = [_assumed(span)]
    table.notes = [
        critical_notes.on_growth(rows),
        critical_notes.on_ours(rows),
        Note(
            "shown",
            "The values fall with n towards 20.05 EI/L^2 as those of the discrete model do, and "
            "lie below (3.4), the analytical column: the first spring, one link from the wall, "
            "makes the rod softer than the continuous one of the length L - L/n, which (3.4) is "
            "for.",
        ),
        Note("found", base_of("3.6")),
        *critical_notes.on_rounding(),
    ]
    return table


def _row(links: int, boundary: str, printed: str, span: float) -> dict[str, Cell]:
    force = float(printed)
    exact = critical_force(scenes.thrust(links, boundary)).force
    ours = simulated(links, boundary, exact, span)
    length = scenes.LENGTH * (1 if boundary == "free" else 1 - 1 / links)
    truth = critical_notes.continuum_load(boundary, length)
    return {
        "links": links,
        "thesis": force,
        "simulated": ours.force,
        "discrete": exact,
        "continuum": truth,
        "deviation": percent(force, exact),
        "ours_deviation": percent(ours.force, exact),
        "from_continuum": percent(force, truth),
        "beat": beat(links, boundary, ours.force),
        "growth": growth(links, boundary, force) * scenes.WATCHED,
        "seconds": ours.seconds / ours.runs,
        "verdict": verdict(printed, exact, "see below"),
    }


def simulated(links: int, boundary: str, near: float, span: float) -> SimulatedCritical:
    """The critical force as the thesis found it, by growth within a span [s], next to `near` [N],
    by the semi-implicit Euler method."""
    scene = scenes.thrust(links, boundary)
    low, high = (bound * near for bound in AROUND)
    step = WHOLE / np.ceil(WHOLE * fastest(links) / (2 * SAFETY))
    return simulated_critical_force(
        scene,
        span=span,
        growth=HUNDREDFOLD,
        tolerance=TOLERANCE,
        low=low,
        high=high,
        disturbance=BENT[boundary],
        method="semi_implicit_euler",
        step=float(step),
    )


def _assumed(span: float) -> str:
    return (
        f"m = {scenes.MASS:g} kg, no damping, no gravity. Simulated: bent by 1e-5 rad, called "
        f"unstable if the bending grows a hundred times within {span:g} s; forces halved to "
        f"{TOLERANCE:g} of the force; semi-implicit Euler steps of {SAFETY:g} of the largest "
        "stable one. The mass does not change the critical force, only how fast flutter grows."
    )
