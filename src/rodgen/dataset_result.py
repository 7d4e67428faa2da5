"""Accessor `rodgen` of xarray's Datasets of branches, boundaries and studies: pictures, notes and
plain data, as other results have them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from rodgen.display import dataset_drawing
from rodgen.result import NOTES, REMARK, Note, Result, ResultTable, Row, notes_from, plain_data

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

POINT, SPECIAL = "point", "special"  # dimensions of a curve
PREFIX = f"{SPECIAL}_"  # of variables along the second
DOUBTS, DIGEST = "doubts", "digest"  # a variable and an attribute of a study
LONG_NAME, UNITS, UNKNOWN = "long_name", "units", "unknown"  # attributes of a variable


class DatasetResult(Result):
    """Accessor `data.rodgen` of the Datasets of branches, boundaries and studies.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("euler_column")
    >>> branch = rodgen.continue_equilibria(scene, "loads.tip.y", bounds=(0, -30))
    >>> [one["kind"] for one in branch.rodgen.to_dict()["special"]], branch.rodgen.notes
    (['branch'], ())
    """

    def __init__(self, data: xarray.Dataset):
        self._data = data

    @property
    def notes(self) -> tuple[Note, ...]:  # type: ignore[override]  # a field of other results
        """Notes on the numbers: doubts and remarks."""
        if NOTES in self._data.attrs:
            return notes_from(self._data.attrs)
        if DOUBTS not in self._data or DIGEST not in self._data.attrs:
            return ()
        counts = self._data[DOUBTS].values
        return doubt_remark(int((counts > 0).sum()), int((counts >= 0).sum()))

    def to_dict(self) -> dict[str, Any]:
        """Convert variables, attributes and notes to plain data for JSON. A curve has a list of its
        points and one of its special points; others have a list for every variable."""
        data = self._data
        values = {str(name): known_or_none(one) for name, one in data.variables.items()}
        made = _curve_records(data, values) if {POINT, SPECIAL} <= set(data.dims) else values
        said = {
            str(name): bool(one) if name in FLAGS else plain_data(one)
            for name, one in data.attrs.items()
            if name not in OWN
        }
        return made | said | {NOTES: [note.to_dict() for note in self.notes]}

    def plot(self, picture: str | None = None, *, figure: Figure | SubFigure | None = None) -> Axes:
        """Draw it with matplotlib. Returns the axes, the first of them if there are several.

        picture: name of the picture, by default the first; the pictures of a study have the names
        of what it has kept; figure: the figure in which it is drawn, by default a new one of
        pyplot.

        InputError lists the names if there is no such picture, and refuses other Datasets.
        """
        axes: Axes = dataset_drawing().plot(self._data, picture, figure)
        return axes

    def __repr__(self) -> str:
        """One line that says what the Dataset holds."""
        line: str = dataset_drawing().describe(self._data)
        return line

    def tables(self) -> list[ResultTable]:
        """Tables of its numbers, as text."""
        found: list[ResultTable] = dataset_drawing().tables(self._data)
        return found

    def _repr_html_(self) -> str:
        return _dataset_html(self._data)


def doubt_remark(count: int, of: int) -> tuple[Note, ...]:
    """Remark that `count` of the `of` points of a study have doubts; empty if none has."""
    if not count:
        return ()
    return (Note(REMARK, f"{count} of {of} points have doubts: see {DOUBTS}", {"points": count}),)


# Attributes left out of the plain data: they tell how to read a file, or stand there already.
OWN = {
    *("format", "rodgen", "scene", NOTES, "variables", "vary", "sample", "options", "time_limit"),
    *("token", DIGEST, "sources", "coordinates", "keep"),
}
FLAGS = {"complete", "moving", "damped", "supercritical"}  # which NetCDF has as numbers


def dataset_variables(
    rows: Iterable[Row],
    values: Mapping[str, Any],
    dims: Mapping[str, tuple[str, ...]],
    **names: str,
) -> dict[str, tuple[Any, Any, dict[str, Any]]]:
    """Variables of a Dataset, with the words and units of their rows as attributes.

    values: arrays by the names of rows; dims: further dimensions of a row, after the one it runs
    along; names: texts for the placeholders in the words of rows.
    """
    return {
        row.name: (
            (row.along, *dims.get(row.name, ())),
            values[row.name],
            _row_attributes(row, names),
        )
        for row in rows
        if row.name in values
    }


def _row_attributes(row: Row, names: Mapping[str, str]) -> dict[str, Any]:
    found = {LONG_NAME: row.words.format(**names), UNITS: row.unit, UNKNOWN: row.unknown}
    return {name: value for name, value in found.items() if value not in ("", None)}


def known_or_none(variable: xarray.Variable) -> Any:
    """Values of a variable as plain data, with None for those that are not known."""
    unknown = variable.attrs.get(UNKNOWN)
    if unknown is None:
        return plain_data(variable.values)
    values = variable.values.astype(object)
    values[variable.values == unknown] = None
    return plain_data(values)


def _curve_records(data: xarray.Dataset, values: Mapping[str, Any]) -> dict[str, Any]:
    """Points and special points of a curve, each as a dictionary of its values."""
    made: dict[str, Any] = {}
    for along, key, start in ((POINT, "points", ""), (SPECIAL, SPECIAL, PREFIX)):
        names = [name for name, one in data.variables.items() if one.dims[:1] == (along,)]
        columns = {str(name).removeprefix(start): values[str(name)] for name in names}
        rows = zip(*columns.values(), strict=True)
        made[key] = [dict(zip(columns, row, strict=True)) for row in rows]
    return made


def _dataset_html(data: xarray.Dataset) -> str:
    """HTML of a picture with a table; of a Dataset that rodgen did not make, xarray's own."""
    html: str = dataset_drawing().html(data)
    return html


@cache
def register_accessor() -> None:
    """Register the accessor `rodgen` of xarray's Datasets, and their display in notebooks.
    Functions that make or read Datasets call it."""
    import xarray  # only where it is there already: it takes long to import

    register: Any = xarray.register_dataset_accessor  # which has no types
    register("rodgen")(DatasetResult)
    register_notebook_display(xarray.Dataset)


def register_notebook_display(dataset: type) -> None:
    """Register, in a notebook, the display of Datasets as a picture with a table."""
    notebook = sys.modules.get("IPython")
    shell: Any = notebook and notebook.get_ipython()
    if shell:
        shell.display_formatter.formatters["text/html"].for_type(dataset, _dataset_html)
