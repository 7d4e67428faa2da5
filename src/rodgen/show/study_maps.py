"""Maps of what a study has kept over two axes, and matrices of them over three."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import (
    BoundaryNorm,
    CenteredNorm,
    Colormap,
    ListedColormap,
    LogNorm,
    Normalize,
    to_rgb,
)
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray

from rodgen.arrays import Array, even_indices
from rodgen.integrate.stepper import FINISHED, NO_RESULT
from rodgen.show.canvas import (
    BED,
    INK,
    LOG_RATIO,
    MOMENTS,
    SERIES,
    SPECIAL,
    VALUES,
    add_legend,
    add_remark,
    label_strip,
    make_axes,
    make_strip,
    set_title,
)
from rodgen.show.study_results import StudyResults, is_logarithmic

MOST_PANELS = 16
LEVELS = 8  # lines of a contour
MANY = 3000  # points of a map beyond which those of a whole grid are not shown
MOST_PERIOD = 8  # different values of a section that are told apart
SAME_VALUE, OUTSIDE = 1e-3, (0.001, 0.999)  # of the range; what of all values is taken for it


PALE = 0.5  # part of a colour in the areas of classes, whose names are in them; the rest is white
AROUND = 0.1  # of the shorter side of a map, around a name in its area


class Colours(NamedTuple):
    """Colours of numbers, or of classes where there are any."""

    norm: Normalize
    map: Colormap
    classes: Sequence[str] = ()


def map_plot(of: StudyResults, name: str) -> Figure:
    """Map of a number over two axes, the first of them upwards."""
    figure, (axes,) = make_axes(6.5, 5.0)
    values, classes = of.values_of(name)
    colours = _choose_colours(values, classes)
    named = _draw_map(axes, of, of.axes, values, of.status, colours, lines=True)
    if classes:
        add_remark(axes, of.words(name))
    set_title(figure, f"{of.title}: {of.words(name)}")
    _add_legend(figure, axes, of, name, colours, named)
    return figure


def period_map(of: StudyResults, name: str) -> Figure:
    """Map of how many different values a section has over two axes: one where the motion repeats
    itself from one crossing to the next, two where it does so every other time, and so on."""
    figure, (axes,) = make_axes(6.5, 5.0)
    counts = np.minimum(count_distinct(of.values_of(name)[0]), MOST_PERIOD + 1)
    values = np.where(of.status == FINISHED, counts, np.nan)
    shades = [BED, *colormaps[VALUES](np.linspace(0, 1, MOST_PERIOD)), INK]
    colours = _class_colours(["none", *map(str, range(1, MOST_PERIOD + 1)), "more"], shades)
    # Lines between whole numbers of no order would say nothing, and hide what is small.
    _draw_map(axes, of, of.axes, values, of.status, colours._replace(classes=()), lines=False)
    add_remark(axes, f"how many different values: {of.words(name)}")
    set_title(figure, f"{of.title}: {of.words(name)}")
    _add_legend(figure, axes, of, name, colours)
    return figure


def count_distinct(values: Array) -> NDArray[np.int_]:
    """Count the different values of each point (..., crossings): those apart by more than a
    thousandth of the range of all."""
    known = np.isfinite(values)
    low, high = np.quantile(values[known], OUTSIDE) if known.any() else (0.0, 0.0)
    apart = np.diff(np.sort(np.where(known, values, np.nan), axis=-1)) > SAME_VALUE * (high - low)
    counts: NDArray[np.int_] = apart.sum(axis=-1) + known.any(axis=-1)
    return counts


def map_matrix(of: StudyResults, name: str) -> Figure:
    """Maps of a number over three axes: over the two longer ones, for values of the shortest."""
    at = int(np.argmin(of.status.shape))
    panels_by, others = of.axes[at], of.axes[:at] + of.axes[at + 1 :]
    shown = even_indices(0, of.status.shape[at] - 1, MOST_PANELS)
    columns = int(np.ceil(np.sqrt(len(shown))))
    figure, panels = make_strip(2.2 * columns + 1.4, len(shown), columns, 0.8)
    values, classes = of.values_of(name)
    colours = _choose_colours(values, classes)
    beside, texts = of.axis_values(panels_by)
    for axes, here in zip(panels, shown.tolist(), strict=True):
        part, status = (np.take(whole, here, axis=at) for whole in (values, of.status))
        _draw_map(axes, of, others, part, status, colours, lines=False)
        value = texts[here] if texts else f"{beside[here]:.4g}"
        axes.set_title(f"{of.words(panels_by)} = {value}")
        axes.set(xlabel="", ylabel="")
    label_strip(figure, of.label(others[1]), of.label(others[0]), of.words(name) * bool(classes))
    set_title(figure, f"{of.title}: {of.words(name)}")
    _add_legend(figure, panels, of, name, colours)
    return figure


def _class_colours(classes: Sequence[str], shades: Sequence[Any]) -> Colours:
    """Return the colours of classes that are numbered from 0."""
    edges = np.arange(len(classes) + 1) - 0.5
    return Colours(BoundaryNorm(edges, len(classes)), ListedColormap(shades), classes)


def _choose_colours(values: Array, classes: Sequence[str]) -> Colours:
    """Choose the colours of values, or of classes."""
    if classes:
        shades = [PALE * np.array(to_rgb(one)) + 1 - PALE for one in SERIES]
        return _class_colours(classes, [shades[at % len(shades)] for at in range(len(classes))])
    found = values[np.isfinite(values)]
    low, high = (found.min(), found.max()) if len(found) else (0.0, 1.0)
    if low > 0 and high > LOG_RATIO * low:
        return Colours(LogNorm(low, high), colormaps[VALUES])
    if low < 0 < high:  # what grows and what dies away have colours of their own
        return Colours(CenteredNorm(halfrange=max(-low, high)), MOMENTS)
    return Colours(Normalize(low, high if high > low else low + 1.0), colormaps[VALUES])


def _draw_map(
    axes: Axes,
    of: StudyResults,
    names: Sequence[str],
    values: Array,
    status: NDArray[Any],
    colours: Colours,
    lines: bool,
) -> list[int]:
    """Draw one map; lines: of equal values, between numbers. Returns the classes that have their
    names in it."""
    (y, _), (x, _) = (of.axis_values(name) for name in names)
    computed, classes = status != "", colours.classes
    filled = _fill_nearest(values, computed)
    axes.pcolormesh(
        _cell_edges(x),
        _cell_edges(y),
        np.ma.masked_invalid(filled),
        norm=colours.norm,
        cmap=colours.map,
        rasterized=True,
    )
    if lines and min(values.shape) > 1 and not classes and np.isfinite(filled).sum() > 3:
        locator = LogLocator() if isinstance(colours.norm, LogNorm) else None
        axes.contour(x, y, filled, LEVELS, locator=locator, colors=INK, linewidths=0.5)
    named = _name_areas(axes, x, y, filled, classes) if lines else []
    if min(values.shape) > 1 and len(classes) > 1:
        axes.contour(x, y, filled, np.arange(len(classes) - 1) + 0.5, colors=INK, linewidths=0.8)
    X, Y = np.meshgrid(x, y)
    if not computed.all():
        axes.plot(X[computed], Y[computed], ".", color=INK, markersize=1.0, alpha=0.6)
    elif lines and computed.sum() <= MANY:
        axes.plot(X, Y, ".", color=INK, markersize=0.8, alpha=0.35)
    lost = np.isin(status, NO_RESULT)
    size = float(np.clip(100 / np.sqrt(max(1, status.size)), 1.5, 4.0))
    axes.plot(X[lost], Y[lost], "x", color=SPECIAL, markersize=size)
    of.set_axis(axes, names[1], "x")
    of.set_axis(axes, names[0], "y")
    return named


def _name_areas(axes: Axes, x: Array, y: Array, values: Array, classes: Sequence[str]) -> list[int]:
    """Write the names of classes into their areas, where these have room. Returns the classes."""
    from scipy.ndimage import distance_transform_edt

    named = []
    for at, name in enumerate(classes):
        inside = distance_transform_edt(np.pad(values == at, 1))[1:-1, 1:-1]
        row, column = np.unravel_index(int(inside.argmax()), inside.shape)
        if inside[row, column] > AROUND * min(inside.shape):
            axes.text(x[column], y[row], name, ha="center", va="center")
            named.append(at)
    return named


def _fill_nearest(values: Array, computed: NDArray[np.bool_]) -> Array:
    """Set points that are not computed to the value of the nearest computed one."""
    if computed.all() or not computed.any():
        return values
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~computed, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(nearest)])


def _cell_edges(values: Array) -> Array:
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
    colours: Colours,
    named: Collection[int] = (),
) -> None:
    """Add a legend of marks and of colours but those of named classes, or a colour bar."""
    handles = [
        Line2D([], [], marker="s", linestyle="", color=colours.map(at), label=one)
        for at, one in enumerate(colours.classes)
        if at not in named
    ]
    if of.failures.any():
        handles.append(Line2D([], [], marker="x", linestyle="", color=SPECIAL, label="failed"))
    if (of.status == "").any():
        handles.append(Line2D([], [], marker=".", linestyle="", color=INK, label="computed points"))
    if not colours.classes:
        shades = ScalarMappable(colours.norm, colours.map)
        bar = figure.colorbar(shades, ax=axes, label=of.label(name))
        for lines in getattr(axes, "collections", ()):  # their values are on the bar
            if isinstance(lines, ContourSet):
                bar.add_lines(lines)
    if handles:
        add_legend(figure, handles)
