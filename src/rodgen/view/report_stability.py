"""The report's parts on stability, extreme cases and rounding."""

from __future__ import annotations

from rodgen.judge.found import case_named, far_from_theory, unseen
from rodgen.judge.rows import Contents, fine, grouped, number, of, text
from rodgen.view import report_columns as columns
from rodgen.view import report_curves as curves
from rodgen.view import report_matrix as matrix
from rodgen.view.report_parts import Part, Pictures, part
from rodgen.view.report_tables import table

WRONG = (
    "Wrong is a method with error control that is beyond its tolerance, while the run's own energy "
    "balance shows less than a tenth of the error; and a fixed step of which a smaller one is no "
    "better. A fixed step that is merely too large has no error estimate that could tell it: "
    "where the balance does not either, its error is unseen."
)
UNSEEN = "Errors of fixed steps that nothing tells"


def steps(contents: Contents, pictures: Pictures) -> Part | None:
    rows = of(contents, "steps")
    if not rows:
        return None
    about = "Dots: found by bisection. Lines: theory, the method's stability region and the rate."
    drawn = [
        pictures.save(
            curves.largest_steps(some), f"steps-{name}", f"Largest stable steps, damping: {name}"
        )
        for name, some in grouped(rows, lambda row: text(row, "damping")).items()
    ]
    far = far_from_theory(contents)
    shown = [table("Off theory", far, columns.STEPS)] if far else []
    folded = [table("All largest stable steps", rows, columns.STEPS)]
    return part("Largest stable steps", [about], figures=drawn, tables=shown, folded=folded)


def extremes(contents: Contents) -> Part | None:
    rows = of(contents, "extremes")
    if not rows:
        return None
    said = [
        f"{case_named(row)}: {text(row, 'outcome')}. {text(row, 'said')}"
        for row in rows
        if text(row, "said") and text(row, "outcome") != "right"
    ]
    return part(
        "Extreme cases",
        ["What each method made of a case; a pointer on a cell shows the message.", WRONG],
        legend=matrix.legend(rows),
        tables=[*matrix.outcomes(rows), table(UNSEEN, unseen(rows), columns.UNSEEN)],
        said=said,
    )


def rounding(contents: Contents) -> Part | None:
    rows = of(contents, "rounding")
    if not rows:
        return None
    steps_of = ", ".join(f"{bound:g}" for bound in matrix.BOUNDS)
    about = (
        "Against arithmetic of 50 digits or more, in units of the last place of the largest entry; "
        "the largest over kinds of rods and numbers of links, which a pointer on a cell shows. "
        "Unavoidable: what such a change of state and parameters makes. Condition: of the linear "
        f"system. Colours change at {steps_of} times the unavoidable error. Marked with !: digits "
        "are lost that another form keeps."
    )
    worst = max((number(row, "ulps") for row in rows if fine(row)), default=0.0)
    texts = [about, f"The largest error of all: {worst:.3g} units."]
    folded = [table("All of it", rows, columns.ROUNDING)]
    return part("Rounding of rhs", texts, tables=[matrix.rounding(rows)], folded=folded)
