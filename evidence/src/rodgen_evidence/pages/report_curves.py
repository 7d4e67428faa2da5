"""Pictures of the report and of docs/which-method.md beside the large work-precision diagrams."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from pandas import DataFrame

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import format_label, format_setting, has_result, read_number
from rodgen.show.canvas import INK, SERIES, add_legend, figure_without_window
from rodgen.show.precision_pictures import (
    MEASURES,
    OURS,
    draw_front,
    draw_lines,
    drawable_rows,
    label_logarithmic,
    line_style,
    make_diagram,
    own_style,
    style_frame,
)
from rodgen_evidence.report.contents import Contents, of
from rodgen_evidence.report.precision.growth import curve, growth_line
from rodgen_evidence.report.precision.orders import finest

WIDTH, HEIGHT = 4.6, 3.5
SMALL = 4.1, 3.0  # inches: of a diagram without names
LEFT, BELOW = 0.68, 0.48  # inches beside and below it, for its numbers and labels
SAVED = {
    "operations": "operations",
    "object_bytes": "bytes of object code",
    "compile": "compile time",
    "rhs": "time of rhs",
    "run": "run time, rk4",
    "run_dop853": "run time, dop853",
}
OF_RODGEN = SERIES[1]  # in C; its other targets and forms have colours of their own
# "from" C; of a "batch".
OF_FORM = {
    "from": (SERIES[5], "s"),
    "batch": (SERIES[2], "D"),
    "dense": (SERIES[4], "^"),
    "numpy": (SERIES[0], "v"),
}
LINES = ("-", (0, (5, 1.5)), (0, (1.5, 1.5)))
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
ORDERS_OF = "free_n20"  # the scene on which orders are looked at


def small_diagram(
    rows: Sequence[Measurement], measure: str, cost: str, trusted: float
) -> Figure | None:
    """Small work-precision diagram without names. cost: "seconds", or "nfev" for evaluations."""
    if not drawable_rows(rows, measure, cost):
        return None
    # Its place need not be looked for, as there is nothing outside: that takes half of the time.
    (width, height), figure = SMALL, figure_without_window(figsize=SMALL)
    place = LEFT / width, BELOW / height, 1 - (LEFT + 0.1) / width, 1 - (BELOW + 0.1) / height
    frame = figure.add_axes(place)
    title = "run time [s]" if cost == "seconds" else "evaluations of rhs"
    style_frame(frame, MEASURES[measure], title)
    draw_lines(frame, rows, measure, cost, trusted)
    if cost == "seconds":
        draw_front(frame, rows, measure, trusted)
    return figure


def growth(rows: Sequence[Measurement]) -> Figure | None:
    """Draw the growth of errors in time, with the exponential fitted to them."""
    shown = [row for row in rows if has_result(row) and len(curve(row, "t"))]
    if not shown:
        return None
    figure, frame = make_diagram(WIDTH, HEIGHT, "t [s]", "largest error of an angle [rad]")
    frame.set_yscale("log")
    for at, row in enumerate(shown):
        error = curve(row, "error")
        line = line_style(row) | {"marker": "", "linestyle": LINES[at % len(LINES)]}
        name = ", ".join(filter(None, (format_label(row), format_setting(row))))
        frame.plot(curve(row, "t"), np.where(error == 0, math.nan, error), label=name, **line)
        fitted = growth_line(row)
        if fitted:
            name = f"exp({read_number(row, 'rate'):.3g} t)"
            frame.plot(*fitted, color=INK, linewidth=0.6, zorder=4, label=name)
    label_logarithmic(frame, x=False)
    add_legend(figure)
    return figure


def against_n(rows: DataFrame) -> Figure | None:
    """Draw the time of one kind of work against the number of links."""
    shown = rows[(rows["failed"] == "") & (rows["seconds"] > 0)].sort_values("n", kind="stable")
    if shown.empty:
        return None
    figure, frame = make_diagram(4.2, 3.4, "links n", "time [s]")
    frame.set(xscale="log", yscale="log")
    for name in rows.loc[shown.index.sort_values(), "who"].unique():
        line = shown[shown["who"] == name]
        frame.plot(line["n"], line["seconds"], label=name, **_look_of_who(name))
    label_logarithmic(frame)
    add_legend(figure)
    return figure


def savings(ratios: DataFrame) -> Figure | None:
    """Draw by scene how many times as much every term at zero costs."""
    if ratios.empty:
        return None
    figure, frame = make_diagram(WIDTH, 1.1 + 0.62 * len(ratios), "times as much", "")
    thick = 0.8 / len(SAVED)
    for at, (key, name) in enumerate(SAVED.items()):
        places = np.arange(len(ratios)) + (at - (len(SAVED) - 1) / 2) * thick
        frame.barh(places, ratios[key].fillna(0.0), thick * 0.9, color=SERIES[at], label=name)
    frame.set_yticks(range(len(ratios)), list(ratios.index))
    frame.axvline(1, color=INK, linewidth=0.8)
    frame.invert_yaxis()
    frame.grid(visible=False, axis="y")
    add_legend(figure)
    return figure


def largest_steps(rows: DataFrame) -> Figure | None:
    """Largest stable steps against the number of links: found as dots, theory as lines."""
    shown = rows[(rows["failed"] == "") & (rows["found"] > 0)]
    if shown.empty:
        return None
    figure, frame = make_diagram(4.2, 3.4, "links n", "largest stable step [s]")
    frame.set(xscale="log", yscale="log")
    for name, some in shown.groupby("method", sort=False):
        line = some.sort_values("n", kind="stable")
        colour = line_style({"method": name})["color"]
        # A variant of a method lies on the method itself: a ring around the dot.
        ring = {"markerfacecolor": "none", "markersize": 8} if "," in name else {"markersize": 4.5}
        frame.plot(line["n"], line["found"], "o", color=colour, label=name, **ring)
        theory = line["theory"].replace(0.0, math.nan)
        frame.plot(line["n"], theory, "-", color=colour, linewidth=1.0, alpha=0.8)
    label_logarithmic(frame)
    add_legend(figure)
    return figure


def fixed_steps(contents: Contents) -> dict[str, list[Measurement]]:
    """Runs in C with fixed steps, by method."""
    rows = of(contents, "precision", scene=ORDERS_OF, kind="step", who="rodgen", target="c")
    by: dict[str, list[Measurement]] = {}
    for row in filter(has_result, rows):
        by.setdefault(str(row["method"]), []).append(row)
    return by


def orders(contents: Contents) -> Figure | None:
    """Errors of fixed steps against the step, with the slopes between the two smallest."""
    by_method = fixed_steps(contents)
    if not by_method:
        return None
    figure, frame = make_diagram(5.6, 4.0, "step [s]", "error of the angles at the end [rad]")
    frame.set(xscale="log", yscale="log")
    for method, some in by_method.items():
        shown = sorted((read_number(r, "setting"), read_number(r, "error_phi")) for r in some)
        shown = [(step, error) for step, error in shown if 0 < error < 10]
        slope, found = finest(some), method
        if slope is not None:
            order = read_number(some[0], "order")
            found = f"{method}: slope of the last two {slope:.2f} (order {order:g})"
        steps, errors = zip(*shown, strict=True) if shown else ((), ())
        frame.plot(steps, errors, label=found, **line_style(some[0]))
    label_logarithmic(frame)
    add_legend(figure)
    return figure


def extremes(rows: DataFrame) -> Figure | None:
    """Draw how many cases are right by group and method, coloured by the worst outcome."""
    # What cannot be computed at all is no matter of methods.
    rows = rows[(rows["outcome"] != "") & (rows["group"] != "invalid")]
    if rows.empty:
        return None
    groups, methods = (list(rows[key].unique()) for key in ("group", "label"))
    figure, frame = make_diagram(1.9 + 0.62 * len(methods), 1.6 + 0.27 * len(groups), "", "")
    frame.grid(visible=False)
    for (group, method), some in rows.groupby(["group", "label"], sort=False)["outcome"]:
        at, across = groups.index(group), methods.index(method)
        worst = next((name for name in COLOURS if (some == name).any()), "warned")
        frame.fill_between([across, across + 1], at, at + 1, color=COLOURS[worst], ec="white")
        words = f"{(some == 'right').sum()}/{len(some)}"
        frame.text(across + 0.5, at + 0.5, words, **MIDDLE)
    frame.set(xlim=(0, len(methods)), ylim=(len(groups), 0))
    places = [at + 0.5 for at in range(len(methods))]
    frame.set_xticks(places, methods, rotation=40, ha="left", fontsize=7)
    frame.xaxis.tick_top()
    frame.set_yticks([at + 0.5 for at in range(len(groups))], groups, fontsize=7)
    frame.tick_params(length=0)
    for name, colour in COLOURS.items():
        frame.fill_between([], [], [], color=colour, label=name)
    add_legend(figure)
    return figure


def _look_of_who(name: str) -> dict[str, Any]:
    """Ours in colour, by method, form or target; others as everywhere."""
    words = re.split(r"[^a-z0-9_]+", name.lower())
    if words[0] not in ("rodgen", "c", "numpy"):
        return line_style({"who": re.split(r"[ ,]", name)[0], "method": name})
    looks = {**{method: own_style(method) for method in OURS}, **OF_FORM}
    shown = [one for word, one in looks.items() if word in words]
    colour, mark = shown[0] if shown else (OF_RODGEN, "o")
    return {"color": colour, "marker": mark, "markersize": 4, "linewidth": 1.4}
