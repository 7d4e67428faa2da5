"""The report's parts that are not about one scene."""

from __future__ import annotations

from rodgen.judge.costs.against_n import fits
from rodgen.judge.found import PARTS, RUNS, savings
from rodgen.judge.rows import Contents, grouped, of, text
from rodgen.judge.summary import growths
from rodgen.judge.unit import Row
from rodgen.view import report_columns as columns
from rodgen.view import report_curves as curves
from rodgen.view.report_parts import Part, Pictures, part
from rodgen.view.report_stability import extremes, rounding, steps
from rodgen.view.report_tables import named, table

DUELS = "Ours against theirs, each at its cheapest setting within the error, run in turns."
FAIRNESS = (
    "Everybody gives the states at a hundred times. SciPy and CVODE have no equations of their own "
    "and are given ours, compiled. heyoka is compiled in its compact mode, in seconds; unrolled it "
    "runs 2 to 2.5 times as fast and compiles for 20 s (20 links) to minutes (50). CasADi "
    "interprets its expressions; compiled they run some 2 to 3 times as fast, after 7 s (20 links) "
    "to 150 s (50). MuJoCo and Exudyn are called back by Python where a load changes with time."
)


def parts(contents: Contents, pictures: Pictures) -> list[Part]:
    """Those of which anything was measured."""
    made = (
        _equal_error(contents),
        _growth(contents, pictures),
        _costs(contents, pictures),
        _leaving_out(contents, pictures),
        _install(contents),
        steps(contents, pictures),
        extremes(contents),
        rounding(contents),
    )
    return [one for one in made if one]


def _equal_error(contents: Contents) -> Part | None:
    rows = of(contents, "equal_error")
    shown = [table("Duels", rows, columns.DUELS)]
    return part("Equal error", [DUELS, FAIRNESS], tables=shown) if rows else None


def _growth(contents: Contents, pictures: Pictures) -> Part | None:
    rows = of(contents, "growth")
    if not rows:
        return None
    drawn = [
        pictures.save(curves.growth(some), f"growth-{scene}", f"{scene}: errors in time")
        for scene, some in grouped(rows, lambda row: text(row, "scene")).items()
    ]
    shown = [table("Fitted rates", named(rows), columns.GROWTH)]
    return part("How errors grow in time", growths(contents), figures=drawn, tables=shown)


def _costs(contents: Contents, pictures: Pictures) -> Part | None:
    rows = of(contents, "costs")
    if not rows:
        return None
    about = (
        "An exponent is the slope in a picture: 1 where the cost grows as the links do. Calls from "
        "Python cost half a microsecond and more by themselves: what is called from C is said so."
    )
    drawn = [
        pictures.save(curves.against_n(some), f"costs-{what}", f"{what}: time against links")
        for what, some in grouped(rows, lambda row: text(row, "what")).items()
    ]
    shown = [table("Fitted exponents", fits(rows), columns.FITS)]
    folded = [table("All measured costs", rows, columns.COSTS)]
    return part("Costs against n", [about], figures=drawn, tables=shown, folded=folded)


def _leaving_out(contents: Contents, pictures: Pictures) -> Part | None:
    rows = of(contents, "leaving_out")
    if not rows:
        return None
    about = (
        "A module holds what its scene needs. Beside it one with every term, at zero "
        "coefficients: how many times as much that costs."
    )
    drawn = pictures.save(curves.saved(rows), "leaving-out", "What every term at zero costs")
    ratios: list[Row] = [
        {"scene": scene, **{key: row.get(key) for key in (*PARTS, *RUNS)}}
        for scene, row in savings(rows).items()
    ]
    shown = [table("Every term at zero, over the scene's own", ratios, columns.SAVINGS)]
    folded = [table("What was measured", rows, columns.LEFT_OUT)]
    return part("What leaving out saves", [about], figures=[drawn], tables=shown, folded=folded)


def _install(contents: Contents) -> Part | None:
    rows = of(contents, "install")
    shown = [table("Import and install", rows, columns.INSTALL)]
    return part("Import time and sizes", [], tables=shown) if rows else None
