"""Parts of the report: one of every scene, and those that are not about one scene."""

from __future__ import annotations

from typing import Any

from pandas import DataFrame

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import format_label, pareto_front
from rodgen.show import precision_pictures as figures
from rodgen_evidence.page_tables import table
from rodgen_evidence.pages import report_curves as curves
from rodgen_evidence.pages import report_matrix as matrix
from rodgen_evidence.pages import report_tables as columns
from rodgen_evidence.pages.folder import Part, Pictures, anchor, part
from rodgen_evidence.pages.report_tables import CUT, add_names
from rodgen_evidence.report.contents import (
    Contents,
    case_name,
    failed_of,
    frame,
    of,
    records,
    reference_error,
)
from rodgen_evidence.report.costs.against_n import fits
from rodgen_evidence.report.costs.leaving_out import savings
from rodgen_evidence.report.precision.orders import FLOOR, looked_at
from rodgen_evidence.report.report_summary import growths
from rodgen_evidence.report.stability.steps import off_theory

TAKEN = ["setup_generate", "setup_compile"]
WITHOUT = (
    "The scene's events take no part here: everybody integrates the whole span, as peers know "
    "nothing of them."
)
ABOVE = 10.0  # times the reference's own error, above which a slope is seen


def scene_part(contents: Contents, scene: str, pictures: Pictures, why: str) -> dict[str, Any]:
    """All of a scene for the template; its pictures are drawn. why: it is there."""
    rows = of(contents, "precision", scene=scene)
    references = of(contents, "references", scene=scene)
    fixed, adaptive = _slopes(rows, reference_error(contents, scene))
    every = frame(rows)
    links = (references or rows)[0].get("n")
    return {
        "anchor": anchor(f"scene {scene}"),
        "title": scene,
        "why": why,
        "without": WITHOUT if (frame(references)["events"] > 0).any() else "",
        "links": "" if links is None else links,
        "references": table(
            "The reference and its own error estimate", references, columns.REFERENCE
        ),
        "figures": _figures(contents, scene, rows, pictures),
        "unseen": int((every["error_phi"] > figures.LARGEST_ERROR).sum()),
        "largest": f"{figures.LARGEST_ERROR:g}",
        "orders": table("Observed orders of fixed steps", add_names(fixed), columns.ORDERS),
        "adaptive": table("Slopes of adaptive methods", add_names(adaptive), columns.SLOPES),
        "setup": table("Before the first step", _setup(every), columns.SETUP),
        "settings": table("All settings, errors and counts", add_names(rows), columns.SETTINGS),
        "failures": table(CUT, records(failed_of(contents, scene)), columns.FAILURES),
    }


def _figures(
    contents: Contents, scene: str, rows: list[Measurement], pictures: Pictures
) -> list[dict[str, Any]]:
    """Work-precision diagrams of a scene: the angles large, the other measures small."""
    shown = []
    for measure, title in figures.MEASURES.items():
        limit = reference_error(contents, scene, measure)
        count = len({format_label(row) for row in figures.drawable_rows(rows, measure, "seconds")})
        caption = f"Run time against the {title}"
        best = _said(rows, measure, limit)
        alt = f"{scene}: run time of {count} methods against the {title}. {best}"
        main = measure == "error_phi"
        figure = (
            figures.work_precision(rows, measure, limit)
            if main
            else curves.small_diagram(rows, measure, "seconds", limit)
        )
        name = f"{scene}-{measure.removeprefix('error_')}"
        shown.append(pictures.save(figure, name, caption, alt, large=main))
    figure = curves.small_diagram(rows, "error_phi", "nfev", reference_error(contents, scene))
    caption = f"Evaluations of rhs against the {figures.MEASURES['error_phi']}"
    shown.append(pictures.save(figure, f"{scene}-evaluations", caption, f"{scene}: {caption}"))
    return [picture for picture in shown if picture]


def _said(rows: list[Measurement], measure: str, limit: float) -> str:
    """Name the methods on the Pareto front, for readers who cannot see it."""
    names = dict.fromkeys(format_label(row) for row in pareto_front(rows, measure, limit))
    return f"On the Pareto front: {', '.join(names)}." if names else ""


def _slopes(rows: list[Measurement], limit: float) -> tuple[list[Measurement], list[Measurement]]:
    """Slopes of errors against steps; against evaluations, then tolerances; or why there is none.

    limit: the reference's own error.
    """
    fits = list(looked_at(rows, max(FLOOR, ABOVE * limit)))
    steps, by_rhs, by_rtol = (
        [fit for fit in fits if fit["against"] == what] for what in ("step", "rhs", "rtol")
    )
    return steps, [*by_rhs, *by_rtol]


def _setup(rows: DataFrame) -> list[Measurement]:
    """Generation and compilation, medians over settings: a line for all that share them."""
    taken = rows.reindex(columns=["who", "label", *TAKEN])
    taken[TAKEN] = taken[TAKEN].astype(float).where(lambda seconds: seconds > 0)
    medians = taken.groupby(["who", "label"], sort=False).median().dropna(how="all").reset_index()
    shared = medians.groupby(["who", *TAKEN], sort=False, dropna=False)["label"]
    return records(shared.agg(", ".join).reset_index())


# Sections ----------------------------------------------------------------------------------------

WRONG = (
    "Wrong is a method with error control that is beyond its tolerance, while the run's own energy "
    "balance shows less than a tenth of the error; and a fixed step of which a smaller one is no "
    "better. A fixed step that is merely too large has no error estimate that could tell it: "
    "where the balance does not either, its error is unseen."
)
UNSEEN = "Errors of fixed steps that nothing tells"
DUELS = "Ours against theirs, each at its cheapest setting within the error, run in turns."
FAIRNESS = (
    "Everybody gives the states at a hundred times. SciPy and CVODE have no equations of their own "
    "and are given ours, compiled. heyoka is compiled in its compact mode, in seconds; unrolled it "
    "runs 2 to 2.5 times as fast and compiles for 20 s (20 links) to minutes (50). CasADi "
    "interprets its expressions; compiled they run some 2 to 3 times as fast, after 7 s (20 links) "
    "to 150 s (50). MuJoCo and Exudyn are called back by Python where a load changes with time."
)


def parts(contents: Contents, pictures: Pictures) -> list[Part]:
    """Sections of the page of which anything was measured."""
    made = {
        "equal_error": _equal_error,
        "growth": _growth,
        "costs": _costs,
        "leaving_out": _leaving_out,
        "install": _install,
        "steps": _steps,
        "extremes": _extremes,
        "rounding": _rounding,
    }
    return [make(contents, pictures) for name, make in made.items() if of(contents, name)]


def _equal_error(contents: Contents, _: Pictures) -> Part:
    shown = [table("Duels", of(contents, "equal_error"), columns.DUELS)]
    return part("Equal error", [DUELS, FAIRNESS], tables=shown)


def _growth(contents: Contents, pictures: Pictures) -> Part:
    rows = of(contents, "growth")
    drawn = [
        pictures.save(
            curves.growth(of(contents, "growth", scene=scene)),
            f"growth-{scene}",
            f"{scene}: errors in time",
        )
        for scene in frame(rows)["scene"].unique()
    ]
    shown = [table("Fitted rates", add_names(rows), columns.GROWTH)]
    return part("How errors grow in time", growths(contents), figures=drawn, tables=shown)


def _costs(contents: Contents, pictures: Pictures) -> Part:
    rows = of(contents, "costs")
    about = (
        "An exponent is the slope in a picture: 1 where the cost grows as the links do. Calls from "
        "Python cost half a microsecond and more by themselves: what is called from C is said so."
    )
    drawn = [
        pictures.save(curves.against_n(some), f"costs-{what}", f"{what}: time against links")
        for what, some in frame(rows).groupby("what", sort=False)
    ]
    shown = [table("Fitted exponents", records(fits(frame(rows))), columns.FITS)]
    folded = [table("All measured costs", rows, columns.COSTS)]
    return part("Costs against n", [about], figures=drawn, tables=shown, folded=folded)


def _leaving_out(contents: Contents, pictures: Pictures) -> Part:
    rows = of(contents, "leaving_out")
    about = (
        "A module holds what its scene needs. Beside it one with every term, at zero "
        "coefficients: how many times as much that costs."
    )
    ratios = savings(frame(rows))
    drawn = pictures.save(curves.savings(ratios), "leaving-out", "What every term at zero costs")
    shown = records(ratios.reset_index())
    return part(
        *("What leaving out saves", [about]),
        figures=[drawn],
        tables=[table("Every term at zero, over the scene's own", shown, columns.SAVINGS)],
        folded=[table("What was measured", rows, columns.LEFT_OUT)],
    )


def _install(contents: Contents, _: Pictures) -> Part:
    shown = [table("Import and install", of(contents, "install"), columns.INSTALL)]
    return part("Import time and sizes", [], tables=shown)


def _steps(contents: Contents, pictures: Pictures) -> Part:
    rows = frame(of(contents, "steps"))
    about = "Dots: found by bisection. Lines: theory, the method's stability region and the rate."
    drawn = [
        pictures.save(
            curves.largest_steps(some), f"steps-{name}", f"Largest stable steps, damping: {name}"
        )
        for name, some in rows.groupby("damping", sort=False)
    ]
    far = off_theory(rows)
    shown = [table("Off theory", records(far), columns.STEPS)] if len(far) else []
    folded = [table("All largest stable steps", records(rows), columns.STEPS)]
    return part("Largest stable steps", [about], figures=drawn, tables=shown, folded=folded)


def _extremes(contents: Contents, _: Pictures) -> Part:
    rows = frame(of(contents, "extremes"))
    unseen = records(rows[rows["outcome"] == "unseen"])
    told = rows[(rows["said"] != "") & (rows["outcome"] != "right")]
    return part(
        "Extreme cases",
        ["What each method made of a case; a pointer on a cell shows the message.", WRONG],
        legend=matrix.legend(rows),
        tables=[*matrix.outcomes(rows), table(UNSEEN, unseen, columns.UNSEEN)],
        said=[f"{case_name(r)}: {r['outcome']}. {r['said']}" for r in records(told)],
    )


def _rounding(contents: Contents, _: Pictures) -> Part:
    rows = frame(of(contents, "rounding"))
    steps_of = ", ".join(f"{bound:g}" for bound in matrix.BOUNDS)
    about = (
        "Against arithmetic of 50 digits or more, in units of the last place of the largest entry; "
        "the largest over kinds of rods and numbers of links, which a pointer on a cell shows. "
        "Unavoidable: what such a change of state and parameters makes. Condition: of the linear "
        f"system. Colours change at {steps_of} times the unavoidable error. Marked with !: digits "
        "are lost that another form keeps."
    )
    worst = rows["ulps"].where(rows["failed"] == "", 0.0).max()
    texts = [about, f"The largest error of all: {worst:.3g} units."]
    folded = [table("All of it", records(rows), columns.ROUNDING)]
    return part("Rounding of rhs", texts, tables=[matrix.rounding(rows)], folded=folded)
