"""Figures 3.1 to 3.6, 4.1 and 4.2 rebuilt: the thesis's values and ours in the same picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodgen.show.canvas import add_legend, make_axes
from rodgen.show.picture_files import save_figures as write_figures
from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.largest_steps import NAMES
from rodgen_evidence.thesis.percentages import beck
from rodgen_evidence.thesis.table import ThesisTable

# What is printed: hollow black marks. What is ours: coloured lines and dots.
PRINTED: dict[str, Any] = {
    "color": "black",
    "markerfacecolor": "none",
    "linestyle": "none",
    "markersize": 7,
}
OURS: dict[str, Any] = {"linewidth": 1.2, "markersize": 3.5}
REFERENCE: dict[str, Any] = {"color": "grey", "linestyle": "--", "linewidth": 1.0}
COLOURS = dict(zip(NAMES.values(), ("tab:red", "tab:blue", "tab:green"), strict=True))
Tables = Mapping[str, ThesisTable]
Draw = Callable[[Axes, Tables], object]


class Picture:
    """below: the table under which it stands; parts: drawn in turn."""

    def __init__(
        self,
        below: str,
        caption: str,
        y: str,
        *parts: Draw,
        x: str = "links",
        scale: str = "linear",
    ):
        self.below, self.caption, self.parts = below, caption, parts
        self.axes = {"xlabel": x, "ylabel": y, "yscale": scale}


def save_figures(tables: Tables, folder: Path) -> dict[str, str]:
    """Write figure_3_1.png and so on into a folder that exists; their names by number."""
    found = {number: f"figure_{number.replace('.', '_')}" for number in FIGURES}
    drawn = ((found[number], _draw(picture, tables)) for number, picture in FIGURES.items())
    files = write_figures(drawn, folder)
    return {number: file.name for number, file in zip(found, files, strict=True)}


def _draw(picture: Picture, tables: Tables) -> Figure:
    figure, (axes,) = make_axes(6.4, 4.2)
    axes.set(**picture.axes)
    for draw in picture.parts:
        draw(axes, tables)
    add_legend(figure)
    return figure


def line(number: str, key: str, mark: str, label: str, **look: Any) -> Draw:
    """A column of a table against the number of links; of a method alone if it is in the label."""

    def draw(axes: Axes, tables: Tables) -> None:
        rows = tables[number].rows
        if "method" in rows:
            rows = rows[[label.endswith(f", {name}") for name in rows["method"]]]
        axes.plot(rows["links"], rows[key], mark, label=label, **look)

    return draw


def ours(number: str, key: str, mark: str, label: str, colour: str) -> Draw:
    """A line of ours."""
    return line(number, key, mark, label, **OURS, color=f"tab:{colour}")


def by_method(number: str, key: str, label: str) -> Iterator[Draw]:
    """The printed column and another, a line for every method."""
    for mark, (name, colour) in zip("ovs", COLOURS.items(), strict=True):
        yield line(number, "thesis", mark, f"thesis, {name}", **PRINTED | {"color": colour})
    for name, colour in COLOURS.items():
        yield line(number, key, ".-", f"{label}, {name}", **OURS, color=colour)


def level(value: Callable[[Tables], float], label: str, **look: Any) -> Draw:
    """A value that does not depend on the number of links."""
    return lambda axes, tables: axes.axhline(value(tables), label=label, **(look or REFERENCE))


def continuum(number: str) -> Draw:
    """The value of the continuum that a table has."""
    return level(lambda tables: tables[number].rows["continuum"][0], "continuum")


def own_weight(axes: Axes, tables: Tables) -> None:
    """The shape of the cantilever, its printed deflections, and the continuum."""
    table = tables["3.3"]
    x, y = np.array(table.curve).T
    axes.plot(x, y, "o-", label="discrete model in equilibrium", color="tab:blue", **OURS)
    for mark, key in ("o", "simulated"), ("s", "analytical"):
        axes.plot(x[-1], -float(data.TABLE_3_3[key][0]), mark, label=f"thesis, {key}", **PRINTED)
    s = np.linspace(0, 1, 101)
    sag = table.rows["continuum"][0] * (6 * s**2 - 4 * s**3 + s**4) / 3
    axes.plot(scenes.LENGTH * s, -sag, label="continuum, clamped at x = 0", **REFERENCE)


def near_the_continuum(axes: Axes, tables: Tables) -> None:
    """Limits, since the first value is far below all others, which would then be a line."""
    axes.set(xlim=(0, 52.5), ylim=(390, 450))
    links, force = tables["3.4"].rows[["links", "thesis"]].iloc[0]
    words = f"n = {links:.0f}:\n{force:.0f} N"
    axes.annotate(words, (links, 390), (3, 397), arrowprops={"arrowstyle": "->"})


FIGURES = {
    "3.1": Picture(
        *("3.2", "the first frequency of the free rod against the number of links"),
        "first frequency of the free rod [Hz]",
        line("3.2", "thesis", "o", "thesis", **PRINTED),
        line("3.2", "simulated", ".", "ours, simulated", color="tab:red", ms=9),
        ours("3.2", "discrete", "-", "discrete model", "blue"),
        ours("3.2", "lumped", "-.", "lumped mass", "orange"),
        continuum("3.2"),
    ),
    "3.2": Picture(
        *("3.2", "run time against the number of links", "run time of 50 s [s]"),
        line("3.2", "thesis_seconds", "o", "thesis, Java", **PRINTED),
        ours("3.2", "seconds", "o-", "ours, C", "blue"),
        scale="log",
    ),
    "3.3": Picture(
        *("3.3", "the cantilever under its own weight", "y [m], magnified", own_weight),
        x="x [m]",
    ),
    "3.4": Picture(
        *("3.5", "the critical force of the free rod", "critical force of the free rod [N]"),
        line("3.4", "thesis", "o", "thesis, special model", **PRINTED),
        line("3.5", "thesis", "^", "thesis, FyDiK", **PRINTED),
        ours("3.4", "discrete", "-", "discrete model", "blue"),
        ours("3.5", "discrete", "o-", "mass-spring", "orange"),
        continuum("3.4"),
        level(lambda _: float(data.THRUST), "thesis, (3.3)", color="black", ls=":", lw=1),
        near_the_continuum,
    ),
    "3.5": Picture(
        *("3.5", "run times of the special and the general model", "run time of 200 s [s]"),
        line("3.4", "thesis_seconds", "o", "thesis, special", **PRINTED),
        line("3.5", "thesis_seconds", "^", "thesis, FyDiK", **PRINTED),
        ours("3.5", "seconds", "o-", "mass-spring, NumPy", "orange"),
        ours("3.5", "special_numpy", "o-", "special, NumPy", "green"),
        ours("3.5", "special_c", "o-", "special, C", "blue"),
        scale="log",
    ),
    "3.6": Picture(
        *("3.6", "the critical force of the cantilever", "critical force of the cantilever [N]"),
        line("3.6", "thesis", "o", "thesis, simulated", **PRINTED),
        line("3.6", "thesis_analytical", "s", "thesis, (3.4)", **PRINTED),
        ours("3.6", "discrete", "-", "discrete model", "blue"),
        ours("3.6", "clamped", "-", "better clamp", "green"),
        level(lambda _: beck(inf), "continuum, length L"),
    ),
    "4.1": Picture(
        *("4.1", "the largest stable steps", "largest stable step [s]"),
        *by_method("4.1", "limit", "theory"),
        scale="log",
    ),
    "4.2": Picture(
        *("4.2", "run times at these steps", "run time [s] (ours: of 200 s)"),
        *by_method("4.2", "c", "ours in C"),
        scale="log",
    ),
}
