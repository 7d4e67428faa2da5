"""Figures 3.1 to 3.6, 4.1 and 4.2 rebuilt: the thesis's values and ours in the same picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rodgen.thesis import data, scenes
from rodgen.thesis.table import Table

DOTS_PER_INCH = 150
# What is printed: hollow black marks. What is ours: coloured lines and dots.
PRINTED: dict[str, Any] = {
    "color": "black",
    "markerfacecolor": "none",
    "linestyle": "none",
    "markersize": 7,
}
OURS: dict[str, Any] = {"linewidth": 1.2, "markersize": 3.5}
REFERENCE: dict[str, Any] = {"color": "grey", "linestyle": "--", "linewidth": 1.0}
METHODS = {
    "Euler": "tab:red",
    "semi-implicit Euler": "tab:blue",
    "Runge-Kutta, as listed": "tab:green",
}
Tables = Mapping[str, Table]


def save_figures(tables: Tables, folder: Path) -> dict[str, str]:
    """Write figure_3_1.png and so on into a folder that exists; their names by number."""
    names = {}
    for number, draw in FIGURES.items():
        names[number] = f"figure_{number.replace('.', '_')}.png"
        draw(tables).savefig(folder / names[number], dpi=DOTS_PER_INCH)
    return names


def _axes(x: str, y: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
    axes.set(xlabel=x, ylabel=y)
    return figure, axes


def _finish(figure: Figure, columns: int = 2) -> Figure:
    figure.legend(loc="outside lower center", ncols=columns, fontsize="small", frameon=False)
    return figure


def first_frequency(tables: Tables) -> Figure:
    """3.1: the first frequency of the free rod against the number of links."""
    figure, axes = _axes("links", "first frequency of the free rod [Hz]")
    table = tables["3.2"]
    n = table.column("links")
    axes.plot(n, table.column("thesis"), "o", label="thesis", **PRINTED)
    axes.plot(n, table.column("simulated"), ".", label="ours, simulated", color="tab:red", ms=9)
    axes.plot(n, table.column("discrete"), label="discrete model", color="tab:blue", **OURS)
    axes.plot(n, table.column("lumped"), "-.", label="lumped mass", color="tab:orange", **OURS)
    axes.axhline(table.column("continuum")[0], label="continuum", **REFERENCE)
    return _finish(figure, 3)


def frequency_times(tables: Tables) -> Figure:
    """3.2: run time against the number of links."""
    figure, axes = _axes("links", "run time of 50 s [s]")
    table = tables["3.2"]
    n = table.column("links")
    axes.semilogy(n, table.column("thesis_seconds"), "o", label="thesis, Java", **PRINTED)
    axes.semilogy(n, table.column("seconds"), "o-", label="ours, C", color="tab:blue", **OURS)
    return _finish(figure)


def own_weight(tables: Tables) -> Figure:
    """3.3: the cantilever under its own weight."""
    figure, axes = _axes("x [m]", "y [m], magnified")
    table = tables["3.3"]
    x, y = np.array(table.curve).T
    axes.plot(x, y, "o-", label="discrete model in equilibrium", color="tab:blue", **OURS)
    tip = [-float(text) for text in (data.TABLE_3_3[0].simulated, data.TABLE_3_3[0].analytical)]
    axes.plot(x[-1], tip[0], "o", label="thesis, simulated", **PRINTED)
    axes.plot(x[-1], tip[1], "s", label="thesis, analytical", **PRINTED)
    s = np.linspace(0, 1, 101)
    sag = table.column("continuum")[0] * (6 * s**2 - 4 * s**3 + s**4) / 3
    axes.plot(scenes.LENGTH * s, -sag, label="continuum, clamped at x = 0", **REFERENCE)
    return _finish(figure)


def free_critical(tables: Tables) -> Figure:
    """3.4: the critical force of the free rod."""
    figure, axes = _axes("links", "critical force of the free rod [N]")
    special, general = tables["3.4"], tables["3.5"]
    n, m = special.column("links"), general.column("links")
    axes.plot(n, special.column("thesis"), "o", label="thesis, special model", **PRINTED)
    axes.plot(m, general.column("thesis"), "^", label="thesis, FyDiK", **PRINTED)
    axes.plot(n, special.column("discrete"), "-", label="discrete model", color="tab:blue", **OURS)
    axes.plot(m, general.column("discrete"), "o-", label="mass-spring", color="tab:orange", **OURS)
    axes.axhline(special.column("continuum")[0], label="continuum", **REFERENCE)
    axes.axhline(float(data.THRUST), label="thesis, (3.3)", color="black", linestyle=":", lw=1)
    # The first value is far below all others, which would then be a line.
    axes.set_ylim(390, 450)
    axes.set_xlim(0, 52.5)
    first = f"n = {n[0]:.0f}:\n{special.column('thesis')[0]:.0f} N"
    axes.annotate(first, (n[0], 390), (3, 397), arrowprops={"arrowstyle": "->"})
    return _finish(figure, 3)


def critical_times(tables: Tables) -> Figure:
    """3.5: run times of the special and the general model."""
    figure, axes = _axes("links", "run time of 200 s [s]")
    special, general = tables["3.4"], tables["3.5"]
    n, m = special.column("links"), general.column("links")
    axes.semilogy(n, special.column("thesis_seconds"), "o", label="thesis, special", **PRINTED)
    axes.semilogy(m, general.column("thesis_seconds"), "^", label="thesis, FyDiK", **PRINTED)
    lines = (
        ("seconds", "mass-spring, NumPy", "tab:orange"),
        ("special_numpy", "special, NumPy", "tab:green"),
        ("special_c", "special, C", "tab:blue"),
    )
    for key, label, color in lines:
        axes.semilogy(m, general.column(key), "o-", label=label, color=color, **OURS)
    return _finish(figure, 3)


def cantilever_critical(tables: Tables) -> Figure:
    """3.6: the critical force of the cantilever."""
    figure, axes = _axes("links", "critical force of the cantilever [N]")
    table = tables["3.6"]
    n = table.column("links")
    axes.plot(n, table.column("thesis"), "o", label="thesis, simulated", **PRINTED)
    axes.plot(n, table.column("thesis_analytical"), "s", label="thesis, (3.4)", **PRINTED)
    axes.plot(n, table.column("discrete"), "-", label="discrete model", color="tab:blue", **OURS)
    axes.plot(n, table.column("clamped"), "-", label="better clamp", color="tab:green", **OURS)
    beck = float(data.BECK_COEFFICIENT) * scenes.STIFFNESS / scenes.LENGTH**2
    axes.axhline(beck, label="continuum, length L", **REFERENCE)
    return _finish(figure, 3)


def _by_method(table: Table, key: str) -> dict[str, tuple[list[float], list[float]]]:
    rows = [(str(row["method"]), row) for row in table.rows]
    n, values = table.column("links"), table.column(key)
    return {
        name: (
            [n[i] for i, (method, _) in enumerate(rows) if method == name],
            [values[i] for i, (method, _) in enumerate(rows) if method == name],
        )
        for name in dict.fromkeys(method for method, _ in rows)
    }


def _methods(table: Table, y: str, ours: str, label: str) -> Figure:
    figure, axes = _axes("links", y)
    marks = dict(zip(METHODS, "ovs", strict=True))
    for name, (n, values) in _by_method(table, "thesis").items():
        style = PRINTED | {"color": METHODS[name]}
        axes.semilogy(n, values, marks[name], label=f"thesis, {name}", **style)
    for name, (n, values) in _by_method(table, ours).items():
        axes.semilogy(n, values, ".-", label=f"{label}, {name}", color=METHODS[name], **OURS)
    return _finish(figure, 2)


def largest_steps(tables: Tables) -> Figure:
    """4.1: the largest stable steps."""
    return _methods(tables["4.1"], "largest stable step [s]", "limit", "theory")


def method_times(tables: Tables) -> Figure:
    """4.2: run times at these steps."""
    return _methods(tables["4.2"], "run time [s] (ours: of 200 s)", "c", "ours in C")


FIGURES: dict[str, Callable[[Tables], Figure]] = {
    "3.1": first_frequency,
    "3.2": frequency_times,
    "3.3": own_weight,
    "3.4": free_critical,
    "3.5": critical_times,
    "3.6": cantilever_critical,
    "4.1": largest_steps,
    "4.2": method_times,
}
CAPTIONS = {
    number: (draw.__doc__ or "").partition(": ")[2].rstrip(".") for number, draw in FIGURES.items()
}
