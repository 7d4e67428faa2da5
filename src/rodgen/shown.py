"""What shows itself: pictures by `plot`, and in notebooks a picture with a table.

Pictures are drawn in rodgen.show, which knows everything that is drawn here and lies above it: it
is looked up by its name, when a picture is asked for and not before.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure


class Video(Protocol):
    """A film in memory: data as in a file; ending: of such a file, ".mp4" or ".gif"."""

    data: bytes
    ending: str

    def save(self, path: str | Path) -> None:
        """Write it to a file with its ending. Raises SceneError for another ending."""


def appearance() -> ModuleType:
    """The module that draws."""
    return import_module("rodgen.show.appearance")


class DatasetPictures:
    """What xarray's Datasets of branches, boundaries and studies have as `data.rodgen`."""

    def __init__(self, data: xarray.Dataset):
        self._data = data

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it as `Shown.plot` does; the pictures of a study are called as what it has kept.
        Raises SceneError also for a Dataset that is none of rodgen's."""
        axes: Axes = appearance().plot_dataset(self._data, picture, figure)
        return axes


@cache
def show_datasets() -> None:
    """Have xarray's Datasets the accessor `rodgen`; what makes or reads them calls it."""
    import xarray  # only where it is there already: it takes long to import

    register: Any = xarray.register_dataset_accessor  # which has no types
    register("rodgen")(DatasetPictures)


class Told:
    """A result with a table of its numbers for notebooks."""

    def _repr_html_(self) -> str:
        """A table, with a picture where there is one."""
        html: str = appearance().html(self)
        return html


class Shown(Told):
    """A result or a scene that can be drawn."""

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it with matplotlib; returns the axes, the first where a picture has several.

        picture: which one, by name, by default the first; a name that there is not is refused with
        those that there are (SceneError). figure: in which it is drawn, one of pyplot's own if not
        given, which notebooks show.
        """
        axes: Axes = appearance().plot(self, picture, figure)
        return axes
