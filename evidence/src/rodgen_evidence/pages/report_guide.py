"""Tables of docs/speed.md, pictures and tables of docs/which-method.md, from a report.

python -m rodgen_evidence.pages.report_guide REPORT.json docs/speed.md docs/which-method.md
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import format_short, has_result, read_number, read_text
from rodgen.loading.cache import write_whole
from rodgen.progress import format_duration
from rodgen.show.precision_pictures import work_precision
from rodgen.show.style import style
from rodgen_evidence.pages import report_curves as curves
from rodgen_evidence.pages.report_matrix import legend
from rodgen_evidence.pages.report_page import read_report
from rodgen_evidence.report.contents import Contents, frame, of, reference_error
from rodgen_evidence.report.costs.against_n import fits
from rodgen_evidence.report.precision.duels import side
from rodgen_evidence.report.precision.orders import finest

LINKS = (10, 20, 50, 200, 1000)
FROM_C = "rodgen C, from C"
FORMS = {"c": "C", "numpy chain": "NumPy", "numpy dense": "NumPy, dense form"}


def rates(contents: Contents) -> list[str]:
    """Table of how many times as long rhs takes in NumPy as in C, and how all of them grow."""
    rows = [row for row in of(contents, "costs", what="rhs") if has_result(row)]
    by = {(row["who"], row["n"]): read_number(row, "seconds") for row in rows}
    found = fits(frame(rows)).set_index("who")
    body = []
    for who, shown in (
        ("rodgen NumPy", "NumPy"),
        ("rodgen NumPy, dense", "NumPy, dense form"),
        ("rodgen C", "C, from Python"),
        (FROM_C, "C, from C"),
    ):
        times = [by.get((who, n), math.nan) / by.get((FROM_C, n), math.nan) for n in LINKS]
        power = "-"
        if who in found.index:
            fit = found.loc[who]
            power = f"{fit['exponent']:.2f} ({fit['from']:g} to {fit['to']:g} links)"
        body.append([shown, *map(_times, times), power])
    head = ("time of `rhs` over that in C, from C", *(f"n={n}" for n in LINKS))
    return _table((*head, "grows with n to the power of"), body)


def orders(contents: Contents) -> list[str]:
    """Slopes of fixed steps between the two smallest of them."""
    body = []
    for method, some in curves.fixed_steps(contents).items():
        slope = finest(some)
        shown = "-" if slope is None else f"{slope:.2f}"
        body.append([f"`{method}`", f"{read_number(some[0], 'order'):g}", shown])
    return _table(("method", "order", "between its two smallest steps"), body)


def steps(contents: Contents) -> list[str]:
    """Table of the distance of largest stable steps from theory, by damping."""
    rows = frame(of(contents, "steps")).dropna(subset="off")
    body = []
    for damping, some in rows.groupby("damping", sort=False):
        worst = some.loc[some["off"].abs().idxmax()]
        where = f"`{worst['method']}`, {worst['n']:g} links"
        body.append([damping, f"{len(some)}", f"{abs(worst['off']):.1e}", where])
    return _table(("damping", "steps found", "farthest from theory", "where"), body)


def extremes(contents: Contents) -> list[str]:
    """Table of the outcomes of extreme cases."""
    rows = frame(of(contents, "extremes"))
    body = [[e["name"], f"{e['count']}", e["meaning"]] for e in legend(rows)]
    return _table((f"of {len(rows)} runs", "", "what that is"), body)


def rounding(contents: Contents) -> list[str]:
    """The largest errors of rhs by group, and where the C target has its."""
    rows = frame(filter(has_result, of(contents, "rounding")))
    body = []
    for group, some in rows.groupby("group", sort=False):
        worst = some.loc[some.groupby("form")["ulps"].idxmax()].set_index("form")
        if "c" not in worst.index:
            continue
        ours, ulps = worst.loc["c"], worst["ulps"].reindex(list(FORMS))
        cells = ["-" if math.isnan(error) else format_short(error, ".2g") for error in ulps]
        where = f"{ours['case']} ({ours['kind']}, {ours['n']:g} links)"
        body.append([group, *cells, where, format_short(ours["ulps_input"], ".2g")])
    head = ("units in the last place", *FORMS.values(), "where the C target has it")
    return _table((*head, "unavoidable there"), body)


def _times(value: float) -> str:
    return format_short(value, ".3g" if value >= 10 else ".2g") if math.isfinite(value) else "-"


def _table(head: Sequence[str], body: Iterable[Sequence[str]]) -> list[str]:
    """Lines of Markdown; rows that have nothing are left out."""
    rows = [row for row in body if set(row[1:]) != {"-"}]
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]


ASKED = 1e-6  # rad
SIZES = (20, 50, 200, 1000)
EVALUATIONS = {
    "rodgen C": "C, from Python, with an `out` array",
    FROM_C: "C, from C",
    "rodgen C, of a batch": "C, `rhs_batch`, one state of many",
    "rodgen NumPy": "NumPy",
    "rodgen NumPy, dense": "NumPy, dense form",
}
SHOWN = {"CasADi, generated C": "CasADi, generated C, from C"}
WHOLE = (
    ("jacobian", "rodgen C", "exact Jacobian, C"),
    ("implicit step", "rodgen C, gauss", "a step of `gauss`"),
    ("job: 1000 steps of rk4", "rodgen C", "1000 steps of `rk4`"),
    ("critical force", "rodgen", "critical force"),
    ("ten natural modes", "rodgen", "ten natural modes"),
)


def speed(contents: Contents) -> list[str]:
    """Whole integrations at equal error, and costs against n."""
    duels = [row for row in of(contents, "equal_error", asked=ASKED) if has_result(row)]
    costs = [row for row in of(contents, "costs") if has_result(row)]
    by = {(row["what"], row["who"], row["n"]): read_number(row, "seconds") for row in costs}
    peers = sorted(
        {read_text(row, "who") for row in costs if not read_text(row, "who").startswith("rodgen")}
    )
    evaluations = EVALUATIONS | {who: SHOWN.get(who, who) for who in peers}

    def line(what: str, who: str, shown: str) -> list[str]:
        return [shown, *(format_duration(by.get((what, who, n), math.nan)) for n in SIZES)]

    ours, theirs = ("rodgen", "rhs", "time"), ("fastest of the peers", "rhs", "time")
    runs, links = of(contents, "precision"), [f"n={n}" for n in SIZES]
    return [
        *_table(("scene", "n", *ours, *theirs, "times faster"), [_duel(r, runs) for r in duels]),
        "",
        *_table(
            ("one evaluation of `rhs`", *links),
            [line("rhs", who, shown) for who, shown in evaluations.items()],
        ),
        "",
        *_table(("what else", *links), [line(*which) for which in WHOLE]),
    ]


def _duel(row: Measurement, runs: Sequence[Measurement]) -> list[str]:
    cells = [f"`{read_text(row, 'scene')}`", read_text(row, "n")]
    for who in ("ours", "theirs"):
        seconds = format_duration(read_number(row, f"{who}_seconds"))
        cells += [read_text(row, who), _evaluations(row, who, runs), seconds]
    return [*cells, f"{read_number(row, 'ratio'):.2g}"]


def _evaluations(row: Measurement, who: str, runs: Sequence[Measurement]) -> str:
    """Number of evaluations of rhs by one side of a duel, from its run in the section precision."""
    counts = (
        run.get("nfev")
        for run in runs
        if run["scene"] == row["scene"]
        and run.get("setting") is not None
        and side(run, with_who=who == "theirs") == row[who]
    )
    return next((f"{count}" for count in counts if count is not None), "-")


Tables = Mapping[str, Callable[[Contents], list[str]]]
TABLES: Tables = {
    "rates": rates,
    "orders": orders,
    "steps": steps,
    "extremes": extremes,
    "rounding": rounding,
}


def renew_guide(guide: str, contents: Contents) -> str:
    """Renew the tables of the guide. Raises ValueError where marks are missing."""
    return _renew(guide, contents, TABLES)


def renew_speed(page: str, contents: Contents) -> str:
    """Renew the tables of the page of speeds. Raises ValueError where marks are missing."""
    return _renew(page, contents, {"speed": speed})


def _renew(page: str, contents: Contents, tables: Tables) -> str:
    for name, made in tables.items():
        begin, end = f"<!-- {name}: from report/report.json -->", f"<!-- /{name} -->"
        start, rest = page.split(begin)
        _, after = rest.split(end)
        page = "\n\n".join((f"{start}{begin}", "\n".join(made(contents)), f"{end}{after}"))
    return page


def _of_scene(name: str) -> Callable[[Contents], Figure | None]:
    """Run time against the error of a scene's angles."""
    return lambda contents: work_precision(
        of(contents, "precision", scene=name), "error_phi", reference_error(contents, name)
    )


def _costs(what: str) -> Callable[[Contents], Figure | None]:
    return lambda contents: curves.against_n(frame(of(contents, "costs", what=what)))


PICTURES: dict[str, Callable[[Contents], Figure | None]] = {
    "below_flutter": _of_scene("below_flutter"),
    "damped": _of_scene("damped_n200"),
    "missile": _of_scene("missile"),
    "orders": curves.orders,
    "growth": lambda contents: curves.growth(of(contents, "growth", scene="falling_chain")),
    "steps": lambda contents: curves.largest_steps(
        frame(of(contents, "steps", damping="none") or of(contents, "steps"))
    ),
    "rhs": _costs("rhs"),
    "implicit_step": _costs("implicit step"),
    "extremes": lambda contents: curves.extremes(frame(of(contents, "extremes"))),
}


def save_guide_figures(report_json: Path, folder: Path) -> list[Path]:
    """Write which_*.svg into a folder that exists, of what the report has; returns the files."""
    contents, _ = read_report(report_json)
    files = []
    with rc_context(style | {"svg.hashsalt": "rodgen"}):
        for name, draw in PICTURES.items():
            if figure := draw(contents):
                files.append(folder / f"which_{name}.svg")
                figure.savefig(files[-1], metadata={"Date": None})
    return files


if __name__ == "__main__":
    report, speeds, guide = map(Path, sys.argv[1:])
    contents, _ = read_report(report)
    for page, renewed in ((speeds, renew_speed), (guide, renew_guide)):
        write_whole(page, renewed(page.read_text(encoding="utf-8"), contents))
    for file in save_guide_figures(report, guide.parent / "pictures"):
        print(file)
