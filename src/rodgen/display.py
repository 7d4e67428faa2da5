"""Interface by which scenes and results are drawn: `plot`, and HTML in notebooks.

The drawing modules join through the entry points of GROUP, since they lie above this one and know
all that is drawn: rodgen.show. They are loaded when a picture is asked for, not before.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure


GROUP = "rodgen.pictures"


class VideoData(Protocol):
    """A film in memory. data: as in a file; ending: of such a file, ".mp4" or ".gif"."""

    data: bytes
    ending: str

    def save(self, path: str | Path) -> None:
        """Write it to a file with its ending. Raises InputError for another ending."""


@cache
def load_drawing_module(of: str) -> ModuleType:
    """Load the drawing module of a name. Raises ImportError where there is none."""
    for entry in entry_points(group=GROUP, name=of):
        module: ModuleType = entry.load()
        return module
    raise ImportError(
        f"nothing draws {of}: rodgen was installed before it had the entry points {GROUP!r}; "
        "install it again (in a clone: make, or pip install --editable .)"
    )


def result_drawing() -> ModuleType:
    """The module that draws scenes and results."""
    return load_drawing_module("results")


def dataset_drawing() -> ModuleType:
    """The module that draws Datasets."""
    return load_drawing_module("datasets")


class Tabular:
    """A result with a table of its numbers for notebooks."""

    def _repr_html_(self) -> str:
        """HTML of its table, with its picture where there is one."""
        html: str = result_drawing().html(self)
        return html


class Plottable(Tabular):
    """A result or a scene that can be drawn."""

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it with matplotlib. Returns the axes, the first of them if there are several.

        picture: name of the picture, by default the first; figure: the figure in which it is drawn,
        by default a new one of pyplot.

        InputError lists the names if there is no such picture.
        """
        axes: Axes = result_drawing().plot(self, picture, figure)
        return axes
