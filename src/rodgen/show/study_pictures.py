"""Pictures of a study, made for print: curves, maps, matrices of maps, bifurcations, scatter."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodgen.arrays import Array
from rodgen.show.canvas import INK, LINE, SERIES, SPECIAL, make_axes, make_figure
from rodgen.show.run_pictures import save_figures
from rodgen.show.study_maps import map_matrix, map_plot, period_map
from rodgen.show.study_results import StudyResults

if TYPE_CHECKING:
    import xarray

MOST_PICTURES = 12
COLUMNS = 5  # of a scatter matrix, beside what is kept
FEW = 200  # points of a curve, up to which they are joined by lines


def save_study_pictures(dataset: xarray.Dataset, folder: Path) -> list[Path]:
    """Write pictures of what a study has kept as PNG into a folder that exists; returns the files.

    One axis: a curve of every number, a bifurcation diagram of every section. Two: a map with lines
    of equal values, and the points where not all are computed; of a section, how many values it
    has. Three: a matrix of maps. Samples, and more axes: a scatter matrix. Failed points are red
    crosses. Of more than 200 000 points only some are shown, as the title says.
    """
    pictures = pictures_of(dataset)
    return save_figures(((file_name(name), make()) for name, make in pictures.items()), folder)


def pictures_of(dataset: xarray.Dataset) -> dict[str, Callable[[], Figure]]:
    """Return the functions that draw the pictures of a study, by the names of the pictures."""
    of = StudyResults.subsample(dataset)
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
    _mark_failures(axes, of, x)
    of.set_axis(axes, of.axes[0], "x")
    if classes:
        axes.set_yticks(range(len(classes)), classes)
    axes.set(ylabel=of.label(name), title=of.title)
    if columns.shape[1] > 1 or of.failures.any():
        axes.legend(fontsize="small")
    return figure


def _mark_failures(axes: Axes, of: StudyResults, x: Array) -> None:
    """Mark points that failed, along the lower edge."""
    lost = x[of.failures]
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
    _mark_failures(axes, of, x)
    of.set_axis(axes, of.axes[0], "x")
    axes.set(ylabel=of.label(name), title=f"{of.title}: bifurcation diagram")
    return figure


# Samples ------------------------------------------------------------------------------------------


def scatter_matrix(of: StudyResults) -> Figure:
    """Scatter matrix: every number over every other, histograms on the diagonal."""
    columns = [*_scatter_columns(of)]
    lost = of.failures.ravel()
    count = len(columns)
    figure = make_figure(1.7 * count + 0.6, 1.7 * count + 0.6)
    panels = figure.subplots(count, count, squeeze=False)
    size = float(np.clip(60 / np.sqrt(max(1, of.status.size)), 0.5, 3.0))
    for row, (y_name, y, y_varied) in enumerate(columns):
        for column, (x_name, x, x_varied) in enumerate(columns):
            axes: Axes = panels[row, column]
            axes.tick_params(labelsize="xx-small")
            if column > row:
                axes.set_visible(False)
            elif column == row:
                axes.hist(x[np.isfinite(x)], bins=30, color=SERIES[0 if x_varied else 4])
                axes.set_yticks([])
            else:
                there = ~lost & np.isfinite(x) & np.isfinite(y)
                axes.plot(
                    x[there], y[there], ".", color=INK, alpha=0.4, markersize=size, rasterized=True
                )
                if x_varied and y_varied:
                    axes.plot(x[lost], y[lost], "x", color=SPECIAL, markersize=2 * size)
            if row == count - 1:
                axes.set_xlabel(_short_label(of, x_name), fontsize="x-small")
            if column == 0:
                axes.set_ylabel(_short_label(of, y_name), fontsize="x-small")
    failed = f", {lost.sum()} of {lost.size} failed (red)" if lost.any() else ""
    figure.suptitle(f"{of.title}: {lost.size} points{failed}", fontsize="medium")
    return figure


def _scatter_columns(of: StudyResults) -> Iterator[tuple[str, Array, bool]]:
    """Yield name and values of varied keys and of kept numbers, and whether each is varied."""
    for name in of.axes[:COLUMNS]:
        values, _ = of.axis_values(name)
        if not of.is_sample:
            values = np.broadcast_to(
                values.reshape([-1 if one == name else 1 for one in of.axes]), of.status.shape
            )
        yield name, values.ravel(), True
    left = COLUMNS
    for name in of.kept:
        if not of.inner_dims(name) and left:
            left -= 1
            yield name, of.values_of(name)[0].ravel(), False


def _short_label(of: StudyResults, name: str) -> str:
    """Return a label that fits a small panel."""
    label = of.label(name)
    if name not in of.axes or label != name:
        return label
    before, _, last = name.rpartition(".")
    return f"{before.rpartition('.')[2]}.{last}" if last.isdecimal() else last
