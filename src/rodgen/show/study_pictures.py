"""Pictures of a study, made for print: curves, maps, matrices of maps, bifurcations, scatter."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray

from rodgen.arrays import even_indices
from rodgen.integrate.stepper import FINISHED, NO_RESULT
from rodgen.show.canvas import BED, INK, LINE, PAPER, SERIES, SPECIAL, VALUES, make_figure
from rodgen.show.run_pictures import save_figures
from rodgen.show.study_results import StudyResults, is_logarithmic

if TYPE_CHECKING:
    import xarray

MOST_PICTURES = 12
MOST_PANELS = 16
COLUMNS = 5  # of a scatter matrix, beside what is kept
LEVELS = 8  # lines of a contour
FEW = 200  # points of a curve, up to which they are joined by lines
WIDE = 1e3  # largest over smallest, from which colours go by the logarithm
MANY = 3000  # points of a map beyond which those of a whole grid are not shown
MOST_PERIOD = 8  # different values of a section that are told apart
SAME, OUTSIDE = 1e-3, (0.001, 0.999)  # of the range; what of all values is taken for it


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
    return {
        name: partial(way, *of) for name, way, of in _list_pictures(StudyResults.subsample(dataset))
    }


def _list_pictures(
    of: StudyResults,
) -> Iterator[tuple[str, Callable[..., Figure], tuple[Any, ...]]]:
    """Yield every picture: its name, the function that draws it, and its arguments."""
    if not of.is_sample and len(of.axes) <= 3:
        ways: dict[int, Callable[[StudyResults, str], Figure]] = {
            1: curve_plot,
            2: map_plot,
            3: map_matrix,
        }
        for name in of.kept[:MOST_PICTURES]:
            if of.is_section(name):
                if len(of.axes) < 3 and not name.endswith(".t"):
                    yield name, (bifurcation_plot, period_map)[len(of.axes) - 1], (of, name)
            elif len(of.axes) == 1 or not of.inner_dims(name):
                yield name, ways[len(of.axes)], (of, name)
    else:
        yield "scatter", scatter_matrix, (of,)


def file_name(name: str) -> str:
    """Make a file name of the name of a variable."""
    return re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "picture"


def _set_axis(axes: Axes, of: StudyResults, name: str, which: str) -> None:
    """Set scale, label and ticks of an axis of a picture."""
    values, texts = of.axis_values(name)
    if is_logarithmic(values):
        getattr(axes, f"set_{which}scale")("log")
    getattr(axes, f"set_{which}label")(of.label(name))
    if texts:
        getattr(axes, f"set_{which}ticks")(values, texts)


# One axis -----------------------------------------------------------------------------------------


def curve_plot(of: StudyResults, name: str) -> Figure:
    """Curve of a number over an axis; of several numbers, one each."""
    figure = make_figure(6.0, 4.0)
    axes = figure.add_subplot()
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
    _set_axis(axes, of, of.axes[0], "x")
    if classes:
        axes.set_yticks(range(len(classes)), classes)
    axes.set(ylabel=of.label(name), title=of.title)
    axes.grid(alpha=0.3)
    if columns.shape[1] > 1 or np.isin(of.status, NO_RESULT).any():
        axes.legend(fontsize="small")
    return figure


def _mark_failures(axes: Axes, of: StudyResults, x: NDArray[np.float64]) -> None:
    """Mark points that failed, along the lower edge."""
    lost = x[np.isin(of.status, NO_RESULT)]
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
    figure = make_figure(6.5, 4.5)
    axes = figure.add_subplot()
    x, _ = of.axis_values(of.axes[0])
    values, _ = of.values_of(name)
    points = np.repeat(x[:, None], values.shape[1], axis=1)
    shown = np.isfinite(values)
    size = float(np.clip(3e3 / max(1, shown.sum()), 0.1, 3.0))
    axes.plot(points[shown], values[shown], ".", color=INK, markersize=size, rasterized=True)
    _mark_failures(axes, of, x)
    _set_axis(axes, of, of.axes[0], "x")
    axes.set(ylabel=of.label(name), title=f"{of.title}: bifurcation diagram")
    axes.grid(alpha=0.3)
    return figure


# Two and three ------------------------------------------------------------------------------------


def map_plot(of: StudyResults, name: str) -> Figure:
    """Map of a number over two axes, the first of them upwards."""
    figure = make_figure(6.5, 5.0)
    axes = figure.add_subplot()
    values, classes = of.values_of(name)
    scale = _colour_scale(values, classes)
    _draw_map(axes, of, of.axes, values, of.status, scale, classes, lines=True)
    all_alike = len(classes) == 1 and bool((of.status == FINISHED).all())
    everywhere = f": {classes[0]} everywhere" if all_alike else ""
    axes.set_title(f"{of.title}: {name}{everywhere}")
    _add_legend(figure, axes, of, name, scale, classes)
    return figure


def period_map(of: StudyResults, name: str) -> Figure:
    """Map of how many different values a section has over two axes: one where the motion repeats
    itself from one crossing to the next, two where it does so every other time, and so on."""
    figure = make_figure(6.5, 5.0)
    axes = figure.add_subplot()
    counts = count_distinct(of.values_of(name)[0])
    known = of.status == FINISHED
    classes = ["none", *map(str, range(1, MOST_PERIOD + 1)), "more"]
    values = np.where(known, np.minimum(counts, MOST_PERIOD + 1), np.nan)
    colours = [BED, *colormaps[VALUES](np.linspace(0, 1, MOST_PERIOD)), INK]
    norm = BoundaryNorm(np.arange(len(classes) + 1) - 0.5, len(classes))
    scale = norm, ListedColormap(colours)
    # Lines between whole numbers of no order would say nothing, and hide what is small.
    _draw_map(axes, of, of.axes, values, of.status, scale, (), lines=False)
    axes.set_title(f"{of.title}: different values of\n{name}", fontsize="medium")
    _add_legend(figure, axes, of, name, scale, classes)
    return figure


def count_distinct(values: NDArray[np.float64]) -> NDArray[np.int_]:
    """Count the different values of each point (..., crossings): those apart by more than a
    thousandth of the range of all."""
    found = values[np.isfinite(values)]
    low, high = np.quantile(found, OUTSIDE) if len(found) else (0.0, 0.0)
    least = SAME * (high - low)
    counts = [
        int((np.diff(np.sort(one[np.isfinite(one)])) > least).sum() + np.isfinite(one).any())
        for one in values.reshape(-1, values.shape[-1])
    ]
    return np.array(counts).reshape(values.shape[:-1])


def map_matrix(of: StudyResults, name: str) -> Figure:
    """Maps of a number over three axes: over the two longer ones, for values of the shortest."""
    lengths = dict(zip(of.axes, of.status.shape, strict=True))
    panels_by = min(of.axes, key=lambda axis: lengths[axis])
    at = of.axes.index(panels_by)
    others = tuple(axis for axis in of.axes if axis != panels_by)
    shown = even_indices(0, lengths[panels_by] - 1, MOST_PANELS)
    columns = int(np.ceil(np.sqrt(len(shown))))
    rows = -(-len(shown) // columns)
    figure = make_figure(2.2 * columns + 1.4, 2.0 * rows + 0.8)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    values, classes = of.values_of(name)
    scale = _colour_scale(values, classes)
    beside, texts = of.axis_values(panels_by)
    for number, axes in enumerate(panels.flat):
        if number >= len(shown):
            axes.set_visible(False)
            continue
        here = int(shown[number])
        part, status = (np.take(whole, here, axis=at) for whole in (values, of.status))
        _draw_map(axes, of, others, part, status, scale, classes, lines=False)
        value = texts[here] if texts else f"{beside[here]:.4g}"
        axes.set_title(f"{panels_by.rpartition('.')[2]} = {value}", fontsize="x-small")
        axes.tick_params(labelsize="x-small")
        axes.set(xlabel="", ylabel="")
    figure.supxlabel(of.label(others[1]), fontsize="small")
    figure.supylabel(of.label(others[0]), fontsize="small")
    figure.suptitle(f"{of.title}: {name}", fontsize="medium")
    _add_legend(figure, panels.ravel().tolist(), of, name, scale, classes)
    return figure


def _colour_scale(
    values: NDArray[np.float64], classes: Sequence[str]
) -> tuple[Normalize, Colormap]:
    """Return the norm and the colours of values, or of classes."""
    if classes:
        colours = [SERIES[at % len(SERIES)] for at in range(len(classes))]
        norm = BoundaryNorm(np.arange(len(classes) + 1) - 0.5, len(classes))
        return norm, ListedColormap(colours)
    found = values[np.isfinite(values)]
    low, high = (found.min(), found.max()) if len(found) else (0.0, 1.0)
    if low > 0 and high > WIDE * low:
        return LogNorm(low, high), colormaps[VALUES]
    return Normalize(low, high if high > low else low + 1.0), colormaps[VALUES]


def _draw_map(
    axes: Axes,
    of: StudyResults,
    names: Sequence[str],
    values: NDArray[np.float64],
    status: NDArray[Any],
    scale: tuple[Normalize, Colormap],
    classes: Sequence[str],
    lines: bool,
) -> None:
    """Draw one map."""
    (y, _), (x, _) = (of.axis_values(name) for name in names)
    computed = status != ""
    filled = _fill_nearest(values, computed)
    axes.pcolormesh(
        *(_cell_edges(one) for one in (x, y)),
        np.ma.masked_invalid(filled),
        norm=scale[0],
        cmap=scale[1],
        rasterized=True,
        alpha=0.85 if classes else 1.0,
    )
    if lines and min(values.shape) > 1 and not classes and np.isfinite(filled).sum() > 3:
        locator = LogLocator() if isinstance(scale[0], LogNorm) else None
        drawn = axes.contour(x, y, filled, LEVELS, locator=locator, colors=INK, linewidths=0.5)
        for text in axes.clabel(drawn, fontsize="xx-small", fmt="%.3g"):
            text.set_path_effects([withStroke(linewidth=2.0, foreground=PAPER)])
    elif min(values.shape) > 1 and len(classes) > 1:
        axes.contour(x, y, filled, np.arange(len(classes) - 1) + 0.5, colors=INK, linewidths=0.8)
    X, Y = np.meshgrid(x, y)
    if not computed.all():
        axes.plot(X[computed], Y[computed], ".", color=INK, markersize=1.0, alpha=0.6)
    elif lines and computed.sum() <= MANY:
        axes.plot(X, Y, ".", color=INK, markersize=0.8, alpha=0.35)
    lost = np.isin(status, NO_RESULT)
    size = float(np.clip(100 / np.sqrt(max(1, status.size)), 1.5, 4.0))
    axes.plot(X[lost], Y[lost], "x", color=SPECIAL, markersize=size)
    _set_axis(axes, of, names[1], "x")
    _set_axis(axes, of, names[0], "y")


def _fill_nearest(values: NDArray[np.float64], computed: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Set points that are not computed to the value of the nearest computed one."""
    if computed.all() or not computed.any():
        return values
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~computed, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(nearest)])


def _cell_edges(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the borders between cells around values."""
    if len(values) < 2:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    logs = is_logarithmic(values)
    at = np.log(values) if logs else values
    middle = (at[1:] + at[:-1]) / 2
    made = np.concatenate(([2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]))
    return np.exp(made) if logs else made


def _add_legend(
    figure: Figure,
    axes: Any,
    of: StudyResults,
    name: str,
    scale: tuple[Normalize, Colormap],
    classes: Sequence[str],
) -> None:
    """Add a legend of colours and marks, or a colour bar."""
    handles = [
        Line2D([], [], marker="s", linestyle="", color=scale[1](at), label=one)
        for at, one in enumerate(classes)
    ]
    if np.isin(of.status, NO_RESULT).any():
        handles.append(Line2D([], [], marker="x", linestyle="", color=SPECIAL, label="failed"))
    if (of.status == "").any():
        handles.append(Line2D([], [], marker=".", linestyle="", color=INK, label="computed points"))
    if not classes:
        figure.colorbar(ScalarMappable(*scale), ax=axes, label=of.label(name))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize="small")


# Samples ------------------------------------------------------------------------------------------


def scatter_matrix(of: StudyResults) -> Figure:
    """Scatter matrix: every number over every other, histograms on the diagonal."""
    columns = [*_scatter_columns(of)]
    lost = np.isin(of.status, NO_RESULT).ravel()
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


def _scatter_columns(of: StudyResults) -> Iterator[tuple[str, NDArray[np.float64], bool]]:
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
