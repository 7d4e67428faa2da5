"""Work-precision diagrams, in E. Hairer's convention: errors fall to the right, time goes up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodgen.judge.precision.pareto import front
from rodgen.judge.rows import fine, grouped, label, number
from rodgen.judge.unit import Row
from rodgen.view.report_style import GOLD, INK, PALE, axes, logarithmic, look

MEASURES = {
    "error_phi": "error of the angles at the end [rad]",
    "error_tail": "largest error of the tail over time [m]",
    "error_modes": "largest error of the lowest modes [rad]",
    "error_energy": "largest error of the energy [of its scale]",
}
LARGEST, SMALLEST = 10.0, 1e-17  # errors that are drawn
LEADER = {"arrowstyle": "-", "linewidth": 0.5, "alpha": 0.55, "relpos": (0, 0.5), "shrinkA": 1}
LINE = 0.145  # inches that a name takes


def work_precision(rows: Sequence[Row], measure: str, trusted: float) -> Figure | None:
    """Run time against error, with names beside the lines; None where there is nothing to draw."""
    names = grouped(drawn(rows, measure, "seconds"), label)
    if not names:
        return None
    height = max(4.0, LINE * len(names) + 0.8)
    figure, frame = axes(7.6, height, MEASURES[measure], "run time [s]")
    _lines(frame, rows, measure, "seconds", trusted)
    _front(frame, rows, measure, trusted)
    _names(frame, names, measure, "seconds", LINE / (height - 0.7))
    return figure


def small(rows: Sequence[Row], measure: str, cost: str, trusted: float) -> Figure | None:
    """The same in little, without names. cost: "seconds", or "rhs" for evaluations."""
    if not drawn(rows, measure, cost):
        return None
    title = "run time [s]" if cost == "seconds" else "evaluations of rhs"
    figure, frame = axes(4.1, 3.0, MEASURES[measure], title, fixed=True)
    _lines(frame, rows, measure, cost, trusted)
    if cost == "seconds":
        _front(frame, rows, measure, trusted)
    return figure


def drawn(rows: Sequence[Row], measure: str, cost: str) -> list[Row]:
    """What has a place in a diagram with logarithmic axes."""
    return [
        row
        for row in rows
        if fine(row) and number(row, cost) > 0 and 0 <= number(row, measure) <= LARGEST
    ]


def _error(row: Row, measure: str) -> float:
    return max(number(row, measure), SMALLEST)


def _lines(frame: Axes, rows: Sequence[Row], measure: str, cost: str, trusted: float) -> None:
    shown = drawn(rows, measure, cost)
    frame.set(xscale="log", yscale="log")
    for some in grouped(shown, label).values():
        ordered = sorted(some, key=lambda row: -number(row, "setting"))
        errors = [_error(row, measure) for row in ordered]
        frame.plot(errors, [number(row, cost) for row in ordered], **look(ordered[0]).line)
    errors = [_error(row, measure) for row in shown]
    left, right = 2.5 * max(errors), min(errors) / 2.5
    frame.set_xlim(left, right)  # falls to the right
    if trusted > right:
        frame.axvspan(right, min(trusted, left), color=PALE, alpha=0.22, linewidth=0, zorder=1)
        frame.axvline(min(trusted, left), color=PALE, linewidth=0.8, linestyle=":")
    costs = [number(row, cost) for row in shown]
    frame.set_ylim(min(costs) / 2, max(costs) * 2)
    logarithmic(frame)


def _front(frame: Axes, rows: Sequence[Row], measure: str, trusted: float) -> None:
    points = front(drawn(rows, measure, "seconds"), measure, trusted)
    errors = [_error(row, measure) for row in points]
    seconds = [number(row, "seconds") for row in points]
    frame.plot(errors, seconds, color=GOLD, linewidth=5, alpha=0.35, zorder=2)
    ring: dict[str, Any] = {"markerfacecolor": "none", "markeredgecolor": INK, "markersize": 7.5}
    frame.plot(errors, seconds, "o", markeredgewidth=0.8, zorder=4, **ring)


def _names(frame: Axes, names: dict[str, list[Row]], measure: str, cost: str, apart: float) -> None:
    """Beside the most accurate point of every line, one below the other."""
    low, high = (math.log(limit) for limit in frame.get_ylim())
    ends = {name: min(some, key=lambda row: _error(row, measure)) for name, some in names.items()}
    heights = {name: (math.log(number(r, cost)) - low) / (high - low) for name, r in ends.items()}
    places = spread(list(heights.values()), apart)
    for (name, row), place in zip(ends.items(), places, strict=True):
        style = look(row)
        colour = style.line["color"]
        frame.annotate(
            name,
            (_error(row, measure), number(row, cost)),
            (1.04, place),
            textcoords="axes fraction",
            fontsize=7.5,
            color=colour,
            va="center",
            fontweight="bold" if style.ours else "normal",
            arrowprops={"color": colour, **LEADER},
        )


def spread(heights: Sequence[float], apart: float) -> list[float]:
    """Places from 0 to 1 in the order of these heights, at least so far apart, and together as
    near to them as can be (least squares: those that are too close share their mean)."""
    order = sorted(range(len(heights)), key=heights.__getitem__)
    apart = min(apart, 1.0 / max(len(heights) - 1, 1))
    blocks: list[tuple[float, int]] = []  # mean of heights without the distances, how many
    for rank, at in enumerate(order):
        mean, count = heights[at] - rank * apart, 1
        while blocks and blocks[-1][0] > mean:
            above, others = blocks.pop()
            mean = (mean * count + above * others) / (count + others)
            count += others
        blocks.append((mean, count))
    means = [mean for mean, count in blocks for _ in range(count)]
    highest = max(0.0, 1.0 - (len(heights) - 1) * apart)
    places = [0.0] * len(heights)
    for rank, (at, mean) in enumerate(zip(order, means, strict=True)):
        places[at] = min(max(mean, 0.0), highest) + rank * apart
    return places
