"""Pictures of the report beside its work-precision diagrams: growth, costs, savings, steps."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from rodgen.judge.found import growth_line, savings
from rodgen.judge.rows import curve, fine, grouped, number, setting, text
from rodgen.judge.unit import Row
from rodgen.view.report_style import INK, OURS, axes, legend, logarithmic, look

WIDTH, HEIGHT = 4.6, 3.5
SAVED = {
    "operations": "operations",
    "object_bytes": "bytes of object code",
    "compile": "compile time",
    "rhs": "time of rhs",
    "run": "run time, rk4",
    "run_dop853": "run time, dop853",
}
OF_RODGEN = "#d1495b"  # in C; its other targets and forms have colours of their own
# "from" C; of a "batch".
OF_FORM = {
    "from": ("#12a5b8", "s"),
    "batch": ("#1f9e62", "D"),
    "dense": ("#d9830f", "^"),
    "numpy": ("#2a78d6", "v"),
}
LINES = ("-", (0, (5, 1.5)), (0, (1.5, 1.5)))
SHADES = ("#2a78d6", "#12a5b8", "#1f9e62", "#d9830f", "#9455c8", "#d1495b")


def growth(rows: Sequence[Row]) -> Figure | None:
    """How errors grow in time, with the exponential fitted to them."""
    shown = [row for row in rows if fine(row) and curve(row, "t")]
    if not shown:
        return None
    figure, frame = axes(WIDTH, HEIGHT, "t [s]", "largest error of an angle [rad]")
    frame.set_yscale("log")
    for at, row in enumerate(shown):
        style = look(row)
        t, error = curve(row, "t"), [value or math.nan for value in curve(row, "error")]
        line = style.line | {"marker": "", "linestyle": LINES[at % len(LINES)]}
        name = ", ".join(filter(None, (style.label, setting(row))))
        frame.plot(t, error, label=name, **line)
        fitted = growth_line(row)
        if fitted:
            name = f"exp({number(row, 'rate'):.3g} t)"
            frame.plot(*fitted, "--", color=INK, linewidth=1.0, zorder=4, label=name)
    logarithmic(frame, x=False)
    return legend(figure, 2)


def against_n(rows: Sequence[Row]) -> Figure | None:
    """What one kind of work costs against the number of links."""
    shown = [row for row in rows if fine(row) and number(row, "seconds") > 0]
    if not shown:
        return None
    figure, frame = axes(4.2, 3.4, "links n", "time [s]")
    frame.set(xscale="log", yscale="log")
    for name, some in grouped(shown, lambda row: text(row, "who")).items():
        ordered = sorted(some, key=lambda row: number(row, "n"))
        line = _look_of_who(name)
        n = [number(row, "n") for row in ordered]
        frame.plot(n, [number(row, "seconds") for row in ordered], label=name, **line)
    logarithmic(frame)
    return legend(figure, 2)


def saved(rows: Sequence[Row]) -> Figure | None:
    """How many times as much every term at zero costs, by scene."""
    by_scene = savings(rows)
    if not by_scene:
        return None
    figure, frame = axes(WIDTH, 1.1 + 0.62 * len(by_scene), "times as much", "")
    thick = 0.8 / len(SAVED)
    for at, (key, name) in enumerate(SAVED.items()):
        places = [place + (at - (len(SAVED) - 1) / 2) * thick for place in range(len(by_scene))]
        widths = [number(ratios, key) for ratios in by_scene.values()]
        bars = [0.0 if math.isnan(width) else width for width in widths]
        frame.barh(places, bars, thick * 0.9, color=SHADES[at], label=name)
    frame.set_yticks(range(len(by_scene)), list(by_scene), fontsize=8)
    frame.axvline(1, color=INK, linewidth=0.8)
    frame.invert_yaxis()
    frame.grid(visible=False, axis="y")
    return legend(figure)


def largest_steps(rows: Sequence[Row]) -> Figure | None:
    """Largest stable steps against the number of links: found as dots, theory as lines."""
    shown = [row for row in rows if fine(row) and number(row, "found") > 0]
    if not shown:
        return None
    figure, frame = axes(4.2, 3.4, "links n", "largest stable step [s]")
    frame.set(xscale="log", yscale="log")
    for name, some in grouped(shown, lambda row: text(row, "method")).items():
        ordered = sorted(some, key=lambda row: number(row, "n"))
        n = [number(row, "n") for row in ordered]
        colour = look({"method": name}).line["color"]
        found = [number(row, "found") for row in ordered]
        # A variant of a method lies on the method itself: a ring around the dot.
        ring = {"markerfacecolor": "none", "markersize": 8} if "," in name else {"markersize": 4.5}
        frame.plot(n, found, "o", color=colour, label=name, **ring)
        theory = [number(row, "theory") or math.nan for row in ordered]
        frame.plot(n, theory, "-", color=colour, linewidth=1.0, alpha=0.8)
    logarithmic(frame)
    return legend(figure, 2)


def _look_of_who(name: str) -> dict[str, Any]:
    """Ours in colour, by method, form or target; others as everywhere."""
    words = re.split(r"[^a-z0-9_]+", name.lower())
    if words[0] not in ("rodgen", "c", "numpy"):
        return look({"who": re.split(r"[ ,]", name)[0], "method": name}).line
    looks = {**{method: (colour, "o") for method, colour in OURS.items()}, **OF_FORM}
    shown = [one for word, one in looks.items() if word in words]
    colour, mark = shown[0] if shown else (OF_RODGEN, "o")
    return {"color": colour, "marker": mark, "markersize": 4, "linewidth": 1.4}
