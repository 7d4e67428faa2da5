"""Pictures and tables of docs/which-method.md, from a report that was written.

python -m rodgen.view.report_guide results/report/report.json docs/pictures
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from rodgen.judge.found import fixed_steps_of, trusted
from rodgen.judge.precision.orders import finest
from rodgen.judge.rows import Contents, label, number, of, text
from rodgen.judge.unit import Row
from rodgen.loading.cache import write_whole
from rodgen.view import report_curves as curves
from rodgen.view.report_figures import work_precision
from rodgen.view.report_numbers import renewed
from rodgen.view.report_page import read_report
from rodgen.view.report_style import INK, axes, legend, logarithmic, look

GUIDE = "which-method.md"  # beside the folder of its pictures
MIDDLE: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7, "color": INK}
# What a group of extreme cases came to with a method, from its worst outcome on.
COLOURS = {
    "wrong": "#f4a9a3",
    "unseen": "#f7c8d8",
    "lost": "#fadcbc",
    "warned": "#fbeebb",
    "unfinished": "#e2e2e2",
    "refused": "#e6def6",
    "stopped": "#d3e4f8",
    "right": "#d0ecd5",
}


def save_guide_figures(report_json: Path, folder: Path) -> list[Path]:
    """Write which_*.svg into a folder that exists, of what the report has; returns the files."""
    contents, _ = read_report(report_json)
    files = []
    for name, draw in PICTURES.items():
        figure = draw(contents)
        if figure is None:
            continue
        files.append(folder / f"which_{name}.svg")
        with rc_context({"svg.hashsalt": "rodgen"}):
            figure.savefig(files[-1], metadata={"Date": None})
    return files


def scene(name: str) -> Callable[[Contents], Figure | None]:
    """Run time against the error of a scene's angles."""

    def draw(contents: Contents) -> Figure | None:
        rows = of(contents, "precision", scene=name)
        return work_precision(rows, "error_phi", trusted(contents, name))

    return draw


def orders(contents: Contents) -> Figure | None:
    """Errors of fixed steps against the step, with the slopes between the two smallest."""
    by_method = fixed_steps_of(contents)
    if not by_method:
        return None
    figure, frame = axes(5.6, 4.0, "step [s]", "error of the angles at the end [rad]")
    frame.set(xscale="log", yscale="log")
    for method, some in by_method.items():
        shown = sorted((number(r, "setting"), number(r, "error_phi")) for r in some)
        shown = [(step, error) for step, error in shown if 0 < error < 10]
        slope, found = finest(some, "error_phi"), method
        if slope is not None:
            order = number(some[0], "order")
            found = f"{method}: slope of the last two {slope:.2f} (order {order:g})"
        steps, errors = zip(*shown, strict=True) if shown else ((), ())
        frame.plot(steps, errors, label=found, **look(some[0]).line)
    logarithmic(frame)
    return legend(figure, 1)


def costs(what: str) -> Callable[[Contents], Figure | None]:
    """Seconds against the number of links."""
    return lambda contents: curves.against_n(of(contents, "costs", what=what))


def growth(contents: Contents) -> Figure | None:
    """Errors of a chaotic motion in time."""
    return curves.growth(of(contents, "growth", scene="falling_chain"))


def steps(contents: Contents) -> Figure | None:
    """Largest stable steps without damping."""
    rows = of(contents, "steps", damping="none")
    return curves.largest_steps(rows or of(contents, "steps"))


def extremes(contents: Contents) -> Figure | None:
    """By group and method: how many cases are right, coloured by the worst outcome."""
    # What cannot be computed at all is no matter of methods.
    rows = [row for row in of(contents, "extremes") if row.get("outcome")]
    rows = [row for row in rows if _group(row) != "invalid"]
    groups, methods = (list(dict.fromkeys(map(name, rows))) for name in (_group, label))
    if not rows:
        return None
    figure, frame = axes(1.9 + 0.62 * len(methods), 1.6 + 0.27 * len(groups), "", "")
    frame.grid(visible=False)
    for at, group in enumerate(groups):
        for across, method in enumerate(methods):
            some = [r for r in rows if _group(r) == group and label(r) == method]
            if some:
                colour, words = _cell(some)
                frame.fill_between([across, across + 1], at, at + 1, color=colour, ec="white")
                frame.text(across + 0.5, at + 0.5, words, **MIDDLE)
    frame.set(xlim=(0, len(methods)), ylim=(len(groups), 0))
    places = [at + 0.5 for at in range(len(methods))]
    frame.set_xticks(places, methods, rotation=40, ha="left", fontsize=7)
    frame.xaxis.tick_top()
    frame.set_yticks([at + 0.5 for at in range(len(groups))], groups, fontsize=7)
    frame.tick_params(length=0)
    for name, colour in COLOURS.items():
        frame.fill_between([], [], [], color=colour, label=name)
    return legend(figure, 6)


def _group(row: Row) -> str:
    return text(row, "group")


def _cell(rows: Sequence[Row]) -> tuple[str, str]:
    """Colour of the worst, and how many are right of how many."""
    found = {text(row, "outcome") for row in rows}
    worst = next((name for name in COLOURS if name in found), "warned")
    right = sum(row.get("outcome") == "right" for row in rows)
    return COLOURS[worst], f"{right}/{len(rows)}"


PICTURES: dict[str, Callable[[Contents], Figure | None]] = {
    "below_flutter": scene("below_flutter"),
    "damped": scene("damped_n200"),
    "missile": scene("missile"),
    "orders": orders,
    "growth": growth,
    "steps": steps,
    "rhs": costs("rhs"),
    "implicit_step": costs("implicit step"),
    "extremes": extremes,
}

if __name__ == "__main__":
    report, pictures = map(Path, sys.argv[1:])
    for file in save_guide_figures(report, pictures):
        print(file)
    guide = pictures.parent / GUIDE
    contents, _ = read_report(report)
    write_whole(guide, renewed(guide.read_text(encoding="utf-8"), contents))
    print(guide)
