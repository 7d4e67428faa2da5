"""Pictures of a study, made for print: curves, maps, matrices of maps, bifurcations, scatter."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodgen.arrays import Array
from rodgen.show.canvas import (
    BELOW,
    BESIDE,
    CURVE,
    INK,
    LINE,
    SERIES,
    SPECIAL,
    add_figure_remark,
    break_lines,
    height_of,
    make_axes,
    make_figure,
    make_panels,
    set_height,
    set_title,
    width_of,
)
from rodgen.show.picture_files import save_figures
from rodgen.show.picture_settings import PictureSettings
from rodgen.show.study_maps import map_matrix, map_plot, period_map
from rodgen.show.study_results import StudyResults

if TYPE_CHECKING:
    import xarray

MOST_PICTURES = 12
SCATTER_COLUMNS = 5  # of a scatter matrix, and rows
LEAST_ROW = 0.9  # inches: of such a matrix
DENSE, DENSITY = 3000, "Blues"  # points from which on their density is drawn, and its colours
FEW = 200  # points of a curve, up to which they are joined by lines


def save_study_pictures(
    dataset: xarray.Dataset, folder: Path, settings: PictureSettings
) -> list[Path]:
    """Write pictures of what a study has kept into a folder that exists; returns the files.

    One axis: a curve of every number, a bifurcation diagram of every section. Two: a map with lines
    of equal values, and the points where not all are computed; of a section, how many values it
    has. Three: a matrix of maps. Samples, and more axes: a scatter matrix. Failed points are red
    crosses. Of more than 200 000 points only some are shown, as words below say.
    """
    pictures = pictures_of(dataset)
    figures = ((file_name(name), make()) for name, make in pictures.items())
    return save_figures(figures, folder, settings)


def pictures_of(dataset: xarray.Dataset) -> dict[str, Callable[[], Figure]]:
    """Return the functions that draw the pictures of a study, by the names of the pictures."""
    of = StudyResults.subsample(dataset)
    return {name: partial(_draw_share, of, draw) for name, draw in _pictures(of).items()}


def _draw_share(of: StudyResults, draw: Callable[[], Figure]) -> Figure:
    """Draw a picture that says below which share of the points it shows, where that is not all."""
    figure = draw()
    if of.share:
        add_figure_remark(figure, f"shown: {of.share}")
    return figure


def _pictures(of: StudyResults) -> dict[str, Callable[[], Figure]]:
    count = len(of.axes)
    if of.is_sample or count > 3:
        return {"scatter": partial(scatter_matrix, of)}
    draw = (curve_plot, map_plot, map_matrix)[count - 1]
    found: dict[str, Callable[[], Figure]] = {}
    for name in of.kept[:MOST_PICTURES]:
        if of.is_section(name):
            if count < 3 and not name.endswith(".t"):
                found[name] = partial((bifurcation_plot, period_map)[count - 1], of, name)
        elif count == 1 or not of.inner_dims(name):
            found[name] = partial(draw, of, name)
    return found


def file_name(name: str) -> str:
    """Make a file name of the name of a variable."""
    return re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "picture"


# One axis -----------------------------------------------------------------------------------------


def curve_plot(of: StudyResults, name: str) -> Figure:
    """Curve of a number over an axis; of several numbers, one each."""
    figure, (axes,) = make_axes(6.0, 4.0)
    x, _ = of.axis_values(of.axes[0])
    values, classes = of.values_of(name)
    columns = values.reshape(len(x), -1)
    order = np.argsort(x)
    axes.set_prop_cycle(color=SERIES)
    # Where a result hangs on its axis more finely than it was computed, lines would say too much.
    size = 3.0 if len(x) <= FEW else 1.5
    style = "." if classes or len(x) > FEW else ".-"
    for at in range(columns.shape[1]):
        label = f"{at + 1}" if columns.shape[1] > 1 else None
        axes.plot(x[order], columns[order, at], style, linewidth=LINE, markersize=size, label=label)
    _mark_lost(axes, x[of.failures])
    of.set_axis(axes, of.axes[0], "x")
    if classes:
        axes.set_yticks(range(len(classes)), classes)
    axes.set(ylabel=of.label(name))
    set_title(figure, of.title)
    if columns.shape[1] > 1 or of.failures.any():
        axes.legend()
    return figure


def _mark_lost(axes: Axes, lost: Array) -> None:
    """Mark points that failed, along the lower edge."""
    if len(lost):
        axes.plot(
            lost,
            np.full(len(lost), 0.02),
            "x",
            color=SPECIAL,
            markersize=4,
            transform=axes.get_xaxis_transform(),
            label="failed",
        )


def bifurcation_plot(of: StudyResults, name: str) -> Figure:
    """All values of a section over an axis."""
    figure, (axes,) = make_axes(6.5, 4.5)
    x, _ = of.axis_values(of.axes[0])
    values, _ = of.values_of(name)
    points = np.repeat(x[:, None], values.shape[1], axis=1)
    shown = np.isfinite(values)
    size = float(np.clip(3e3 / max(1, shown.sum()), 0.1, 3.0))
    axes.plot(points[shown], values[shown], ".", color=INK, markersize=size, rasterized=True)
    _mark_lost(axes, x[of.failures])
    of.set_axis(axes, of.axes[0], "x")
    axes.set(ylabel=of.label(name))
    set_title(figure, f"{of.title}: bifurcation diagram")
    return figure


# Samples ------------------------------------------------------------------------------------------


def scatter_matrix(of: StudyResults) -> Figure:
    """Every result over every varied number, and beside them how the results are distributed."""
    inputs, results = _scatter_columns(of)
    lost = of.failures.ravel()
    rows, columns = max(len(results), 1), len(inputs)
    figure = make_figure(1.7 * columns + 1.6, 1.5 * rows + 0.7)
    set_height(figure, max(height_of(figure), LEAST_ROW * rows + BELOW))
    ratios = [*[1.0] * columns, 0.4]
    how: dict[str, Any] = {"sharex": "col", "sharey": "row", "width_ratios": ratios}
    panels = make_panels(figure, rows, columns + 1, **how)
    width, height = (width_of(figure) - BESIDE) / columns, height_of(figure) / rows
    for row, (name, y) in enumerate(results):
        there = ~lost & np.isfinite(y)
        for axes, (_, x) in zip(panels[row], inputs, strict=False):
            _draw_points(axes, x[there], y[there])
        bins = min(max(int(np.sqrt(there.sum())), 5), 40)
        panels[row, -1].hist(y[there], bins=bins, orientation="horizontal", color=CURVE)
        panels[row, -1].set_axis_off()
        panels[row, 0].set_ylabel(break_lines(of.label(name), 0.65 * height))
    for at, (name, x) in enumerate(inputs):
        panels[-1, at].set_xlabel(break_lines(of.label(name), width))
        _mark_lost(panels[-1, at], x[lost])
    if lost.any():
        add_figure_remark(figure, f"{lost.sum()} of {lost.size} points failed (red)")
    set_title(figure, f"{of.title}: {lost.size} points")
    return figure


def _draw_points(axes: Axes, x: Array, y: Array) -> None:
    """Draw points, or their density where there are many."""
    if len(x) > DENSE:
        axes.hexbin(x, y, gridsize=30, cmap=DENSITY, mincnt=1, bins="log", linewidths=0.1)
        return
    size = float(np.clip(60 / np.sqrt(max(1, len(x))), 0.8, 3.0))
    how: dict[str, Any] = {"alpha": 0.5, "markersize": size, "markeredgewidth": 0}
    axes.plot(x, y, ".", color=CURVE, rasterized=True, **how)


def _scatter_columns(
    of: StudyResults,
) -> tuple[list[tuple[str, Array]], list[tuple[str, Array]]]:
    """Return names and values of the varied numbers and of the results that are single numbers."""
    inputs = []
    for name in of.axes[:SCATTER_COLUMNS]:
        values, _ = of.axis_values(name)
        if not of.is_sample:
            values = np.broadcast_to(
                values.reshape([-1 if one == name else 1 for one in of.axes]), of.status.shape
            )
        inputs.append((name, values.ravel()))
    single = [name for name in of.kept if not of.inner_dims(name)][:SCATTER_COLUMNS]
    return inputs, [(name, of.values_of(name)[0].ravel()) for name in single]
