"""The tables of docs/which-method.md, from a report: what it holds between its marks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

from rodgen.judge.costs.against_n import fits
from rodgen.judge.found import FORMS, fixed_steps_of
from rodgen.judge.precision.orders import finest
from rodgen.judge.rows import Contents, fine, grouped, number, of, short, text
from rodgen.judge.unit import Row
from rodgen.view.report_matrix import legend

LINKS = (10, 20, 50, 200, 1000)
FROM_PYTHON, FROM_C, NUMPY, DENSE = (
    *("rodgen C", "rodgen C, from C", "rodgen NumPy", "rodgen NumPy, dense"),
)


def rates(contents: Contents) -> list[str]:
    """How many times as long rhs takes in NumPy as in C, and how all of them grow."""
    rows = [row for row in of(contents, "costs", what="rhs") if fine(row)]
    by = {(text(row, "who"), row.get("n")): number(row, "seconds") for row in rows}
    found = {text(fit, "who"): fit for fit in fits(rows)}
    body = []
    for who, shown in (
        (NUMPY, "NumPy"),
        (DENSE, "NumPy, dense form"),
        (FROM_PYTHON, "C, from Python"),
        (FROM_C, "C, from C"),
    ):
        times = [by.get((who, n), math.nan) / by.get((FROM_C, n), math.nan) for n in LINKS]
        fit = found.get(who, {})
        body.append([shown, *map(_times, times), _exponent(fit) if fit else "-"])
    head = ("time of `rhs` over that in C, from C", *(f"n={n}" for n in LINKS))
    return _table((*head, "grows with n to the power of"), body)


def orders(contents: Contents) -> list[str]:
    """Slopes of fixed steps between the two smallest of them."""
    body = []
    for method, some in fixed_steps_of(contents).items():
        slope = finest(some, "error_phi")
        shown = "-" if slope is None else f"{slope:.2f}"
        body.append([f"`{method}`", f"{number(some[0], 'order'):g}", shown])
    return _table(("method", "order", "between its two smallest steps"), body)


def steps(contents: Contents) -> list[str]:
    """How far largest stable steps are from theory, by damping."""
    rows = [row for row in of(contents, "steps") if math.isfinite(number(row, "off"))]
    body = []
    for damping, some in grouped(rows, lambda row: text(row, "damping")).items():
        worst = max(some, key=lambda row: abs(number(row, "off")))
        where = f"`{text(worst, 'method')}`, {text(worst, 'n')} links"
        body.append([damping, f"{len(some)}", f"{abs(number(worst, 'off')):.1e}", where])
    return _table(("damping", "steps found", "farthest from theory", "where"), body)


def extremes(contents: Contents) -> list[str]:
    """How many runs of extreme cases came to what."""
    rows = of(contents, "extremes")
    body = [[e["name"], f"{e['count']}", e["meaning"]] for e in legend(rows)]
    return _table((f"of {len(rows)} runs", "", "what that is"), body)


def rounding(contents: Contents) -> list[str]:
    """The largest errors of rhs by group, and where the C target has its."""
    rows = [row for row in of(contents, "rounding") if fine(row)]
    body = []
    for group, some in grouped(rows, lambda row: text(row, "group")).items():
        worst = {form: _worst(r for r in some if r.get("form") == form) for form in FORMS}
        ours = worst["c"]
        if ours is None:
            continue
        cells = ["-" if r is None else short(number(r, "ulps"), ".2g") for r in worst.values()]
        where = f"{text(ours, 'case')} ({text(ours, 'kind')}, {text(ours, 'n')} links)"
        body.append([group, *cells, where, short(number(ours, "ulps_input"), ".2g")])
    head = ("units in the last place", *FORMS.values(), "where the C target has it")
    return _table((*head, "unavoidable there"), body)


def _worst(rows: Iterable[Row]) -> Row | None:
    return max(rows, key=lambda row: number(row, "ulps"), default=None)


def _exponent(fit: Row) -> str:
    first, last = number(fit, "from"), number(fit, "to")
    return f"{number(fit, 'exponent'):.2f} ({first:g} to {last:g} links)"


def _times(value: float) -> str:
    return short(value, ".3g" if value >= 10 else ".2g") if math.isfinite(value) else "-"


def _table(head: Sequence[str], body: Iterable[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *body)]


TABLES: dict[str, Callable[[Contents], list[str]]] = {
    "rates": rates,
    "orders": orders,
    "steps": steps,
    "extremes": extremes,
    "rounding": rounding,
}


def renewed(guide: str, contents: Contents) -> str:
    """The guide with its tables made anew. Raises ValueError where marks are missing."""
    for name, made in TABLES.items():
        begin, end = f"<!-- {name}: from report/report.json -->", f"<!-- /{name} -->"
        start, rest = guide.split(begin)
        _, after = rest.split(end)
        lines = "\n".join(made(contents))
        guide = f"{start}{begin}\n\n{lines}\n\n{end}{after}"
    return guide
