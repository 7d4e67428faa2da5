"""A scene of the report: its reference, diagrams, orders, settings and failures."""

from __future__ import annotations

from statistics import median
from typing import Any

from rodgen.judge.found import failed_of, trusted
from rodgen.judge.precision.orders import FLOOR, Fit, looked_at
from rodgen.judge.precision.pareto import front
from rodgen.judge.rows import Contents, grouped, label, number, of, text
from rodgen.judge.unit import Row
from rodgen.view import report_figures as figures
from rodgen.view.report_columns import FAILURES, ORDERS, REFERENCE, SETTINGS, SETUP, SLOPES
from rodgen.view.report_parts import Pictures, anchor
from rodgen.view.report_tables import Column, named, table, words

TAKEN = ("setup_generate", "setup_compile")
WHY_NOT = Column("why", "why there is none", words)
WITHOUT = (
    "The scene's events take no part here: everybody integrates the whole span, as peers know "
    "nothing of them."
)
ABOVE = 10.0  # times the reference's own error, above which a slope is seen


def scene_part(contents: Contents, scene: str, pictures: Pictures, why: str) -> dict[str, Any]:
    """All of a scene for the template; its pictures are drawn. why: it is there."""
    rows = of(contents, "precision", scene=scene)
    references = of(contents, "references", scene=scene)
    slopes = _slopes(rows, trusted(contents, scene))
    adaptive = slopes["rhs"] + slopes["rtol"]
    return {
        "anchor": anchor(f"scene {scene}"),
        "title": scene,
        "why": why,
        "without": WITHOUT if any(number(row, "events") > 0 for row in references) else "",
        "links": text((references or rows)[0], "n"),
        "references": table("The reference and its own error estimate", references, REFERENCE),
        "figures": _figures(contents, scene, rows, pictures),
        "unseen": len([row for row in rows if number(row, "error_phi") > figures.LARGEST]),
        "largest": f"{figures.LARGEST:g}",
        "orders": table("Observed orders of fixed steps", slopes["step"], (*ORDERS, WHY_NOT)),
        "adaptive": table("Slopes of adaptive methods", adaptive, (*SLOPES, WHY_NOT)),
        "setup": table("Before the first step", _setup(rows), SETUP),
        "settings": table("All settings, errors and counts", named(rows), SETTINGS),
        "failures": table(
            "What failed, was stopped or not tried", failed_of(contents, scene), FAILURES
        ),
    }


def _figures(
    contents: Contents, scene: str, rows: list[Row], pictures: Pictures
) -> list[dict[str, Any]]:
    """Those that have something to show: the angles large, the other measures small."""
    shown = []
    for measure, title in figures.MEASURES.items():
        limit = trusted(contents, scene, measure)
        count = len({label(row) for row in figures.drawn(rows, measure, "seconds")})
        caption = f"Run time against the {title}"
        best = _said(rows, measure, limit)
        alt = f"{scene}: run time of {count} methods against the {title}. {best}"
        main = measure == "error_phi"
        figure = (
            figures.work_precision(rows, measure, limit)
            if main
            else figures.small(rows, measure, "seconds", limit)
        )
        name = f"{scene}-{measure.removeprefix('error_')}"
        shown.append(pictures.save(figure, name, caption, alt, large=main))
    figure = figures.small(rows, "error_phi", "rhs", trusted(contents, scene))
    caption = f"Evaluations of rhs against the {figures.MEASURES['error_phi']}"
    shown.append(pictures.save(figure, f"{scene}-evaluations", caption, f"{scene}: {caption}"))
    return [picture for picture in shown if picture]


def _said(rows: list[Row], measure: str, limit: float) -> str:
    """Whose the Pareto front is, for those who cannot see it."""
    names = dict.fromkeys(label(row) for row in front(rows, measure, limit))
    return f"On the Pareto front: {', '.join(names)}." if names else ""


def _slopes(rows: list[Row], limit: float) -> dict[str, list[Row]]:
    """Of errors against steps, evaluations and tolerances, or why there are none to be seen.

    limit: the reference's own error.
    """
    found: dict[str, list[Row]] = {"step": [], "rhs": [], "rtol": []}
    for fit in looked_at(rows, "error_phi", max(FLOOR, ABOVE * limit)):
        who: Row = {"who": fit.who, "method": fit.method, "target": fit.target}
        seen: Row = {"against": fit.against, "points": fit.points, "order": fit.nominal}
        seen["finest"] = fit.finest
        orders: Row = {"observed": None, "exponent": None}
        if isinstance(fit, Fit):
            orders = {"observed": fit.order, "exponent": fit.exponent}
        else:
            seen["why"] = fit.why
        found[fit.against].append({"label": label(who), **seen, **orders})
    return found


def _setup(rows: list[Row]) -> list[Row]:
    """Generation and compilation, medians over settings: a line for all that share them."""
    lines: list[Row] = []
    for name, some in grouped(rows, label).items():
        taken = {key: [number(row, key) for row in some if number(row, key) > 0] for key in TAKEN}
        medians: Row = {key: median(values) for key, values in taken.items() if values}
        if medians:
            lines.append({"who": some[0]["who"], "label": name, **medians})
    shared = grouped(lines, lambda row: "\0".join(text(row, key) for key in ("who", *TAKEN)))
    return [
        {**some[0], "label": ", ".join(text(row, "label") for row in some)}
        for some in shared.values()
    ]
