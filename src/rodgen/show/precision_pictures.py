"""Work-precision diagrams in E. Hairer's convention, where errors fall to the right and time goes
up; and the line styles of methods."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import Formatter, FuncFormatter, NullFormatter

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import (
    format_label,
    group_rows,
    has_result,
    pareto_front,
    read_number,
    read_text,
)
from rodgen.analyse.precision.work_precision import WorkPrecision
from rodgen.errors import EmptyPictureError
from rodgen.show.canvas import FAINT, GUIDE, INK, SERIES, TAIL, add_legend, make_figure

# The colour of the series, from 1 on, and the mark.
OURS = {
    "gauss": (2, "o"),
    "radau": (7, "o"),
    "dop853": (1, "o"),
    "rk4": (3, "o"),
    "semi_implicit_euler": (5, "o"),
    "euler": (8, "o"),
    "thesis_runge_kutta": (6, "o"),
    "cvode": (4, "o"),
    "rk45": (1, "s"),
    "rk23": (6, "s"),
    "bdf": (4, "s"),
    "lsoda": (5, "s"),
}
PEERS = {
    "SciPy": "s",
    "CVODE": "D",
    "heyoka": "^",
    "MuJoCo": "v",
    "Exudyn": "P",
    "CasADi": "X",
    "Numba": "*",
    "PyDy": "<",
    "Pinocchio": "p",
}
OTHERS = ("<", ">", "d")
PEER_DASHES = ((4, 2), (1.5, 1.5), (6, 2, 1, 2), (3, 1, 1, 1, 1, 1))
RAISED = str.maketrans(
    "-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"
)
MEASURES = {
    "error_phi": "error of the angles at the end [rad]",
    "error_angles": "largest error of the angles over time [rad]",
    "error_rates": "largest error of the rates over time [rad/s]",
    "error_tail": "largest error of the tail over time [m]",
    "error_modes": "largest error of the lowest modes [rad]",
    "error_energy": "largest error of the energy [of its scale]",
}
LARGEST_ERROR, SMALLEST_ERROR = 10.0, 1e-17  # errors that are drawn


def line_style(row: Measurement) -> dict[str, Any]:
    """Return the style of the line of a method, the same everywhere: those of rodgen in colour,
    with hollow marks for equations in NumPy; those of others grey and dashed."""
    method, target, who = (read_text(row, key) for key in ("method", "target", "who"))
    style: dict[str, Any]
    if who in ("", "rodgen"):
        colour, mark = own_style(method)
        style = {"color": colour, "linestyle": "-", "linewidth": 1.4, "zorder": 3.0}
        style |= {} if target != "numpy" else {"markerfacecolor": "none", "linewidth": 0.9}
    else:
        mark = PEERS.get(who, OTHERS[_stable_hash(who) % len(OTHERS)])
        dashes = (0, PEER_DASHES[_stable_hash(method + target) % len(PEER_DASHES)])
        style = {"color": FAINT, "linestyle": dashes, "linewidth": 1.0, "zorder": 2.5}
    return style | {"marker": mark, "markersize": 3.8}


def own_style(method: str) -> tuple[str, str]:
    """Return colour and mark of a method of rodgen, or of a variant of one."""
    number, mark = OURS.get(re.split(r"[ ,]", method.lower())[0], (0, "o"))
    return (SERIES[number - 1] if number else FAINT), mark


def _stable_hash(name: str) -> int:
    """Return a number for a name, alike in every process, as hash() is not."""
    return sum(map(ord, name))


def make_diagram(width: float, height: float, x: str, y: str) -> tuple[Figure, Axes]:
    """Make a figure of one diagram with a pale grid; sizes in inches."""
    figure = make_figure(width, height)
    frame = figure.add_subplot()
    style_frame(frame, x, y)
    return figure, frame


def style_frame(frame: Axes, x: str, y: str) -> None:
    """Give axes their labels and a pale grid."""
    frame.grid(color=GUIDE, alpha=0.3, linewidth=0.6)
    frame.tick_params(colors=INK)
    frame.set_xlabel(x, color=INK)
    frame.set_ylabel(y, color=INK)
    for side, spine in frame.spines.items():
        spine.set(color=GUIDE, visible=side in ("left", "bottom"))


def label_logarithmic(frame: Axes, *, x: bool = True, y: bool = True) -> None:
    """Label logarithmic axes, once their limits are set, in plain text: mathematics is slow."""
    for axis, wanted in ((frame.xaxis, x), (frame.yaxis, y)):
        if wanted:
            low, high = sorted(axis.get_view_interval())
            axis.set_major_formatter(FuncFormatter(lambda value, _: _power_label(value)))
            axis.set_minor_formatter(_minor_formatter(high / low))
            axis.set_tick_params(which="minor", labelcolor=INK, color=GUIDE)


def _power_label(value: float) -> str:
    """Write a power of ten with its exponent raised."""
    return "10" + f"{math.log10(value):.0f}".translate(RAISED)


def _minor_formatter(ratio: float) -> Formatter:
    """Return labels between powers of ten; ratio: largest over smallest value. Few powers leave
    room for 2 and 5, too; where there may be none, everything has a label."""
    if ratio > 30:
        return NullFormatter()

    def minor_label(value: float, _: object = None) -> str:
        digits, _, power = f"{value:.3e}".partition("e")
        digits = digits.rstrip("0").rstrip(".")
        shown = ratio < 3 or digits in ("2", "5")
        return f"{digits}\u00b7{_power_label(10.0 ** int(power))}" if shown else ""

    return FuncFormatter(minor_label)


def work_precision(rows: Sequence[Measurement], measure: str, trusted: float) -> Figure | None:
    """Run time over error, with names below; None where there is nothing to draw."""
    if not drawable_rows(rows, measure, "seconds"):
        return None
    figure, frame = make_diagram(7.6, 4.2, MEASURES[measure], "run time [s]")
    draw_lines(frame, rows, measure, "seconds", trusted)
    draw_front(frame, rows, measure, trusted)
    add_legend(figure)
    return figure


def drawable_rows(rows: Sequence[Measurement], measure: str, cost: str) -> list[Measurement]:
    """Return the rows that have a place in a diagram with logarithmic axes."""
    return [
        row
        for row in rows
        if has_result(row)
        and read_number(row, cost) > 0
        and 0 <= read_number(row, measure) <= LARGEST_ERROR
    ]


def _error(row: Measurement, measure: str) -> float:
    return max(read_number(row, measure), SMALLEST_ERROR)


def draw_lines(
    frame: Axes, rows: Sequence[Measurement], measure: str, cost: str, trusted: float
) -> None:
    """Draw a line for every method. cost: "seconds", or "nfev" for evaluations; trusted: error to
    which the reference tells them apart."""
    shown = drawable_rows(rows, measure, cost)
    frame.set(xscale="log", yscale="log")
    for name, some in group_rows(shown, format_label).items():
        ordered = sorted(some, key=lambda row: -read_number(row, "setting"))
        errors = [_error(row, measure) for row in ordered]
        frame.plot(
            errors,
            [read_number(row, cost) for row in ordered],
            label=name,
            **line_style(ordered[0]),
        )
    errors = [_error(row, measure) for row in shown]
    left, right = 2.5 * max(errors), min(errors) / 2.5
    frame.set_xlim(left, right)  # falls to the right
    if trusted > right:
        frame.axvspan(right, min(trusted, left), color=GUIDE, alpha=0.22, linewidth=0, zorder=1)
        frame.axvline(min(trusted, left), color=GUIDE, linewidth=0.8, linestyle=":")
    costs = [read_number(row, cost) for row in shown]
    frame.set_ylim(min(costs) / 2, max(costs) * 2)
    label_logarithmic(frame)


def draw_front(frame: Axes, rows: Sequence[Measurement], measure: str, trusted: float) -> None:
    """Draw the Pareto front of run time and error, which nothing beats in both."""
    points = pareto_front(drawable_rows(rows, measure, "seconds"), measure, trusted)
    errors = [_error(row, measure) for row in points]
    seconds = [read_number(row, "seconds") for row in points]
    frame.plot(errors, seconds, color=TAIL, linewidth=5, alpha=0.35, zorder=2)
    ring: dict[str, Any] = {"markerfacecolor": "none", "markeredgecolor": INK, "markersize": 7.5}
    frame.plot(errors, seconds, "o", markeredgewidth=0.8, zorder=4, **ring)


def _draw_result(found: WorkPrecision) -> Figure:
    drawn = work_precision(found.rows, found.measure, found.trusted[found.measure] or 0.0)
    if drawn is None:
        raise EmptyPictureError("rows", len(found.rows), "at least one that can be drawn")
    return drawn


PICTURES_OF = {WorkPrecision: {"diagram": _draw_result}}
