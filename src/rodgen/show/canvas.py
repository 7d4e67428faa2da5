"""What pictures are drawn upon, and in which colours."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, cast

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure

from rodgen.model.palette import shades

LINE = 1.2  # points
SERIES = shades("series")
(FAINT,) = shades("faint")


def canvas(width: float, height: float) -> Figure:
    """A figure of this size [inches], without a window; within `drawing`, that which was given."""
    given = _given.get()
    if not callable(given):
        return cast(Figure, given)  # of a part of a figure there is all that pictures ask for
    return given(figsize=(width, height), layout="constrained")


def without_window(**how: Any) -> Figure:
    """A figure that is only written to files."""
    figure = Figure(**how)
    FigureCanvasAgg(figure)
    return figure


_given: ContextVar[Figure | SubFigure | Callable[..., Figure]] = ContextVar(
    "given", default=without_window
)


@contextmanager
def drawing(given: Figure | SubFigure | Callable[..., Figure]) -> Iterator[None]:
    """Pictures made inside are drawn in this figure, or in what this makes of a size."""
    token = _given.set(given)
    try:
        yield
    finally:
        _given.reset(token)


def fit(figure: Figure, height: float) -> None:
    """Give a figure another height [inches], unless somebody else has chosen its size."""
    if callable(_given.get()):
        figure.set_figheight(height)
