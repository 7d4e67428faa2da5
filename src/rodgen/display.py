"""What shows itself: pictures by `plot`, and in notebooks a picture with a table.

Pictures are drawn by what joins through the entry points of GROUP, which knows everything that is
drawn here and lies above it: rodgen.show. It is looked up when a picture is asked for, not before.
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


class Video(Protocol):
    """A film in memory: data as in a file; ending: of such a file, ".mp4" or ".gif"."""

    data: bytes
    ending: str

    def save(self, path: str | Path) -> None:
        """Write it to a file with its ending. Raises InputError for another ending."""


@cache
def drawer(of: str) -> ModuleType:
    """Return the module that joins under a name. Raises ImportError where none does."""
    for entry in entry_points(group=GROUP, name=of):
        module: ModuleType = entry.load()
        return module
    raise ImportError(
        f"nothing draws {of}: rodgen was installed before it had the entry points {GROUP!r}; "
        "install it again (in a clone: make, or pip install --editable .)"
    )


def appearance() -> ModuleType:
    """The module that draws scenes and results."""
    return drawer("results")


def dataset_appearance() -> ModuleType:
    """The module that draws Datasets."""
    return drawer("datasets")


class Tabular:
    """A result with a table of its numbers for notebooks."""

    def _repr_html_(self) -> str:
        """A table, with a picture where there is one."""
        html: str = appearance().html(self)
        return html


class Plottable(Tabular):
    """A result or a scene that can be drawn."""

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it with matplotlib. Returns the axes, the first of them if there are several.

        picture: name of the picture, by default the first; figure: the figure in which it is drawn,
        by default a new one of pyplot.

        InputError lists the names if there is no such picture.
        """
        axes: Axes = appearance().plot(self, picture, figure)
        return axes
