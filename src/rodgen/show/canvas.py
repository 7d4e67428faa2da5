"""Figures for pictures: their colours, axes, titles, legends, and how much a width has room for."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, cast

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import FuncNorm, LinearSegmentedColormap
from matplotlib.figure import Figure, SubFigure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator, NullFormatter
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.model.palette import LIGHT, colours_of

LINE = 1.2  # points
SERIES = colours_of("series")
CURVE, *_ = SERIES  # of a curve that is alone
# Text and axes; notes; what other things are seen beside; the rod, its bodies, its fixed points and
# its bed; its tail and its centre of gravity; what is special: points, failures.
INK, FAINT, GUIDE, ROD, BODY, FIXED, BED, TAIL, CENTRE, SPECIAL = (
    str(LIGHT[name])
    for name in ["ink", "faint", "axis", "link", "body", "joint", "line", "tail", "centre", "kick"]
)
EDGE, PAPER, GRID = (str(LIGHT[name]) for name in ["edge", "background", "grid"])
STEPS = 65  # of the colours below: few enough for a GIF, and one of them is the middle
# Blue below zero, red above, as the live view has it; and one that says which comes before which.
MOMENTS, ALONG = (
    LinearSegmentedColormap.from_list(name, colours_of(name), N=STEPS)
    for name in ("moments", "along")
)
# Of words over curves.
BEHIND = {"boxstyle": "square,pad=0.1", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8}
VALUES = "viridis"  # of maps, which are filled
SLIVER = 0.05  # width over length
TICKS_PER_INCH, MOST_TICKS = 1.8, 9  # of an abscissa: more would touch each other
# Of the size of the font: of a letter, of a line, and of what stands beside a name in a legend.
WIDTH_OF_LETTER, HEIGHT_OF_LINE, BESIDE_NAME = 0.53, 1.6, 4.0
BESIDE, BELOW = 0.9, 1.0  # inches beside axes, and above and below them, for labels and a title
NARROWEST, HIGHEST = 0.75, 4.0  # inches: of small axes in a strip
UPRIGHT = 0.7  # of the height of a row: room for the label of an ordinate
ROOMY = 5.0  # inches: of a figure that has room for two axes beside each other
LOG_RATIO = 1e3  # largest over least value, from which axes and colours go by the logarithm


def moment_norm(limit: float) -> FuncNorm:
    """Root law of the colours of bending moments from -limit to limit [N m]: it shows small ones
    beside large ones."""
    laws = (lambda m: np.sign(m) * np.sqrt(np.abs(m)), lambda c: c * np.abs(c))
    return FuncNorm(laws, -limit, limit)


def make_figure(width: float, height: float) -> Figure:
    """Make a figure of this size [inches], without a window; inside `draw_into`, as it was
    given."""
    given = _given.get()
    if not callable(given):
        return cast(Figure, given)  # of a part of a figure there is all that pictures ask for
    return given(figsize=(width, height), layout="constrained")


def make_axes(
    width: float, height: float, rows: int = 1, **layout: Any
) -> tuple[Figure, list[Axes]]:
    """Make a figure of this size [inches] with axes one above the other, each with a pale grid;
    layout: options of Figure.subplots."""
    figure = make_figure(width, height)
    panels = make_panels(figure, rows, 1, **layout)
    return figure, panels.ravel().tolist()


def make_pair(width: float, height: float) -> tuple[Figure, list[Axes]]:
    """Make a figure of this size [inches] with two axes that have abscissae of their own: beside
    each other, or one above the other where there is no room."""
    figure = make_figure(width, height)
    if width_of(figure) >= ROOMY:
        return figure, make_panels(figure, 1, 2).ravel().tolist()
    set_height(figure, width_of(figure))
    return figure, make_panels(figure, 2, 1).ravel().tolist()


def make_panels(figure: Figure, rows: int, columns: int, **layout: Any) -> NDArray[Any]:
    """Make axes (rows, columns) with pale grids, and as many ticks as there is room for; layout:
    options of Figure.subplots."""
    panels: NDArray[Any] = figure.subplots(rows, columns, squeeze=False, **layout)
    for axes in panels.flat:
        axes.grid(color=GRID)
        _set_ticks(axes, (width_of(figure) - BESIDE) / columns)
    return panels


def _set_ticks(axes: Axes, across: float) -> None:
    """Give an abscissa as many ticks as there is room for; across: width of the axes [inches]."""
    most = int(np.clip(TICKS_PER_INCH * across, 2, MOST_TICKS))
    axes.xaxis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))
    if across < NARROWEST:
        axes.tick_params("x", labelrotation=90)


def make_strip(width: float, count: int, columns: int, slope: float) -> tuple[Figure, list[Axes]]:
    """Make a figure of this width [inches] with many small axes of the same limits, in at most so
    many columns as it has room for; slope: of the axes, height over width."""
    figure = make_figure(width, width)
    room = width_of(figure) - BESIDE
    columns = min(columns, max(int(room / NARROWEST), 1))
    rows = -(-count // columns)
    high = float(np.clip(slope * room / columns, 0.4, min(HIGHEST, 1.5 * room / rows)))
    set_height(figure, rows * (high + 0.4) + BELOW)
    panels = make_panels(figure, rows, columns, sharex=True, sharey=True).ravel().tolist()
    for axes in panels[:count]:
        _set_ticks(axes, min(room / columns, high / slope))
    for axes in panels[count:]:
        axes.set_visible(False)
        above = panels[panels.index(axes) - columns]
        above.tick_params("x", labelbottom=True)
    return figure, panels[:count]


def leave_empty(axes: Axes, words: str) -> None:
    """Write into axes why nothing is drawn in them, instead of numbers on an ordinate."""
    axes.text(0.5, 0.5, words, ha="center", va="center", transform=axes.transAxes)
    axes.set_yticks([])


def line_or_dot(values: Array) -> str:
    """Return the style of a curve: a line, or a dot where there is one point of it at most."""
    return "-" if np.isfinite(values).sum() > 1 else "o"


def label_strip(figure: Figure, x: str, y: str, remarks: str = "") -> None:
    """Label the axes of a strip together, with remarks below."""
    figure.supxlabel("\n".join(filter(None, (x, break_lines(remarks, width_of(figure))))))
    figure.supylabel(y)


def width_of(figure: Figure | SubFigure) -> float:
    """Width of a figure, or of a part of one [inches]."""
    return float(figure.bbox.width / figure.dpi)


def height_of(figure: Figure | SubFigure) -> float:
    """Height of a figure, or of a part of one [inches]."""
    return float(figure.bbox.height / figure.dpi)


def set_height(figure: Figure, height: float) -> None:
    """Make a figure this high [inches], unless somebody else has chosen its size."""
    if callable(_given.get()):
        figure.set_figheight(height)


def add_lines(figure: Figure, lines: int) -> None:
    """Make a figure higher by so many lines of text."""
    set_height(figure, height_of(figure) + lines * letter_size()[1])


def set_title(figure: Figure, words: str) -> None:
    """Give a figure a title, in as many lines as it takes."""
    figure.suptitle(break_lines(words, width_of(figure)))


def break_lines(words: str, room: float) -> str:
    """Break words into lines that fit a room [inches]; numbers stay with their units."""
    letters = int(room / letter_size()[0])
    together = re.sub(r"(\d) (?=\S{1,3}(?:\s|[,;]|$))", "\\1\u00a0", words)
    return "\n".join(textwrap.wrap(together, max(letters, 8)))


def letter_size() -> tuple[float, float]:
    """Width of a letter and height of a line [inches]."""
    size = rcParams["font.size"] / 72
    return WIDTH_OF_LETTER * size, HEIGHT_OF_LINE * size


def label_ordinate(axes: Axes, words: str, rows: int = 1) -> None:
    """Label the ordinate of one of so many rows of axes, in as many lines as it takes."""
    figure = cast(Figure, axes.figure)
    axes.set_ylabel(break_lines(words, UPRIGHT * height_of(figure) / rows))


def figure_without_window(**how: Any) -> Figure:
    """Make a figure that is only written to files."""
    figure = Figure(**how)
    FigureCanvasAgg(figure)
    return figure


_given: ContextVar[Figure | SubFigure | Callable[..., Figure]] = ContextVar(
    "given", default=figure_without_window
)


@contextmanager
def draw_into(given: Figure | SubFigure | Callable[..., Figure]) -> Iterator[None]:
    """Draw the pictures made inside the block in this figure, or in what this function makes."""
    token = _given.set(given)
    try:
        yield
    finally:
        _given.reset(token)


def add_legend(figure: Figure, handles: Sequence[Artist] | None = None) -> None:
    """Add a legend below all axes, in as many columns as its names leave room for, and make the
    figure higher by its lines; handles: its entries, by default those of the axes."""
    if handles is None:
        handles = [one for axes in figure.axes for one in axes.get_legend_handles_labels()[0]]
    if not handles:
        return
    beside = BESIDE_NAME * rcParams["font.size"] / 72
    labels = [break_lines(str(one.get_label()), width_of(figure) - beside) for one in handles]
    longest = max(len(line) for label in labels for line in label.split("\n"))
    across = letter_size()[0] * longest + beside
    columns = min(max(int(width_of(figure) / across), 1), len(handles))
    add_lines(figure, -(-sum(label.count("\n") + 1 for label in labels) // columns))
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)


def _fit_height(figure: Figure, axes: Axes, slope: float) -> None:
    """Make a figure no higher than axes ask for that are as wide as it is and slope times as high,
    unless somebody else has chosen its size."""
    wide, high = width_of(figure) - BESIDE, height_of(figure) - BELOW
    if slope * wide < high:
        set_height(figure, slope * wide + BELOW)
    _set_ticks(axes, min(wide, high / slope))


def show_decades(axes: Axes, values: Array) -> None:
    """Set the limits of a logarithmic ordinate to the powers of ten around all values: numbers
    stand at these alone, as others have no room in a low panel."""
    low, high = np.floor(np.log10([np.nanmin(values), np.nanmax(values)]))
    axes.set_ylim(10.0 ** max(low, -300.0), 10.0 ** (high + 1))
    axes.yaxis.set_minor_formatter(NullFormatter())


def scales_of(axes: Axes) -> Array:
    """Estimate how large units of the coordinates are drawn (2,) [inches] between the limits that
    axes have now, with the colour bars that there are."""
    figure, grid = cast(Figure, axes.figure), cast(SubplotSpec, axes.get_subplotspec())
    rows, columns = grid.get_gridspec().get_geometry()
    beside = BESIDE * (1 + len(figure.axes) - rows * columns)
    room = (width_of(figure) - beside) / columns, (height_of(figure) - BELOW) / rows
    x, y = np.array(room) / [np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())]
    aspect = axes.get_aspect()
    if isinstance(aspect, float):
        x = min(x, y / aspect)
        y = aspect * x
    return np.array([x, y])


def set_limits(axes: Axes, points: Array, stretch: Array | None = None) -> None:
    """Set limits that show all points (..., 2), in equal scales unless the picture would be a
    sliver in which nothing is seen; stretch (2,): times as large as the other that each coordinate
    is drawn."""
    flat = points.reshape(-1, 2) * (1.0 if stretch is None else stretch)
    low, high = flat.min(axis=0), flat.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    equal = half.min() > SLIVER * half.max() or half.min() < 1e-9 * half.max()
    equal |= stretch is not None
    least = half.max() * 0.4 if equal else 0.0
    half = 1.05 * np.maximum(half, max(least, 1e-9))
    x, y = np.ones(2) if stretch is None else stretch
    axes.set_xlim((middle[0] - half[0]) / x, (middle[0] + half[0]) / x)
    axes.set_ylim((middle[1] - half[1]) / y, (middle[1] + half[1]) / y)
    if equal:
        axes.set_aspect(y / x)
        _fit_height(cast(Figure, axes.figure), axes, half[1] / half[0])
    else:
        add_remark(axes, "scales of x and y differ")


def add_figure_remark(figure: Figure, words: str) -> None:
    """Add words about all axes of a figure below them, and make it higher by their lines."""
    broken = break_lines(words, width_of(figure))
    figure.supxlabel("\n".join(filter(None, (figure.get_supxlabel(), broken))))
    add_lines(figure, 1 + broken.count("\n"))


def add_remark(axes: Axes, words: str) -> None:
    """Add words about a picture to the lines below its abscissa's label."""
    label, _, remarks = axes.get_xlabel().partition("\n")
    said = "; ".join(filter(None, (remarks.replace("\n", " "), words)))
    axes.set_xlabel(f"{label}\n{break_lines(said, width_of(cast(Figure, axes.figure)) - BESIDE)}")
