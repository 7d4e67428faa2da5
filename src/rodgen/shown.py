"""What shows itself: pictures by `plot`, and in notebooks a picture with a table.

Pictures are drawn by what joins through the entry points of GROUP, which knows everything that is
drawn here and lies above it: rodgen.show. It is looked up when a picture is asked for, not before.
"""

from __future__ import annotations

import sys
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import xarray
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


class DatasetPictures:
    """What xarray's Datasets of branches, boundaries and studies have as `data.rodgen`."""

    def __init__(self, data: xarray.Dataset):
        self._data = data

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it with matplotlib. Returns the axes, the first of them if there are several.

        picture: name of the picture, by default the first; the pictures of a study have the names
        of what it has kept; figure: the figure in which it is drawn, by default a new one of
        pyplot.

        InputError lists the names if there is no such picture, and refuses other Datasets.
        """
        axes: Axes = dataset_appearance().plot(self._data, picture, figure)
        return axes

    def __repr__(self) -> str:
        """What the Dataset is, in a line."""
        line: str = dataset_appearance().line(self._data)
        return line

    def _repr_html_(self) -> str:
        return _dataset_html(self._data)


def _dataset_html(data: xarray.Dataset) -> str:
    """A picture with a table; of a Dataset that rodgen did not make, what xarray shows."""
    html: str = dataset_appearance().html(data)
    return html


@cache
def show_datasets() -> None:
    """Have xarray's Datasets the accessor `rodgen`, and those of rodgen show themselves in
    notebooks; what makes or reads them calls it."""
    import xarray  # only where it is there already: it takes long to import

    register: Any = xarray.register_dataset_accessor  # which has no types
    register("rodgen")(DatasetPictures)
    show_in_notebook(xarray.Dataset)


def show_in_notebook(dataset: type) -> None:
    """Where this is a notebook, have it show Datasets with picture and table."""
    notebook = sys.modules.get("IPython")
    shell: Any = notebook and notebook.get_ipython()
    if shell:
        shell.display_formatter.formatters["text/html"].for_type(dataset, _dataset_html)


class Told:
    """A result with a table of its numbers for notebooks."""

    def _repr_html_(self) -> str:
        """A table, with a picture where there is one."""
        html: str = appearance().html(self)
        return html


class Shown(Told):
    """A result or a scene that can be drawn."""

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it with matplotlib. Returns the axes, the first of them if there are several.

        picture: name of the picture, by default the first; figure: the figure in which it is drawn,
        by default a new one of pyplot.

        InputError lists the names if there is no such picture.
        """
        axes: Axes = appearance().plot(self, picture, figure)
        return axes
